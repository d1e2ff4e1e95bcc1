"""Bracket the critical amplitudes, with the pseudo-static estimate and the sliding block's beside them, and decide the paper's claim."""

from collections.abc import Mapping, Sequence
from typing import Any

from sph.experiments.trigger.critical import CRITICAL, critical_table
from sph.experiments.trigger.points import read_points
from sph.jobs.log import Job, job_log
from sph.measures.metrics import MetricSettings, class_displacement
from sph.paper.claims import decide_trigger
from sph.scene.schema import make_scene
from sph.storage import trajectory
from sph.study.baseline import newmark_amplitude
from sph.study.planned import Planned
from sph.study.tables import flat_dataset, write_csv


def measure_trigger(
    path_to_points: str,
    path_to_yields: Mapping[str, str],
    slopes: Sequence[Planned],
    scenes: Mapping[str, Mapping[str, Any]],
    classes: Sequence[str],
    settings: Mapping[str, Any],
    attrs: Mapping[str, Any],
    paths_to_tables: Sequence[str],
    path_to_claim: str,
) -> None:
    """One row a case, S_R, gamma and class; yield acceleration and scene by case, in whose order the planned scenes of the searches are;
    ``attrs`` go into the netCDF, the first of the tables."""
    chosen, estimates = MetricSettings(**settings), {}
    for (case, path), slope in zip(path_to_yields.items(), slopes, strict=True):
        scene, yields = make_scene(scenes[case]), float(slope.read(path).attrs["value"])
        estimates[case] = {
            name: {
                "yield_acceleration": yields,
                "newmark_amplitude": newmark_amplitude(scene, yields, class_displacement(name, scene, chosen)),
            }
            for name in classes
        }
    table = critical_table(read_points(path_to_points), classes, estimates)
    trajectory.write(paths_to_tables[0], flat_dataset(table, CRITICAL, attrs))
    write_csv(table, paths_to_tables[1])
    write_csv(decide_trigger(table), path_to_claim)


if __name__ == "__main__":
    snakemake: Job
    with job_log(snakemake.log[0]):
        measure_trigger(
            snakemake.input.points,
            dict(zip(snakemake.params.scenes, snakemake.input.yields, strict=True)),
            snakemake.params.slopes,
            snakemake.params.scenes,
            snakemake.params.classes,
            snakemake.params.settings,
            snakemake.params.attrs,
            [snakemake.output.nc, snakemake.output.csv],
            snakemake.output.claim,
        )
