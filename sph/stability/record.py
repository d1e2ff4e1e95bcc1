"""A search as a file: its trials along ``trial``; what it found, scene and versions in the attributes.

A search at the scene's own spacing has the bracket of its value.  One at two spacings (``sph.stability.extrapolation``) has its value at
spacing 0 with ``error`` and ``how``, and the bracket at the fine spacing.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from sph.scene.schema import Scene
from sph.solver.compiled.jit import PACKAGE, solver_digest
from sph.stability.extrapolation import At, Extrapolated, extrapolated
from sph.stability.safety import DEFAULT_RULE, critical_strength_ratio, factor_of_safety, yield_acceleration
from sph.stability.search import Search, Trial
from sph.stability.standing import static_scene
from sph.storage import trajectory
from sph.storage.files import alone, beside, tidy
from sph.storage.netcdf import Array, Group
from sph.storage.sources import sources_digest


class Limit(NamedTuple):
    """A limit of a slope that can be searched for."""

    name: str
    symbol: str
    unit: str
    find: Callable[..., Search]

    @property
    def by(self) -> str:
        """What files and studies call it."""
        return self.name.replace(" ", "_")

    @property
    def code(self) -> str:
        """Of its finding."""
        return self.name.replace(" ", "-")


SEARCHES: dict[str, Limit] = {
    limit.by: limit
    for limit in (
        Limit("yield acceleration", "a", "m/s2", yield_acceleration),
        Limit("factor of safety", "F", "-", factor_of_safety),
        Limit("critical strength ratio", "S_R", "-", critical_strength_ratio),
    )
}
"""What can be searched for."""
YIELD, SAFETY, WEAKENED = SEARCHES
SLOPE_LIMITS = (YIELD, SAFETY)
"""The limits of a slope: every study searches the first with particles as fine as its own, the other where that is asked for; before its
runs both at coarse spacings."""
Made = list[tuple[At, Trial]]
"""Trials and where they were made."""
NOTHING = Search(math.nan, math.nan, ())


def run_search(
    scene: Scene,
    by: str,
    report: Callable[[At, Trial], None] = lambda at, trial: None,
    known: Mapping[At, Mapping[float, Trial]] | None = None,
    spacings: Callable[[Scene], tuple[float, float]] | None = None,
) -> Group:
    """Search the limit of a scene by one of ``SEARCHES``; a limit that does not exist is NaN, with the reason in the attributes.

    The search is at the scene's own spacing, or at the coarse and the fine one (m) that ``spacings`` gives, and extrapolates.
    """
    limit: Search | Extrapolated
    find = SEARCHES[by].find
    try:
        if spacings:
            static_scene(scene, DEFAULT_RULE)  # refuses a spacing too coarse for any test, though those of the search are finer
            limit = extrapolated(
                find, scene, report=lambda spacing, strength, trial: report((spacing, strength), trial), asked=spacings(scene), known=known
            )
        else:
            at = (scene.numerics.spacing, 1.0)
            limit = find(scene, report=lambda trial: report(at, trial), known=(known or {}).get(at))
    except ValueError as error:
        return search_group(scene, by, NOTHING, str(error)).assign_attrs(extrapolates=int(bool(spacings)))
    return search_group(scene, by, limit).assign_attrs(extrapolates=int(bool(spacings)))


def search_to_file(
    scene: Scene, by: str, path: Path | str, report: Callable[[Trial], None], spacings: Callable[[Scene], tuple[float, float]] | None = None
) -> None:
    """Search and write the trials; a search that was killed does not repeat those it had made.

    They are in a checkpoint as that of a run, written after each and told by a digest (see ``sph.solver.checkpoint``).
    """
    path = Path(path)
    solver = solver_digest()
    digest = hashlib.sha256(f"{search_digest()} {by} {bool(spacings)} {scene.model_dump_json()}".encode()).hexdigest()[:16]
    kept, made = beside(path, "checkpoint"), Made()

    def keep(at: At, trial: Trial) -> None:
        made.append((at, trial))
        report(trial)
        so_far = trials_group(scene, made)
        with suppress(OSError):  # a disk that is full for this may have room at the end
            trajectory.write(kept, so_far.assign_attrs(run_digest=digest))

    with alone(path, "run"):
        known: dict[At, dict[float, Trial]] = {}
        for at, trial in read_trials(kept, digest):
            known.setdefault(at, {})[trial.value] = trial
        group = run_search(scene, by, keep, known, spacings)
        trajectory.write(path, group.assign_attrs(solver_digest=solver))
        kept.unlink(missing_ok=True)
        tidy(kept)


def read_trials(path: Path, digest: str) -> Made:
    """The trials in a checkpoint, with where they were made; none if it is not of this digest."""
    try:
        kept = trajectory.read(path)
    except ValueError:
        return []
    if kept.attrs.get("run_digest") != digest:
        return []
    rows = zip(*(kept[name].values.tolist() for name in (*WHERE, *Trial._fields)), strict=True)
    return [((spacing, strength), Trial(*row)._replace(stands=bool(row[1]))) for spacing, strength, *row in rows]


def search_digest() -> str:
    """Digest of what decides a search: the solver and the files beside this one."""
    folder = PACKAGE / "stability"
    return sources_digest(folder.glob("*.py"), folder, solver_digest())


def search_group(scene: Scene, by: str, limit: Search | Extrapolated, reason: str = "") -> Group:
    """The trials of a search, and what it found."""
    facts: dict[str, Any] = {"by": by, "value": limit.value, "reason": reason}
    if isinstance(limit, Extrapolated):
        made, bracket = limit.trials, limit.searches[1]
        facts |= {"error": limit.error, "sensitivity": limit.sensitivity, "how": limit.how}
    else:
        made, bracket = [((scene.numerics.spacing, 1.0), trial) for trial in limit.trials], limit
    cost = math.fsum(trial.wall_time for _, trial in made)
    return trials_group(scene, made).assign_attrs(**facts, stood=bracket.stood, failed=bracket.failed, wall_time_s=cost)


WHERE = ("spacing", "strength")
"""Columns of where a trial was made."""


def trials_group(scene: Scene, made: Made) -> Group:
    """Trials and where they were made, with the attributes of a run of the scene."""
    columns = {name: np.array([at[place] for at, _ in made], dtype=float) for place, name in enumerate(WHERE)}
    columns |= {name: np.array([getattr(trial, name) for _, trial in made]) for name in Trial._fields}
    columns["stands"] = columns["stands"].astype("int8")
    return Group({name: Array(("trial",), values) for name, values in columns.items()}, trajectory.run_attributes(scene))
