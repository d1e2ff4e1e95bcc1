"""Weaker soil and stronger shaking.

Weaker soil must **never move less**.  A coarse slope is cut into particles by its lattice, and that is the chance in its displacement; it
is bounded by the same two slopes on ``LATTICES``: weaker soil has moved less only if on every lattice it moved less than the stronger
on any.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from answers import (
    Case,
    first_failure,
    mean_displacement,
    same_until,
)
from relation import relation, shaken
from scenes import GRAVITY_STAGE, TIME_STEP, Data

from sph.scene.configuration import merge
from sph.solver.state import ARMED

LATTICES = (1.0, 0.92, 0.96, 1.04, 1.08)
"""Spacings, over that of the scene, on which chance is looked for."""


def weaker(data: Data, share: float, cohesion: float = 0.0) -> Data:
    """A scene with a share of the cohesion and of tan(phi) of every soil it names, and so much more ``cohesion`` (kPa)."""

    def soil(own: Data) -> Data:
        changed = dict(own)
        if "cohesion" in own:
            changed["cohesion"] = share * own["cohesion"] + cohesion
        if "friction_angle" in own:
            changed["friction_angle"] = math.degrees(math.atan(share * math.tan(math.radians(own["friction_angle"]))))
        return changed

    layers = {name: {**layer, "soil": soil(layer["soil"])} for name, layer in data.get("layers", {}).items()}
    return {**data, "soil": soil(data["soil"]), **({"layers": layers} if layers else {})}


def never_less(case: Case, strong: Data, weak: Data) -> None:
    """Assert that the weaker of two scenes moves no less than the stronger by more than chance, as ``LATTICES`` show it.

    One pair in order is enough: the two ranges then meet, or lie as they should.
    """

    def moved(data: Data) -> Iterator[float]:
        for size in LATTICES:
            result = case.run(merge(data, {"numerics": {"spacing": size * data["numerics"]["spacing"]}}))
            yield math.inf if result.status == "diverged" else mean_displacement(result)

    of_strong, of_weak = [], []
    for from_strong, from_weak in zip(moved(strong), moved(weak), strict=True):
        of_strong.append(from_strong)
        of_weak.append(from_weak)
        if max(of_weak) >= min(of_strong):
            return
    raise AssertionError(
        f"the weaker moves {min(of_weak):.4g} to {max(of_weak):.4g} m, the stronger {min(of_strong):.4g} to {max(of_strong):.4g} m"
    )


@relation()
def weaker_soil_never_moves_less(case: Case, chance: np.random.Generator) -> None:
    """Less cohesion and tan(phi), down to none, in every soil: the soil moves no less, gravity stage included, by more than chance."""
    low, high = sorted(chance.choice([1.0, 0.8, 0.6, 0.4, 0.2, 0.1, 0.05, 0.0], 2, replace=False).tolist())
    never_less(case, weaker(case.data, high), weaker(case.data, low))


@relation()
def weaker_remains_never_move_less(case: Case, chance: np.random.Generator) -> None:
    """A smaller S_R, of the coupling and of the layers: the soil moves no less by more than chance."""
    low, high = sorted(chance.uniform(0.0, 1.0, 2).tolist())
    layers = {name: {**layer, "S_R": None} for name, layer in case.data.get("layers", {}).items()}
    data = {**case.data, **({"layers": layers} if layers else {})}
    never_less(case, *(merge(data, {"coupling": {"S_R": ratio}}) for ratio in (high, low)))


@relation(shaken())
def stronger_shaking_never_fails_later(case: Case, chance: np.random.Generator) -> None:
    """The same motion with a larger amplitude: the first failure comes no later, by one time step at most.

    Soil is elastic before it first fails, so that its stress is that of gravity and a part in proportion to the shaking.  A yield surface
    is convex: if it is reached from inside with some shaking, it has been reached with more.  What is not linear, artificial viscosity
    among approaching particles and soil at yield beside the walls, is left a time step.
    """
    motion, factor = case.data["motion"], float(chance.choice([1.01, 1.2, 1.5, 2.0]))
    change = {"motion.amplitude": factor * motion["amplitude"]} if "amplitude" in motion else {"motion.factor": factor * motion["factor"]}
    result = case.run(case.changed(change))
    later = first_failure(result) - first_failure(case.result)
    assert math.isnan(later) or later <= 1.5 * TIME_STEP, (
        f"{factor:g} times the shaking: first failure at {first_failure(result):g} s, not {first_failure(case.result):g} s"
    )


@relation(shaken())
def weaker_soil_never_fails_later(case: Case, chance: np.random.Generator) -> None:
    """Less cohesion and tan(phi) in soil so firm that it stays elastic under gravity: the first failure comes no later, exactly.

    The two runs have the same bits until the weaker fails.
    """
    firm = weaker(case.data, 1.0, cohesion=80.0)
    pair = firm, weaker(firm, float(chance.choice([0.99, 0.9, 0.7])))
    stages = [case.run({**data, "duration": GRAVITY_STAGE, "motion": {"kind": "none"}}).restart for data in pair]
    if not stages[0].equals(stages[1]) or (stages[0]["phase"] != ARMED).any():
        return
    strong, weak = map(case.run, pair)
    assert first_failure(weak) <= first_failure(strong), (first_failure(weak), first_failure(strong))
    same_until(strong.trajectory, weak.trajectory, first_failure(weak))
