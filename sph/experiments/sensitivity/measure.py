"""The sensitivity analysis and the back-analysis: samples, screening, indices, and the values that agree with what was observed."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
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
from sph.experiments.sensitivity.design import (
    BACK,
    BACK_FILE,
    CONFIRM,
    FACTORS_FILE,
    Axis,
    Observation,
    Point,
    Quantity,
    SensitivityPlan,
    SobolSettings,
    chosen_factors,
)
from sph.experiments.sensitivity.elementary_effects import MORRIS, influential, morris_table
from sph.experiments.sensitivity.figures import figure_cross_validation, figure_morris, figure_sobol, figure_tornado
from sph.experiments.sensitivity.figures_back import figure_back_analysis
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
from sph.experiments.steps import Runs, Step
from sph.measures.metrics import MetricSettings
from sph.study.tables import flat_dataset, read_csv

Axes = Sequence[Axis]
Quantities = Sequence[Quantity]


def measure_sample(
    runs: Runs, design: str, points: Mapping[str, Point], axes: Axes, quantities: Quantities, settings: Mapping[str, Any]
) -> pd.DataFrame:
    """One row per run, in the order of the points."""
    columns, chosen = sample_columns(axes, quantities), MetricSettings(**settings)
    return pd.DataFrame(
        [sample_row(f"{design}/{name}", point, run, columns, chosen) for (name, point), run in zip(points.items(), runs, strict=True)]
    )


def join_samples(samples: pd.DataFrame, axes: Axes, quantities: Quantities) -> tuple[xr.Dataset, pd.DataFrame]:
    """Every run of the sensitivity analysis: factors, metrics and how it ended. The status of a diverged run is 'diverged', its reason
    stands beside it, and no average holds it.
    """
    return flat_dataset(samples, sample_columns(axes, quantities)), samples


def screen_factors(sample: pd.DataFrame, axes: Axes, quantities: Quantities, resamples: int, seed: int) -> pd.DataFrame:
    """Screening by elementary effects over the whole range of a factor, with 95 % bootstrap intervals over the trajectories. The steps that
    touch a diverged run are dropped and counted (column 'dropped').
    """
    return morris_table(sample, axes, quantities, resamples, seed)


def choose_factors(factors: Sequence[str] | None, sought: Sequence[str], share: float, screening: pd.DataFrame | None = None) -> list[str]:
    """The factors that matter: those given, or those that the screening finds, with those sought."""
    names = list(factors or ()) if screening is None else influential(screening, share)
    return names + [name for name in sought if name not in names]


def measure_tornado(sample: pd.DataFrame, axes: Axes, quantities: Quantities) -> pd.DataFrame:
    """The metrics at both ends of every factor, all others as in the scene."""
    return tornado_table(sample, axes, quantities)


def fit_surrogate(
    sample: pd.DataFrame, factors: Sequence[str], axes: Axes, quantities: Quantities, settings: Mapping[str, Any], seed: int
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Sobol' indices through a Gaussian process, with 95 % intervals that hold the uncertainty of the surrogate and of the estimator, and
    with the surrogate's cross-validation (Q², RMSE). The verdict says where they are not to be trusted.
    """
    return sobol_tables(sample, [axis for axis in axes if axis.name in factors], quantities, SobolSettings(**settings), seed)


def confirm_sample(
    sample: pd.DataFrame, confirming: pd.DataFrame, axes: Axes, quantities: Quantities, fidelities: tuple[str, str]
) -> pd.DataFrame:
    """The first points of the Sobol' sample at the study's fidelity and at another one."""
    return confirmation_table(sample, confirming, quantities, fidelities)


def draw_morris(
    sample: pd.DataFrame, screening: pd.DataFrame, factors: Sequence[str], axes: Axes, quantities: Quantities, fidelity: str
) -> Figure:
    """Screening: standard deviation against mean absolute elementary effect of every factor over its whole range, with 95 % intervals. Full
    symbols: the factors of the Sobol' sample.
    """
    return figure_morris(screening, axes, factors, _note(sample, fidelity))


def draw_tornado(sample: pd.DataFrame, tornado: pd.DataFrame, axes: Axes, quantities: Quantities, fidelity: str) -> Figure:
    """The metrics at both ends of every factor, all others as in the scene."""
    return figure_tornado(tornado, axes, _note(sample, fidelity))


def draw_sobol(sample: pd.DataFrame, indices: pd.DataFrame, axes: Axes, quantities: Quantities, fidelity: str) -> Figure:
    """Sobol' indices with 95 % intervals, and the Q² of the surrogate behind them; what is not to be trusted is pale and says so."""
    return figure_sobol(indices, axes, _note(sample, fidelity))


def draw_cross_validation(
    sample: pd.DataFrame, validation: pd.DataFrame, indices: pd.DataFrame, axes: Axes, quantities: Quantities, fidelity: str
) -> Figure:
    """Prediction of the surrogate for every run, fitted without that run, with two standard deviations, against the computed value."""
    return figure_cross_validation(validation, indices, _note(sample, fidelity))


def analyse_back(
    sample: pd.DataFrame,
    indices: pd.DataFrame,
    validation: pd.DataFrame,
    factors: Sequence[str],
    axes: Axes,
    quantities: Quantities,
    sought: Sequence[str],
    observations: Sequence[Observation],
) -> tuple[pd.DataFrame, xr.Dataset, pd.DataFrame, xr.Dataset]:
    """Values of the parameters that agree with what was observed, by the surrogate of the sensitivity analysis: median, 90 % interval and
    best point. Every column is defined in docs/reference/files.md.

    One row per factor, twice; the points to be confirmed by runs; the points of the posterior.
    """
    problem = problem_of(axes, sought or factors, observations)
    varied = [axis for axis in axes if axis.name in factors]
    table, points, posterior = back_tables(problem, varied, sample, indices, validation)
    return table, flat_dataset(table, BACK_ANALYSIS), points, flat_dataset(posterior, posterior_columns(problem))


def confirm_back(
    sample: pd.DataFrame,
    result: pd.DataFrame,
    confirmable: pd.DataFrame,
    posterior: pd.DataFrame,
    confirming: pd.DataFrame,
    factors: Sequence[str],
    axes: Axes,
    quantities: Quantities,
    sought: Sequence[str],
    observations: Sequence[Observation],
    fidelity: str,
) -> tuple[pd.DataFrame, Figure]:
    """Runs at the best point of a back-analysis and at the ends of the intervals, beside what was predicted there. Every column is defined
    in docs/reference/files.md.
    """
    problem = problem_of(axes, sought or factors, observations)
    confirmed = confirmed_table(confirmable, confirming, problem)
    return confirmed, figure_back_analysis(result, posterior, confirmed, sample, problem, _note(sample, fidelity))


def _note(sample: pd.DataFrame, fidelity: str) -> str:
    return f"fidelity {fidelity} · {described(sample)}"


def _basis(design: SensitivityPlan) -> dict[str, Any]:
    return {"axes": design.axes, "quantities": design.quantities}


def _drawing(design: SensitivityPlan) -> dict[str, Any]:
    return {**_basis(design), "fidelity": design.fidelities[0]}


def _observed(design: SensitivityPlan) -> dict[str, Any]:
    return {**_basis(design), "sought": design.sought, "observations": design.observations}


def _with(**given: Callable[[SensitivityPlan], Any]) -> Callable[[SensitivityPlan], dict[str, Any]]:
    return lambda design: {**_basis(design), **{name: of(design) for name, of in given.items()}}


def _samples(design: SensitivityPlan) -> dict[str, list[str]]:
    asked = [CONFIRM] * bool(design.confirmed) + [BACK] * bool(design.settings.back_analysis)
    return {"samples": [f"{design.folder}/samples/{name}.csv" for name in ("morris", "tornado", "sobol", *asked)]}


def _sample(path: str, given: Mapping[str, Any]) -> pd.DataFrame:
    return read_sample(path, given["axes"], given["quantities"])


def _posterior(path: str, given: Mapping[str, Any]) -> pd.DataFrame:
    with xr.open_dataset(path) as found:
        return found.to_dataframe()


READERS: dict[str, Callable[[Any, Mapping[str, Any]], Any]] = {
    "factors": lambda path, given: chosen_factors(path),
    "sample": _sample,
    "confirming": _sample,
    "samples": lambda paths, given: pd.concat([_sample(path, given) for path in paths], ignore_index=True),
    "screening": lambda path, given: read_csv(path, MORRIS, "a screening"),
    "tornado": lambda path, given: read_csv(path, TORNADO, "a tornado"),
    "indices": lambda path, given: read_csv(path, SOBOL, "Sobol' indices"),
    "validation": lambda path, given: read_csv(path, CROSS_VALIDATION, "a cross-validation"),
    "result": lambda path, given: read_csv(path, BACK_ANALYSIS, "a back-analysis"),
    "confirmable": lambda path, given: read_csv(path, point_columns(given["axes"]), "the points of a back-analysis"),
    "posterior": _posterior,
}
AT_MORRIS, AT_TORNADO, AT_SOBOL = ({"sample": f"samples/{name}.csv"} for name in ("morris", "tornado", "sobol"))
CHOSEN, INDICES, VALIDATION = {"factors": FACTORS_FILE}, {"indices": "sobol.csv"}, {"validation": "cross_validation.csv"}
STEPS = (
    Step(
        "sensitivity_measure",
        measure_sample,
        writes={"samples/{design}.csv": ""},
        given=lambda plan, design: {**_basis(plan), "design": design, "points": plan.design(design, plan.chosen(design))},
        needs=lambda plan, design: {"known": plan.known_by(design) or []},
        runs=lambda plan, design: plan.rows(design, plan.chosen(design)),
        after=lambda plan, design: {FACTORS_FILE: "sensitivity_factors", BACK_FILE: "back_analysis_points"}.get(
            plan.known_by(design).rpartition("/")[2]
        ),
    ),
    Step("sensitivity_sample", join_samples, {}, {"sample.nc": "", "sample.csv": "every run"}, _basis, _samples),
    Step(
        "sensitivity_morris",
        screen_factors,
        AT_MORRIS,
        {"morris.csv": "Morris screening"},
        _with(resamples=lambda design: design.settings.morris.resamples, seed=lambda design: design.settings.seed),
    ),
    Step(
        "sensitivity_factors",
        choose_factors,
        writes={FACTORS_FILE: ""},
        given=lambda plan: {"factors": plan.settings.sobol.factors, "sought": plan.sought, "share": plan.settings.sobol.share},
        needs=lambda plan: {"screening": [] if plan.settings.sobol.factors else f"{plan.folder}/morris.csv"},
        decides=True,
    ),
    Step("sensitivity_tornado", measure_tornado, AT_TORNADO, {"tornado.csv": "one factor at a time"}, _basis),
    Step(
        "sensitivity_sobol",
        fit_surrogate,
        AT_SOBOL | CHOSEN,
        {"sobol.csv": "Sobol' indices", "cross_validation.csv": ""},
        _with(settings=lambda design: design.settings.sobol.model_dump(), seed=lambda design: design.settings.seed),
    ),
    Step(
        "sensitivity_confirm",
        confirm_sample,
        AT_SOBOL | {"confirming": f"samples/{CONFIRM}.csv"},
        {"confirm.csv": "confirmed points"},
        _with(fidelities=lambda design: design.fidelities),
    ),
    Step(
        "sensitivity_figure_morris",
        draw_morris,
        AT_MORRIS | CHOSEN | {"screening": "morris.csv"},
        {"figures/morris": "figure morris"},
        _drawing,
    ),
    Step(
        "sensitivity_figure_tornado", draw_tornado, AT_TORNADO | {"tornado": "tornado.csv"}, {"figures/tornado": "figure tornado"}, _drawing
    ),
    Step("sensitivity_figure_sobol", draw_sobol, AT_SOBOL | INDICES, {"figures/sobol": "figure sobol"}, _drawing),
    Step(
        "sensitivity_figure_cross_validation",
        draw_cross_validation,
        AT_SOBOL | VALIDATION | INDICES,
        {"figures/cross_validation": "figure cross_validation"},
        _drawing,
    ),
    Step(
        "back_analysis_points",
        analyse_back,
        AT_SOBOL | CHOSEN | INDICES | VALIDATION,
        {"back_analysis.csv": "back-analysis", "back_analysis.nc": "", BACK_FILE: "", "back_posterior.nc": ""},
        _observed,
        decides=True,
    ),
    Step(
        "back_analysis_confirmed",
        confirm_back,
        {
            **AT_SOBOL,
            **CHOSEN,
            "result": "back_analysis.csv",
            "confirmable": "back_points.csv",
            "posterior": "back_posterior.nc",
            "confirming": f"samples/{BACK}.csv",
        },
        {"back_confirmed.csv": "runs that confirm a back-analysis", "figures/back_analysis": "figure of the back-analysis"},
        lambda design: {**_observed(design), "fidelity": design.fidelities[0]},
    ),
)
"""The jobs of the analysis."""
