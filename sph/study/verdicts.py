"""The words of verdicts, as tables hold them and the page marks them."""

from __future__ import annotations

from collections.abc import Mapping

HOLDS = "holds"
AT_LEAST = "holds at least"
"""Holds with a lower bound where the statement is of the value itself."""
FITTED = "holds, fitted"
"""Holds, but the model was chosen because it does: no test of it."""
CONSTRUCTED = "true by construction"
"""Cannot fail in this model: no test of it either."""
FAILS = "fails"
MISSES = "misses"
"""A computed quantity lies outside its tolerance."""
NOT_YET = "not yet"
"""Needs results that are still to be made."""
NOT_COVERED = "not covered"
"""The runs that there are do not decide it."""


def tally(verdicts: Mapping[int, str]) -> tuple[str, str]:
    """How many statements hold, and which ones have another verdict, in words; ``verdicts`` by their numbers."""
    others = [verdict for verdict in dict.fromkeys(verdicts.values()) if verdict != HOLDS]
    named = (f"{other}: {', '.join(str(number) for number, verdict in verdicts.items() if verdict == other)}" for other in others)
    return f"{list(verdicts.values()).count(HOLDS)} of {len(verdicts)} hold", "; ".join(named)
