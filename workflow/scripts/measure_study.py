"""Measure the runs of a part of a study."""

from collections.abc import Mapping, Sequence
from typing import Any

from sph import trajectory
from sph.analysis.advice import expected_metrics
from sph.analysis.baseline import baseline_metrics
from sph.analysis.dimensions import CASE
from sph.analysis.metrics import MetricSettings, measure
from sph.analysis.tables import Layout, study_rows, write_csv
from sph.analysis.trade import scheme, settings_text
from sph.command.job import job_log


def measure_study(
    paths_to_runs: Sequence[str],
    path_to_yield: str | None,
    points: Mapping[str, Mapping[str, str]],
    layout: Layout,
    settings: Mapping[str, Any],
    path_to_csv: str,
) -> None:
    """One row a run: its point, as written, and its metrics; ``points`` by the name of the run, in the order of the paths."""
    chosen = MetricSettings(**settings)
    yields = float(trajectory.read(path_to_yield).attrs["value"]) if path_to_yield else float("nan")
    expected: dict[str, dict[str, float]] = {}
    rows = []
    for path, (name, point) in zip(paths_to_runs, points.items(), strict=True):
        run = trajectory.read(path)
        scene = trajectory.scene_of(run)
        numerics = settings_text(scheme(scene))
        if numerics not in expected:
            expected[numerics] = expected_metrics(scene)
        row = {**point, **measure(run, chosen), **expected[numerics], **baseline_metrics(scene, yields)}
        rows.append({CASE: name, **row} if layout.named else row)
    write_csv(study_rows(rows, layout), path_to_csv)


if __name__ == "__main__":
    with job_log(snakemake.log[0]):  # type: ignore[name-defined]
        measure_study(
            snakemake.input.runs,  # type: ignore[name-defined]
            snakemake.input.get("yields"),  # type: ignore[name-defined]
            snakemake.params.points,  # type: ignore[name-defined]
            snakemake.params.layout,  # type: ignore[name-defined]
            snakemake.params.settings,  # type: ignore[name-defined]
            snakemake.output[0],  # type: ignore[name-defined]
        )
