"""The words of verdicts, as tables hold them and the page marks them."""

from __future__ import annotations

HOLDS = "holds"
FAILS = "fails"
MISSES = "misses"
"""A computed quantity lies outside its tolerance."""
NOT_YET = "not yet"
"""Needs results that are still to be made."""
NOT_COVERED = "not covered"
"""The runs that there are do not decide it."""
