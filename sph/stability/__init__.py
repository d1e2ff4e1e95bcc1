"""Stability of a slope: static tests by strength reduction, and the search for the limit between standing and failing.

``standing``  the static test of a scene, and the rule by which it stands or has failed
``search``    bracket and bisection between what stands and what fails
``safety``    factor of safety, critical strength ratio and yield acceleration
"""
