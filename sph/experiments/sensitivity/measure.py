"""The jobs of the sensitivity analysis and the back-analysis: samples, screening, indices, values that agree with what was observed.

Tables are given as the paths of their files; the rules are in ``workflow/rules/sensitivity.smk``.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import pandas as pd
import xarray as xr
from matplotlib.figure import Figure

from sph.experiments.sensitivity.back_analysis import (
    BACK_ANALYSIS,
    back_tables,
    confirmed_table,
    point_columns,
    posterior_columns,
    problem_of,
)
from sph.experiments.sensitivity.design import Point, chosen_factors
from sph.experiments.sensitivity.elementary_effects import MORRIS, influential, morris_table
from sph.experiments.sensitivity.factors import Axis, Observation, Quantity
from sph.experiments.sensitivity.figures import figure_cross_validation, figure_morris, figure_sobol, figure_tornado
from sph.experiments.sensitivity.figures_back import figure_back_analysis
from sph.experiments.sensitivity.schema import SobolSettings
from sph.experiments.sensitivity.surrogate import CROSS_VALIDATION, SOBOL, sobol_tables
from sph.experiments.sensitivity.tables import (
    TORNADO,
    confirmation_table,
    described,
    read_sample,
    sample_columns,
    sample_row,
    tornado_table,
)
from sph.measures.metrics import MetricSettings
from sph.output.run import Run
from sph.study.tables import flat_dataset, read_csv

Axes = Sequence[Axis]
Quantities = Sequence[Quantity]


def measure_sample(
    runs: Mapping[Any, Run], design: str, points: Mapping[str, Point], axes: Axes, quantities: Quantities, settings: MetricSettings
) -> pd.DataFrame:
    """One row per run, in the order of the points."""
    columns, of = sample_columns(axes, quantities), zip(points.items(), runs.values(), strict=True)
    return pd.DataFrame([sample_row(f"{design}/{name}", point, run, columns, settings) for (name, point), run in of])


def join_samples(samples: Sequence[str], axes: Axes, quantities: Quantities) -> tuple[xr.Dataset, pd.DataFrame]:
    """Every run of the sensitivity analysis: factors, metrics and how it ended. The status of a diverged run is 'diverged', its reason
    stands beside it, and no average holds it.
    """
    table = pd.concat([read_sample(path, axes, quantities) for path in samples], ignore_index=True)
    return flat_dataset(table, sample_columns(axes, quantities)), table


def screen_factors(sample: str, axes: Axes, quantities: Quantities, resamples: int, seed: int) -> pd.DataFrame:
    """Screening by elementary effects over the whole range of a factor, with 95 % bootstrap intervals over the trajectories. The steps that
    touch a diverged run are dropped and counted (column 'dropped').
    """
    return morris_table(read_sample(sample, axes, quantities), axes, quantities, resamples, seed)


def choose_factors(factors: Sequence[str] | None, sought: Sequence[str], share: float, screening: str = "") -> list[str]:
    """The factors that matter: those given, or those that the screening finds, with those sought."""
    names = influential(read_csv(screening, MORRIS, "a screening"), share) if screening else list(factors or ())
    return names + [name for name in sought if name not in names]


def measure_tornado(sample: str, axes: Axes, quantities: Quantities) -> pd.DataFrame:
    """The metrics at both ends of every factor, all others as in the scene."""
    return tornado_table(read_sample(sample, axes, quantities), axes, quantities)


def fit_surrogate(
    sample: str, factors: str, axes: Axes, quantities: Quantities, settings: SobolSettings, seed: int
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Sobol' indices through a Gaussian process, with 95 % intervals that hold the uncertainty of the surrogate and of the estimator, and
    with the surrogate's cross-validation (Q², RMSE). The verdict says where they are not to be trusted.
    """
    return sobol_tables(read_sample(sample, axes, quantities), _varied(axes, factors), quantities, settings, seed)


def confirm_sample(sample: str, confirming: str, axes: Axes, quantities: Quantities, fidelities: tuple[str, str]) -> pd.DataFrame:
    """The first points of the Sobol' sample at the study's fidelity and at another one."""
    own, other = (read_sample(path, axes, quantities) for path in (sample, confirming))
    return confirmation_table(own, other, quantities, fidelities)


def draw_morris(sample: str, screening: str, factors: str, axes: Axes, quantities: Quantities, fidelity: str) -> Figure:
    """Screening: standard deviation against mean absolute elementary effect of every factor over its whole range, with 95 % intervals. Full
    symbols: the factors of the Sobol' sample.
    """
    table, note = read_csv(screening, MORRIS, "a screening"), _note(read_sample(sample, axes, quantities), fidelity)
    return figure_morris(table, axes, chosen_factors(factors), note)


def draw_tornado(sample: str, tornado: str, axes: Axes, quantities: Quantities, fidelity: str) -> Figure:
    """The metrics at both ends of every factor, all others as in the scene."""
    return figure_tornado(read_csv(tornado, TORNADO, "a tornado"), axes, _note(read_sample(sample, axes, quantities), fidelity))


def draw_sobol(sample: str, indices: str, axes: Axes, quantities: Quantities, fidelity: str) -> Figure:
    """Sobol' indices with 95 % intervals, and the Q² of the surrogate behind them; what is not to be trusted is pale and says so."""
    return figure_sobol(_indices(indices), axes, _note(read_sample(sample, axes, quantities), fidelity))


def draw_cross_validation(sample: str, validation: str, indices: str, axes: Axes, quantities: Quantities, fidelity: str) -> Figure:
    """Prediction of the surrogate for every run, fitted without that run, with two standard deviations, against the computed value."""
    note = _note(read_sample(sample, axes, quantities), fidelity)
    return figure_cross_validation(_validation(validation), _indices(indices), note)


def analyse_back(
    sample: str,
    indices: str,
    validation: str,
    factors: str,
    axes: Axes,
    quantities: Quantities,
    sought: Sequence[str],
    observations: Sequence[Observation],
) -> tuple[pd.DataFrame, xr.Dataset, pd.DataFrame, xr.Dataset]:
    """Values of the parameters that agree with what was observed, by the surrogate of the sensitivity analysis: median, 90 % interval and
    best point. Every column is defined in docs/reference/files.md.

    One row per factor, twice; the points to be confirmed by runs; the points of the posterior.
    """
    problem = problem_of(axes, sought or chosen_factors(factors), observations)
    runs = read_sample(sample, axes, quantities)
    table, points, posterior = back_tables(problem, _varied(axes, factors), runs, _indices(indices), _validation(validation))
    return table, flat_dataset(table, BACK_ANALYSIS), points, flat_dataset(posterior, posterior_columns(problem))


def confirm_back(
    sample: str,
    result: str,
    confirmable: str,
    posterior: str,
    confirming: str,
    factors: str,
    axes: Axes,
    quantities: Quantities,
    sought: Sequence[str],
    observations: Sequence[Observation],
    fidelity: str,
) -> tuple[pd.DataFrame, Figure]:
    """Runs at the best point of a back-analysis and at the ends of the intervals, beside what was predicted there. Every column is defined
    in docs/reference/files.md.
    """
    problem = problem_of(axes, sought or chosen_factors(factors), observations)
    own, other = (read_sample(path, axes, quantities) for path in (sample, confirming))
    confirmed = confirmed_table(read_csv(confirmable, point_columns(axes), "the points of a back-analysis"), other, problem)
    with xr.open_dataset(posterior) as opened:
        points = opened.to_dataframe()
    table = read_csv(result, BACK_ANALYSIS, "a back-analysis")
    return confirmed, figure_back_analysis(table, points, confirmed, own, problem, _note(own, fidelity))


def _note(sample: pd.DataFrame, fidelity: str) -> str:
    return f"fidelity {fidelity} · {described(sample)}"


def _varied(axes: Axes, factors: str) -> list[Axis]:
    chosen = chosen_factors(factors)
    return [axis for axis in axes if axis.name in chosen]


def _indices(path: str) -> pd.DataFrame:
    return read_csv(path, SOBOL, "Sobol' indices")


def _validation(path: str) -> pd.DataFrame:
    return read_csv(path, CROSS_VALIDATION, "a cross-validation")
