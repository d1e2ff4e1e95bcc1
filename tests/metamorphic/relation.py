"""What a relation between two answers is: how a scene is said in other words or changed, and how its answer must follow.

A relation is a function that takes a ``Case`` and raises AssertionError where it does not hold; its docstring says what must follow.
Most ask for the same bits, or for the same to rounding (see ``answers``).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from answers import Case


class Relation(NamedTuple):
    """One relation."""

    name: str
    holds: Callable[[Case, np.random.Generator], None]
    fits: Callable[[Case], bool]
    """whether it says something of a scene"""

    def check(self, case: Case) -> None:
        """Raise AssertionError where it does not hold, and ValueError where the other scene is refused."""
        self.holds(case, case.generator(self.name))


RELATIONS: dict[str, Relation] = {}


def relation(fits: Callable[[Case], bool] = lambda case: True) -> Callable[[Any], Any]:
    """Register a function as a relation between scenes that it fits."""

    def register(holds: Callable[[Case, np.random.Generator], None]) -> Any:
        RELATIONS[holds.__name__] = Relation(holds.__name__, holds, fits)
        return holds

    return register


def is_a(*shapes: str) -> Callable[[Case], bool]:
    """Whether a scene has one of these shapes."""
    return lambda case: case.data["geometry"]["shape"] in shapes


def shaken(*kinds: str) -> Callable[[Case], bool]:
    """Whether a scene is shaken, by one of these motions if some are named."""
    return lambda case: case.data["motion"]["kind"] in kinds if kinds else case.data["motion"]["kind"] != "none"


def default_walls(case: Case) -> bool:
    """Whether a scene may have layers without needing another variant of the solver."""
    return "walls" not in case.data
