"""Measure every run of the ladder and write its tables."""

from collections.abc import Mapping, Sequence
from typing import Any

from sph.experiments.cost_accuracy.convergence import convergence_table
from sph.experiments.cost_accuracy.design import Rung
from sph.experiments.cost_accuracy.table import TRADE, ladder_table, measured_run
from sph.jobs.log import Job, job_log
from sph.measures.metrics import MetricSettings
from sph.storage import trajectory
from sph.study.machine import machine_class
from sph.study.planned import Planned
from sph.study.tables import flat_dataset, write_csv

TIMING = "solver's loop of whole runs on one core each, side by side on as many cores as the workflow was given; median of the repeats"


def measure_trade(
    paths_to_runs: Mapping[str, str],
    scenes: Mapping[str, Planned],
    rows: Sequence[Mapping[str, Any]],
    baseline: str,
    convergence_knob: str,
    settings: Mapping[str, Any],
    path_to_nc: str,
    path_to_csv: str,
    path_to_convergence: str,
) -> None:
    """One row a rung and case; paths and planned scenes by the name of the run."""
    chosen = MetricSettings(**settings)
    runs = {name: measured_run(scenes[name].read(path), chosen) for name, path in paths_to_runs.items()}
    ladder, machine = [Rung(**row) for row in rows], machine_class()
    frame = ladder_table(ladder, runs, baseline, machine)
    of_reference = next(row.runs[0] for row in ladder if row.reference)
    attrs = trajectory.read(paths_to_runs[of_reference]).attrs
    facts = {name: attrs[name] for name in ("source", "versions", "scene")} | {"machine": machine, "timing": TIMING, "baseline": baseline}
    write_csv(convergence_table(frame, convergence_knob), path_to_convergence)
    trajectory.write(path_to_nc, flat_dataset(frame, TRADE, facts))
    write_csv(frame, path_to_csv)


if __name__ == "__main__":
    snakemake: Job
    with job_log(snakemake.log[0]):
        measure_trade(
            dict(zip(snakemake.params.scenes, snakemake.input.runs, strict=True)),
            snakemake.params.scenes,
            snakemake.params.rows,
            snakemake.params.baseline,
            snakemake.params.convergence,
            snakemake.params.settings,
            snakemake.output.nc,
            snakemake.output.csv,
            snakemake.output.convergence,
        )
