"""A search as a file: its trials along ``trial``; bracket, scene and versions in the attributes."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from sph.scene.schema import Scene, make_scene
from sph.solver.compiled.jit import solver_digest
from sph.stability.safety import critical_strength_ratio, factor_of_safety, yield_acceleration
from sph.stability.search import Search, Trial
from sph.storage import trajectory
from sph.storage.files import alone, beside, tidy

SEARCHES: dict[str, Callable[..., Search]] = {
    "factor_of_safety": factor_of_safety,
    "critical_strength_ratio": critical_strength_ratio,
    "yield_acceleration": yield_acceleration,
}
"""What can be searched for, by name."""


def run_search(
    scene: Mapping[str, Any], by: str, report: Callable[[Trial], None] | None = None, known: Mapping[float, Trial] | None = None
) -> xr.Dataset:
    """Search the limit of a scene by one of ``SEARCHES``; a limit that does not exist is NaN, with the reason in the attributes."""
    built = make_scene(scene)
    try:
        found, reason = SEARCHES[by](built, report=report, known=known), ""
    except ValueError as error:
        found, reason = Search(math.nan, math.nan, ()), str(error)
    return search_dataset(built, by, found, reason)


def search_to_file(scene: Mapping[str, Any], by: str, path: Path | str, report: Callable[[Trial], None]) -> None:
    """Search and write the trials; a search that was killed does not repeat those it had made.

    They are in a checkpoint as that of a run, written after each and told by a digest (see ``sph.solver.checkpoint``).
    """
    path = Path(path)
    built, solver = make_scene(scene), solver_digest()
    digest = hashlib.sha256(f"{sources_digest()} {by} {built.model_dump_json()}".encode()).hexdigest()[:16]
    kept, made = beside(path, "checkpoint"), list[Trial]()

    def keep(trial: Trial) -> None:
        made.append(trial)
        report(trial)
        so_far = search_dataset(built, by, Search(math.nan, math.nan, tuple(made)))
        with suppress(OSError):  # a disk that is full for this may have room at the end
            trajectory.write(kept, so_far.assign_attrs(run_digest=digest))

    with alone(path, "run"):
        found = run_search(scene, by, keep, {trial.value: trial for trial in read_trials(kept, digest)})
        trajectory.write(path, found.assign_attrs(solver_digest=solver))
        kept.unlink(missing_ok=True)
        tidy(kept)


def read_trials(path: Path, digest: str) -> list[Trial]:
    """The trials in a checkpoint; none if it is not of this digest."""
    try:
        ds = trajectory.read(path)
    except ValueError:
        return []
    if ds.attrs.get("run_digest") != digest:
        return []
    rows = zip(*(ds[name].values.tolist() for name in Trial._fields), strict=True)
    return [trial._replace(stands=bool(trial.stands)) for trial in (Trial(*row) for row in rows)]


def sources_digest() -> str:
    """Digest of what decides a search: the solver and the files beside this one."""
    digest = hashlib.sha256(solver_digest().encode())
    for path in sorted(Path(__file__).parent.glob("*.py")):
        digest.update(path.read_bytes())
    return digest.hexdigest()


def search_dataset(scene: Scene, by: str, found: Search, reason: str = "") -> xr.Dataset:
    """The trials of a search."""
    columns = {name: ("trial", np.array([getattr(trial, name) for trial in found.trials])) for name in Trial._fields}
    columns["stands"] = ("trial", columns["stands"][1].astype("int8"))
    cost = math.fsum(trial.wall_time for trial in found.trials)
    facts = {"by": by, "stood": found.stood, "failed": found.failed, "value": found.value, "reason": reason, "wall_time_s": cost}
    return xr.Dataset(columns, attrs=trajectory.run_attributes(scene) | facts)
