"""Measure every run of a study and write its table."""

from collections.abc import Mapping, Sequence
from typing import Any

from sph import trajectory
from sph.analysis.advice import expected_metrics, expected_sentence
from sph.analysis.baseline import baseline_metrics
from sph.analysis.metrics import MetricSettings, measure
from sph.analysis.tables import study_table, write_study
from sph.command.job import job_log


def measure_study(
    paths_to_runs: Sequence[str],
    path_to_yield: str,
    points: Sequence[Mapping[str, str]],
    settings: Mapping[str, Any],
    attrs: Mapping[str, str],
    path_to_nc: str,
    path_to_csv: str,
) -> None:
    """One row a run: its grid point, as written, and its metrics; ``attrs`` go into the netCDF."""
    chosen = MetricSettings(**settings)
    first = trajectory.read(paths_to_runs[0])
    scene = trajectory.scene_of(first)
    expected = expected_metrics(scene)
    yields = float(trajectory.read(path_to_yield).attrs["value"])
    rows = []
    for path, point in zip(paths_to_runs, points, strict=True):
        run = trajectory.read(path)
        rows.append({**point, **measure(run, chosen), **expected, **baseline_metrics(trajectory.scene_of(run), yields)})
    facts = {name: first.attrs[name] for name in ("source", "versions", "scene")} | {"expected_error": expected_sentence(scene)}
    write_study(study_table(rows), path_to_nc, path_to_csv, dict(attrs) | facts)


if __name__ == "__main__":
    with job_log(snakemake.log[0]):  # type: ignore[name-defined]
        measure_study(
            snakemake.input.runs,  # type: ignore[name-defined]
            snakemake.input.yields,  # type: ignore[name-defined]
            snakemake.params.points,  # type: ignore[name-defined]
            snakemake.params.settings,  # type: ignore[name-defined]
            {"title": snakemake.params.name, "fidelity": snakemake.params.fidelity},  # type: ignore[name-defined]
            snakemake.output.nc,  # type: ignore[name-defined]
            snakemake.output.csv,  # type: ignore[name-defined]
        )
