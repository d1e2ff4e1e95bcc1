"""Screen the factors by their elementary effects."""

from collections.abc import Mapping, Sequence
from typing import Any

from sph.analysis.elementary_effects import morris_table
from sph.analysis.sensitivity import Axis, Quantity
from sph.analysis.sensitivity_tables import read_sample
from sph.analysis.tables import write_csv
from sph.command.job import job_log


def screen_factors(
    path_to_sample: str,
    axes: Sequence[Mapping[str, Any]],
    quantities: Sequence[Mapping[str, Any]],
    resamples: int,
    seed: int,
    path_to_table: str,
) -> None:
    """One row a metric and factor."""
    factors, metrics = [Axis(**axis) for axis in axes], [Quantity(**quantity) for quantity in quantities]
    write_csv(morris_table(read_sample(path_to_sample, factors, metrics), factors, metrics, resamples, seed), path_to_table)


if __name__ == "__main__":
    with job_log(snakemake.log[0]):  # type: ignore[name-defined]
        screen_factors(
            snakemake.input.sample,  # type: ignore[name-defined]
            snakemake.params.axes,  # type: ignore[name-defined]
            snakemake.params.quantities,  # type: ignore[name-defined]
            snakemake.params.resamples,  # type: ignore[name-defined]
            snakemake.params.seed,  # type: ignore[name-defined]
            snakemake.output[0],  # type: ignore[name-defined]
        )
