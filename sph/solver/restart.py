"""Going on from an earlier run: what its file keeps of the state, and what may have changed since.

A run that goes on from a restart equals an uninterrupted one bit for bit: the restart holds the neighbour lists' reference
positions, and both runs use the same compiled code.
"""

from __future__ import annotations

from collections.abc import Iterable
from fnmatch import fnmatchcase
from pathlib import Path

import numpy as np

from sph.scene.configuration import differences, one_line
from sph.scene.schema import Scene
from sph.solver.early_stop import quiet_from
from sph.solver.simulation import Simulation
from sph.solver.state import FAILED
from sph.solver.terms import restart_dims
from sph.storage import trajectory
from sph.storage.netcdf import Array, Group

BRANCH_KEYS = (
    "coupling.S_R",
    "coupling.gamma",
    "coupling.solid_after_failure",
    "coupling.softening.slip_at_residual",
    "coupling.softening.shape",
    "coupling.fluid_tension_limit",
    "layers.*.S_R",
    "layers.*.gamma",
    "layers.*.slip_at_residual",
)
"""Keys without effect before the first failure; * stands for a name."""
FREE_KEYS = ("name", "title", "duration")
"""Keys that a restarted run may change at any time."""


def restart_of(simulation: Simulation) -> Group:
    """What a run needs in order to go on from here."""
    dims = {"work": ("row",)} | restart_dims()
    arrays = {name: Array(dims.get(name, ("particle",))[-a.ndim :], a) for name, a in _kept(simulation).items()}
    return Group(arrays, {"step": simulation.step, "substeps": simulation.substeps})


def _kept(simulation: Simulation) -> dict[str, np.ndarray]:
    """The arrays of the state by name, but those of terms that the scene does not have."""
    return {name: array for name, array in simulation.state._asdict().items() if array.size}


def take_over(simulation: Simulation, old: Group, restart: Group, path: Path | str) -> None:
    """Put a simulation where the run of a file stopped; ValueError if it belongs to another scene."""
    missing = [name for name in _kept(simulation) if name not in restart] + ["step"] * ("step" not in restart.attrs)
    if missing:
        raise ValueError(f"{path}: its restart state lacks {', '.join(missing)}; it was written by another version, run it again")
    failed = bool((restart["phase"].values == FAILED).any())
    time = float(old["sample_time"].values[-1])
    check_restart(trajectory.scene_of(old, str(path)), simulation.scene, time, failed, path)
    simulation.step = int(restart.attrs["step"])
    wrong = [name for name, array in _kept(simulation).items() if restart[name].values.shape != array.shape]
    if wrong or simulation.step != simulation.scene.steps(time):
        raise ValueError(f"{path}: its restart state does not belong to its trajectory ({', '.join(wrong) or f'step {simulation.step}'})")
    for name, array in _kept(simulation).items():
        array[...] = restart[name].values
    substeps, most = int(restart.attrs.get("substeps", 1)), simulation.most_substeps
    if substeps > most:
        raise ValueError(f"{path}: its restart state divides the time step by {substeps}, at most by {most}; run it again")
    simulation.divide(substeps)
    simulation.limit = float(old["time_step_limit"].values[-1])


def check_restart(old: Scene, new: Scene, time: float, failed: bool, path: Path | str) -> None:
    """Refuse a restart whose past differs from the new scene's; ValueError names the keys."""
    free = FREE_KEYS + (() if failed else BRANCH_KEYS)
    if time <= old.gravity.duration + 0.5 * old.numerics.time_step:
        free += ("motion",)
    if time <= quiet_from(old) + 0.5 * old.numerics.time_step:
        free += ("early_stop",)
    bad = [
        one_line(f"{name}: {past!r} in the file, {future!r} in the scene")
        for name, (past, future) in differences(old.model_dump(), new.model_dump()).items()
        if not is_among(name, free)
    ]
    if bad:
        raise ValueError(f"{path}: cannot continue from this run at {time:g} s, since its scene differs in\n  " + "\n  ".join(bad))
    if time > new.duration:
        raise ValueError(f"{path}: the run is already at {time:g} s, later than duration: {new.duration} s")


def is_among(name: str, keys: Iterable[str]) -> bool:
    """Whether a dotted key, or the section that it stands in, is one of these keys."""
    return any(fnmatchcase(part, key) for key in keys for part in (name, name.split(".")[0]))
