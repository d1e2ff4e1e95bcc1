"""Fit the surrogate to the sample, cross-validate it and compute the Sobol' indices."""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from sph.analysis.sensitivity import Axis, Quantity, SobolSettings
from sph.analysis.sensitivity_tables import read_sample
from sph.analysis.surrogate import sobol_tables
from sph.analysis.tables import write_csv
from sph.command.job import job_log


def fit_surrogate(
    path_to_sample: str,
    path_to_factors: str,
    axes: Sequence[Mapping[str, Any]],
    quantities: Sequence[Mapping[str, Any]],
    settings: Mapping[str, Any],
    seed: int,
    path_to_indices: str,
    path_to_validation: str,
) -> None:
    """Indices, a row a metric and factor, and predictions of unseen runs, a row a metric and run."""
    factors, metrics = [Axis(**axis) for axis in axes], [Quantity(**quantity) for quantity in quantities]
    sample, chosen = read_sample(path_to_sample, factors, metrics), json.loads(Path(path_to_factors).read_text())
    varied = [axis for axis in factors if axis.name in chosen]
    indices, validation = sobol_tables(sample, varied, metrics, SobolSettings(**settings), seed)
    write_csv(indices, path_to_indices)
    write_csv(validation, path_to_validation)


if __name__ == "__main__":
    with job_log(snakemake.log[0]):  # type: ignore[name-defined]
        fit_surrogate(
            snakemake.input.sample,  # type: ignore[name-defined]
            snakemake.input.factors,  # type: ignore[name-defined]
            snakemake.params.axes,  # type: ignore[name-defined]
            snakemake.params.quantities,  # type: ignore[name-defined]
            snakemake.params.settings,  # type: ignore[name-defined]
            snakemake.params.seed,  # type: ignore[name-defined]
            snakemake.output.indices,  # type: ignore[name-defined]
            snakemake.output.validation,  # type: ignore[name-defined]
        )
