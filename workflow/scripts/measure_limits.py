"""Measure what a change of one choice does."""

from collections.abc import Mapping, Sequence
from typing import Any

from sph import trajectory
from sph.analysis.limits import limits_table
from sph.analysis.metrics import MetricSettings
from sph.analysis.tables import write_csv
from sph.command.job import job_log


def measure_limits(paths_to_runs: Sequence[str], rows: Sequence[tuple[str, str]], settings: Mapping[str, Any], path_to_csv: str) -> None:
    """One row a change and case; the paths in the rows' order."""
    runs = [trajectory.read(path) for path in paths_to_runs]
    write_csv(limits_table([(change, case) for change, case in rows], runs, MetricSettings(**settings)), path_to_csv)


if __name__ == "__main__":
    with job_log(snakemake.log[0]):  # type: ignore[name-defined]
        measure_limits(
            snakemake.input.runs,  # type: ignore[name-defined]
            snakemake.params.rows,  # type: ignore[name-defined]
            snakemake.params.settings,  # type: ignore[name-defined]
            snakemake.output[0],  # type: ignore[name-defined]
        )
