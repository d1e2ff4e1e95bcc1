"""The simulations of targets beside the study that have been started: trigger, maps, confirm and sensitivity (``sph status``).

The rounds of a search follow from each other, so that its runs are known round by round; those of the sample of indices and of its
confirmation are known once the screening has chosen the factors, those of a back-analysis once its points are.
"""

from __future__ import annotations

import functools
import os
from collections.abc import Iterator, Sequence
from pathlib import Path

import sph
from sph.command.status import Job, Kind
from sph.experiments.sensitivity.design import BACK_FILE, FACTORS_FILE, load_sensitivity
from sph.experiments.trigger.design import load_trigger
from sph.scene.schema import make_scene
from sph.study.dimensions import point_name
from sph.study.plan import Plan


def target_jobs(plan: Plan, folder: Path) -> list[Job]:
    """Runs of the targets whose tables lie in the folder of a study, without those that are the study's own.

    ValueError names what is wrong with a configuration of theirs.
    """
    names = ("trigger/rounds/*-wanted.csv", "sensitivity", f"sensitivity/{FACTORS_FILE}", f"sensitivity/{BACK_FILE}")
    tables = [table for name in names for table in folder.glob(name)]
    return list(_listed(plan, folder, tuple((table, table.stat().st_mtime_ns) for table in tables)))


@functools.lru_cache(maxsize=1)
def _listed(plan: Plan, folder: Path, tables: tuple[tuple[Path, int], ...]) -> tuple[Job, ...]:
    """The runs that these ``tables``, with the times of their last change, ask for."""
    folders = [folder.parents[2], Path(sph.__file__).parents[1]]
    found: dict[tuple[str, str], Job] = {}
    for job in (*_searched(plan, folder, folders), *_sampled(plan, folder, folders)):
        found.setdefault((job.place, job.file), job)
    return tuple(found.values())


def _searched(plan: Plan, folder: Path, folders: Sequence[Path]) -> Iterator[Job]:
    if not (folder / "trigger").is_dir():
        return
    trigger, own = load_trigger(plan.experiment_file("trigger"), plan, folders), plan.files()
    for target, case, at, point in trigger.asked(folder.parents[2]):
        name = point_name(point)
        if f"{at}/runs/{name}.nc" in own:
            continue
        scene = trigger.plans[at].built(**point)
        group = f"{target} {case} {point[trigger.trigger.intensity.dimension]}"
        yield Job(Kind.RUN, group, name, f"runs/{name}.nc", scene, os.path.relpath(at, plan.folder), target)


def _sampled(plan: Plan, folder: Path, folders: Sequence[Path]) -> Iterator[Job]:
    place = folder / "sensitivity"
    if not place.is_dir():
        return
    sensitivity = load_sensitivity(plan.experiment_file("sensitivity"), plan, folders, check=False)
    for name, scene in sensitivity.all_scenes(place).items():
        made = make_scene(scene, f"{sensitivity.origin}: {name}")
        yield Job(Kind.RUN, f"sensitivity {name.partition('/')[0]}", name, f"runs/{name}.nc", made, "sensitivity", "sensitivity")
