"""Bracket the critical intensities, with the pseudo-static estimate and the sliding block's beside them."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

from sph.experiments.trigger.critical import coarser_cases, critical_columns, critical_table
from sph.experiments.trigger.design import INTENSITIES, Searched
from sph.experiments.trigger.points import read_points
from sph.jobs.log import Job, job_log
from sph.measures.metrics import MetricSettings, class_displacement
from sph.scene.schema import make_scene
from sph.storage import trajectory
from sph.study.baseline import newmark_factor
from sph.study.planned import Planned
from sph.study.tables import flat_dataset, write_csv


def measure_trigger(
    path_to_points: str,
    paths_to_yields: Sequence[str],
    slopes: Sequence[Planned],
    scenes: Mapping[str, Mapping[str, Any]],
    classes: Sequence[str],
    settings: Mapping[str, Any],
    searched: Searched,
    highest: float,
    attrs: Mapping[str, Any],
    paths_to_tables: Sequence[str],
) -> None:
    """One row a case, value of the other dimensions and class; scene at the ``highest`` intensity by case, in whose order the planned
    scenes of the searches for a yield acceleration are; ``attrs`` go into the netCDF, the first of the tables.

    Without files of such searches the values make more than one slope, and the estimates are NaN.
    """
    chosen, estimates, power = MetricSettings(**settings), {}, INTENSITIES[searched.intensity_name]
    built = {case: make_scene(data) for case, data in scenes.items()}
    for number, (case, scene) in enumerate(built.items()):
        yields = float(slopes[number].read(paths_to_yields[number]).attrs["value"]) if paths_to_yields else math.nan
        factors = {name: newmark_factor(scene, yields, class_displacement(name, scene, chosen)) for name in classes}
        estimates[case] = {
            name: {"yield_acceleration": yields, "newmark_intensity": highest * factor ** (1.0 / power)} for name, factor in factors.items()
        }
    table = critical_table(read_points(path_to_points), classes, estimates, searched, coarser_cases(built))
    trajectory.write(paths_to_tables[0], flat_dataset(table, critical_columns(searched), attrs))
    write_csv(table, paths_to_tables[1])


if __name__ == "__main__":
    snakemake: Job
    with job_log(snakemake.log[0]):
        measure_trigger(
            snakemake.input.points,
            snakemake.input.get("yields", []),
            snakemake.params.slopes,
            snakemake.params.scenes,
            snakemake.params.classes,
            snakemake.params.settings,
            snakemake.params.searched,
            snakemake.params.highest,
            snakemake.params.attrs,
            [snakemake.output.nc, snakemake.output.csv],
        )
