"""The scene: what a user writes, validated before any work, and what it means: geometry, soil, motion, walls, numerics.

* ``schema``: the scene itself; ``configuration``: declaring, reading and checking keys
* ``geometry``, ``ground_line``, ``survey``, ``places``: the shape of the soil; ``soil``, ``layers``: what it is made of
* ``gravity``, ``motion``, ``ground_motion``, ``loading``: what acts on it, and at every time step
* ``walls``, ``numerics``: the box, and how it is computed; ``units``, ``strict_json``: what readers of files share
"""
