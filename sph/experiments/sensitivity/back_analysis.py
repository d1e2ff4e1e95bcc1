"""Back-analysis: the values of the factors that agree with what was observed (``back_analysis`` of ``config/sensitivity.yaml``).

They follow from the posterior (``posterior``) and are confirmed by runs at the best point and at the ends of every interval.  Of points
that agree equally well the best is the one nearest to the scene's own values.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from threadpoolctl import threadpool_limits

from sph.experiments.base import metric_words
from sph.experiments.sensitivity.factors import ENDS, Axis, Observation, short, with_unit
from sph.experiments.sensitivity.posterior import CONFIDENCE, Posterior, Prediction, Target, alone, held, posterior, predictor
from sph.experiments.sensitivity.surrogate import TRUSTED
from sph.storage.trajectory import Variable
from sph.study.tables import number_column, text_column

REACHED = 2.0
"""Standard deviations within which a prediction agrees with what was observed, and a run with the prediction."""
DETERMINED = 0.5
"""Longest interval of a factor that is determined, over its range."""
CUT = 0.1
"""A bound cuts an interval whose end is nearer to it than this part of the interval's length."""
BEST = "best"
"""Run at the best point."""
ALONE, TOGETHER, OPEN, NOT_REACHED = "alone", "with the others", "no", "not reached"
CONFIRMED, NOT_CONFIRMED = "confirmed", "not confirmed"

BACK_ANALYSIS: tuple[Variable, ...] = (
    text_column("factor", "factor whose value is sought"),
    text_column("units", "its unit"),
    *(number_column(name, "as units", f"{text} of the prior") for name, text in zip(ENDS, ("low end", "high end"), strict=True)),
    text_column("prior", "distribution between these ends: uniform or log-uniform"),
    number_column("base_value", "as units", "the factor's value in the scene as it is"),
    number_column(BEST, "as units", "value at the best point: of those that agree equally well, the nearest to the scene's own values"),
    number_column("median", "as units", "median of the posterior; NaN, like the intervals, where the observation is not reached"),
    number_column("lower", "as units", f"lower end of the {CONFIDENCE:.0%} interval of the posterior, whatever the other factors"),
    number_column("upper", "as units", "upper end"),
    number_column("lower_at_best", "as units", "lower end of the interval with all other factors as at the best point"),
    number_column("upper_at_best", "as units", "upper end"),
    text_column(
        "determined",
        f"{ALONE}: the interval is at most {DETERMINED:g} of the range, on the scale of the factor; {TOGETHER}: it is longer, but that at "
        f"the best point is not; {OPEN}: both are longer; {NOT_REACHED}: nothing within the bounds agrees with the observation",
    ),
    text_column("cut", "ends of the interval that a bound cuts, low, high, low and high, or none"),
    number_column(
        "distance",
        "1",
        "smallest distance of a prediction within the bounds from the observation, in standard deviations of both together; for several "
        f"metrics the largest of these; reached up to {REACHED:g}",
    ),
    text_column("verdict", f"{TRUSTED}, or why the surrogate of a metric is not to be trusted"),
    text_column("sentence", "the result in words"),
)
"""The columns of a back-analysis."""
PREDICTED: tuple[Variable, ...] = (
    text_column("metric", "metric that was observed, as in study.csv"),
    text_column("units", "its unit"),
    number_column("observed", "as units", "observed value"),
    number_column("error", "as units", "its standard deviation"),
    number_column("predicted", "as units", "value by the surrogate"),
    number_column("predicted_lower", "as units", f"predicted minus {REACHED:g} standard deviations of the prediction"),
    number_column("predicted_upper", "as units", "predicted plus as many"),
)
"""Columns of the points to be confirmed, behind the factors."""
MEASURED: tuple[Variable, ...] = (
    number_column("measured", "as units", "value of the run; NaN if it diverged"),
    text_column("verdict", f"{CONFIRMED}: the run lies between the ends of the prediction; {NOT_CONFIRMED}: it does not, or diverged"),
    text_column("sentence", "the result in words"),
)
"""Columns that the runs add."""


def point_columns(axes: Sequence[Axis]) -> tuple[Variable, ...]:
    """Columns of the points to be confirmed, a row per run and metric, with all factors ``axes``."""
    factors = (number_column(axis.name, axis.unit, f"factor: {axis.label}") for axis in axes)
    run = text_column("run", f"file of the run under runs/back/, without suffix: {BEST}, or a factor and the end of its interval")
    return (run, *factors, *PREDICTED)


def confirmed_columns(axes: Sequence[Axis]) -> tuple[Variable, ...]:
    """Columns of these points with what the runs give."""
    return (*point_columns(axes), *MEASURED)


class Problem(NamedTuple):
    """What is sought, and by what."""

    axes: Sequence[Axis]
    """all factors"""
    sought: Sequence[Axis]
    observations: Sequence[Observation]

    @property
    def seen(self) -> str:
        """What was observed, in words."""
        return "an observed " + " and ".join(f"{metric_words(seen.quantity.metric)} of {_observed(seen)}" for seen in self.observations)

    def point(self, shares: np.ndarray) -> dict[str, float]:
        """Values of all factors at shares (k,) of the bounds of those sought, by name."""
        return {axis.name: axis.base for axis in self.axes} | {
            axis.name: axis.value(float(share)) for axis, share in zip(self.sought, shares, strict=True)
        }

    def predicted(self, prediction: Prediction) -> np.ndarray:
        """Metrics (3, n, m) by a prediction, and two standard deviations below and above."""
        mean, deviation = prediction
        return np.array(
            [
                np.column_stack([seen.quantity.metric_of(column) for seen, column in zip(self.observations, values.T, strict=True)])
                for values in (mean, mean - REACHED * deviation, mean + REACHED * deviation)
            ]
        )


def problem_of(axes: Sequence[Axis], sought: Collection[str], observations: Sequence[Observation]) -> Problem:
    """What is sought over these factors, by their names."""
    return Problem(axes, [axis for axis in axes if axis.name in sought], observations)


def posterior_columns(problem: Problem) -> tuple[Variable, ...]:
    """Columns of the points of the posterior."""
    ends = {"": "", "_lower": f", minus {REACHED:g} standard deviations", "_upper": ", plus as many"}
    return (
        *(number_column(axis.name, axis.unit, f"factor: {axis.label}") for axis in problem.sought),
        number_column("weight", "1", "probability of the point"),
        number_column(
            "mass", "1", f"probability of it and all points of greater likelihood: up to {CONFIDENCE} in the {CONFIDENCE:.0%} region"
        ),
        *(
            number_column(f"{metric}{end}", unit, f"{metric_words(metric)} by the surrogate{text}")
            for metric, unit in ((seen.quantity.metric, seen.quantity.metric_unit) for seen in problem.observations)
            for end, text in ends.items()
        ),
    )


def back_tables(
    problem: Problem, varied: Sequence[Axis], sample: pd.DataFrame, indices: pd.DataFrame, validation: pd.DataFrame
) -> tuple[pd.DataFrame, pd.DataFrame, pd.DataFrame]:
    """The result, a row per factor sought; the points to be confirmed, a row per run and metric; the points of the posterior.

    ``sample`` over the factors ``varied``, ``indices`` and ``validation`` as from ``sobol_tables``.
    """
    target = Target(*np.transpose([seen.analysed for seen in problem.observations]))
    with threadpool_limits(1):  # as for the indices
        predict = predictor(sample, validation, varied, problem.sought, problem.observations)
        distribution = posterior(predict, target, len(problem.sought))
        own = np.array([float(axis.share(np.array(axis.base))) for axis in problem.sought])
        if distribution.least > REACHED:
            distribution = posterior(predict, target, len(problem.sought), rounds=1)
        best, distance = distribution.shares[distribution.nearest(own)], distribution.least
        given = np.column_stack([alone(predict, target, best, factor) for factor in range(len(best))])
        points = {BEST: best}
        for factor, axis in enumerate(problem.sought if distance <= REACHED else ()):
            for end, share in zip(ENDS, distribution.intervals[[0, 2], factor], strict=True):
                there = held(predict, distribution, factor, float(share))
                points[f"{axis.name}/{end}"] = there.shares[there.nearest(best)]
        predicted = problem.predicted(predict(np.array(list(points.values()))))
    metrics = {seen.quantity.metric for seen in problem.observations}
    verdicts = indices[indices["metric"].isin(metrics)].drop_duplicates("metric")
    pairs = zip(verdicts["metric"], verdicts["verdict"], strict=True)
    untrusted = [f"{metric_words(metric)}: {verdict}" for metric, verdict in pairs if verdict != TRUSTED]
    facts = {"distance": distance, "verdict": "; ".join(untrusted) or TRUSTED}
    rows = [
        _row(axis, distribution.intervals[:, factor], given[:, factor], distance) | facts | {BEST: axis.value(float(best[factor]))}
        for factor, axis in enumerate(problem.sought)
    ]
    rows = [row | {"sentence": _sentence(problem, row, problem.point(best), predicted[0, 0])} for row in rows]
    table = pd.DataFrame(rows, columns=[column.name for column in BACK_ANALYSIS])
    runs = pd.DataFrame(_points(problem, points, predicted), columns=[column.name for column in point_columns(problem.axes)])
    return table, runs, _posterior_frame(problem, distribution)


def _row(axis: Axis, interval: np.ndarray, given: np.ndarray, distance: float) -> dict[str, Any]:
    """Facts of a factor by the shares (3,) of its interval and of that with all others as at the best point."""
    facts = {"factor": axis.name, "units": axis.unit, "low": axis.low, "high": axis.high, "base_value": axis.base}
    facts["prior"] = "log-uniform" if axis.log else "uniform"
    if distance > REACHED:
        return facts | {"determined": NOT_REACHED, "cut": "none"}
    length = interval[2] - interval[0]
    near = {"low": interval[0] < CUT * length, "high": 1.0 - interval[2] < CUT * length}
    names = ("lower", "median", "upper", "lower_at_best", "upper_at_best")
    values = dict(zip(names, map(axis.value, map(float, (*interval, given[0], given[2]))), strict=True))
    determined = ALONE if length <= DETERMINED else TOGETHER if given[2] - given[0] <= DETERMINED else OPEN
    return facts | values | {"determined": determined, "cut": " and ".join(end for end, cut in near.items() if cut) or "none"}


def _sentence(problem: Problem, row: Mapping[str, Any], best: Mapping[str, float], nearest: np.ndarray) -> str:
    """What a row says; ``nearest`` are the metrics (m,) at the best point."""
    axis = next(axis for axis in problem.sought if axis.name == row["factor"])
    trust = "" if row["verdict"] == TRUSTED else f" Surrogate: {row['verdict']}."
    if row["determined"] == NOT_REACHED:
        bounds = ", ".join(f"{each.label} {each.span(each.low, each.high)}" for each in problem.sought)
        metrics = [
            f"{metric_words(seen.quantity.metric)} {with_unit(value, seen.quantity.metric_unit)}"
            for seen, value in zip(problem.observations, nearest, strict=True)
        ]
        where = _words(problem.sought, best)
        return f"Nothing within {bounds} agrees with {problem.seen}: the nearest is {', '.join(metrics)} at {where}.{trust}"
    span, interval = axis.span(row["lower"], row["upper"]), f"{CONFIDENCE:.0%} interval"
    cut = "" if row["cut"] == "none" else f", cut by the bounds: {row['cut']}"
    if row["determined"] == ALONE:
        return f"{axis.label} {short(row['median'])} ({span}, {interval}{cut}) agrees with {problem.seen}.{trust}"
    if row["determined"] == OPEN:
        return f"{axis.label} is not determined by {problem.seen}: {span} ({interval}{cut}).{trust}"
    others = _words([each for each in problem.sought if each is not axis], best)
    known = axis.span(row["lower_at_best"], row["upper_at_best"])
    what = f"{axis.label} is determined by {problem.seen} only together with the others"
    return f"{what}: {known} at {others}, else {span} ({interval}s{cut}).{trust}"


def _points(problem: Problem, points: Mapping[str, np.ndarray], predicted: np.ndarray) -> Iterator[dict[str, Any]]:
    """Rows of the points to be confirmed, at shares (k,) by name, with the metrics (3, n, m) predicted there."""
    for place, (run, shares) in enumerate(points.items()):
        for number, seen in enumerate(problem.observations):
            facts = {"metric": seen.quantity.metric, "units": seen.quantity.metric_unit, "observed": seen.value, "error": seen.error}
            values = zip(("predicted", "predicted_lower", "predicted_upper"), predicted[:, place, number], strict=True)
            yield {"run": run} | problem.point(shares) | facts | dict(values)


def _posterior_frame(problem: Problem, distribution: Posterior) -> pd.DataFrame:
    """The points of the posterior in the units of factors and metrics."""
    columns = [[axis.value(float(share)) for share in shares] for axis, shares in zip(problem.sought, distribution.shares.T, strict=True)]
    metrics = problem.predicted(distribution.prediction)
    values = [
        *columns,
        distribution.weights,
        distribution.mass,
        *(metrics[end, :, number] for number in range(metrics.shape[2]) for end in range(3)),
    ]
    return pd.DataFrame({column.name: each for column, each in zip(posterior_columns(problem), values, strict=True)})


def confirmed_table(points: pd.DataFrame, sample: pd.DataFrame, problem: Problem) -> pd.DataFrame:
    """The points beside the runs made there, whose names in ``sample`` have the design before them."""
    measured = sample.assign(run=sample["run"].str.partition("/")[2]).set_index("run")
    observations = {seen.quantity.metric: seen for seen in problem.observations}
    rows = []
    for each in points.to_dict("records"):
        row = {str(name): value for name, value in each.items()}
        value, seen = float(measured.loc[row["run"], row["metric"]]), observations[row["metric"]]
        verdict = CONFIRMED if row["predicted_lower"] <= value <= row["predicted_upper"] else NOT_CONFIRMED
        given = "diverged" if math.isnan(value) else f"gives {metric_words(row['metric'])} {with_unit(value, row['units'])}"
        predicted = f"{short(row['predicted_lower'])} to {with_unit(row['predicted_upper'], row['units'])}"
        words = f"The run at {_words(problem.sought, row)} {given}; predicted {predicted}, observed {_observed(seen)}."
        rows.append(row | {"measured": value, "verdict": verdict, "sentence": words})
    return pd.DataFrame(rows, columns=[column.name for column in confirmed_columns(problem.axes)])


def _words(axes: Sequence[Axis], values: Mapping[str, Any]) -> str:
    return ", ".join(f"{axis.label} {with_unit(values[axis.name], axis.unit)}" for axis in axes)


def _observed(seen: Observation) -> str:
    return f"{short(seen.value)} ± {with_unit(seen.error, seen.quantity.metric_unit)}"
