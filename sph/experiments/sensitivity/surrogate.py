"""Sobol' indices through a Gaussian process fitted to the runs, cross-validated.

The surrogate has a Matern 5/2 kernel with a length scale a factor and white noise; factors are shares of their ranges, levels side by side
as they are written, quantities are standardised.  The noise takes up what varies below the distance of the runs, so that the indices are
those of the smooth part; ``noise_share`` is what they leave out.  First-order indices by Saltelli et al. (2010), total ones by Jansen
(1999).

The intervals hold the surrogate's uncertainty and the estimator's (Le Gratiet, Cannamela and Iooss 2014): functions are drawn from the
posterior, and the points of the estimator are resampled for each.  They are drawn from the surrogates of the cross-validation in turn,
each fitted without a part of the runs, so that what the fit owes to single runs, its length scales above all, is in the intervals, too.
Functions are drawn pathwise (Wilson et al. 2020): a sum of random cosines from the prior, corrected by the runs.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np
import pandas as pd
from threadpoolctl import threadpool_limits

from sph.experiments.sensitivity.elementary_effects import INTERVAL
from sph.experiments.sensitivity.factors import Axis, Quantity
from sph.experiments.sensitivity.schema import SobolSettings
from sph.experiments.sensitivity.tables import diverged_runs
from sph.scene.extras import of_extra
from sph.storage.trajectory import Variable
from sph.study.tables import ROW, number_column, text_column

SMOOTHNESS = 2.5
"""nu of the Matern kernel."""
FEATURES = 2000
"""Random cosines of a function drawn from the prior, whose covariance they meet within some 2 %."""
KINDS = ("first", "total")
"""The two indices of a factor, by the names of their columns."""
TRUSTED, UNTRUSTED = "trusted", "not to be trusted"

SOBOL: tuple[Variable, ...] = (
    text_column("metric", "metric, as in study.csv"),
    text_column("quantity", "what is analysed: the metric, or a logarithm of it"),
    text_column("factor", "the factor"),
    *(
        number_column(f"{name}{end}", "1", f"{what}{text}")
        for name, what in zip(KINDS, ("first-order index", "total index"), strict=True)
        for end, text in (("", ""), ("_low", ": low end of its 95 % interval"), ("_high", ": high end of its 95 % interval"))
    ),
    number_column("q2", "1", "share of the quantity's variance that the surrogate predicts in runs it has not seen (k-fold)"),
    number_column("rmse", "as units", "root mean square error of these predictions"),
    text_column("units", "unit of the quantity"),
    number_column("noise_share", "1", "white noise over the quantity's variance, which the indices leave out"),
    Variable("runs", ROW, "i4", "1", "runs of the sample"),
    Variable("diverged", ROW, "i4", "1", "diverged runs among them, which the fit leaves out"),
    text_column("verdict", f"{TRUSTED}, or why the indices are not to be trusted"),
)
"""The columns of the indices."""
CROSS_VALIDATION: tuple[Variable, ...] = (
    text_column("run", "file of the run under runs/, without suffix"),
    text_column("metric", "metric, as in study.csv"),
    text_column("quantity", "what is analysed: the metric, or a logarithm of it"),
    text_column("units", "its unit"),
    Variable("fold", ROW, "i4", "1", "part of the runs left out of the fit that predicts this one"),
    number_column("computed", "as units", "quantity of the run"),
    number_column("predicted", "as units", "prediction of the surrogate fitted without this run's part"),
    number_column("predicted_sd", "as units", "the surrogate's own standard deviation of the prediction, noise included"),
)
"""The columns of the cross-validation."""

Function = Callable[[np.ndarray], np.ndarray]


def known_runs(sample: pd.DataFrame, axes: Sequence[Axis], quantity: Quantity) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Which runs (n,) of a sample have a value of the quantity, and of those the shares (m, d) of the ranges and the values (m,)."""
    values = quantity.of(sample[quantity.metric].to_numpy())
    known = np.isfinite(values)
    return known, np.column_stack([axis.share(sample[axis.name].to_numpy()[known]) for axis in axes]), values[known]


def fit_surrogate(shares: np.ndarray, values: np.ndarray) -> Any:
    """Gaussian process through values (n,) at shares of the ranges (n, d)."""
    gaussian, kernels = of_extra("sklearn.gaussian_process", "sensitivity"), of_extra("sklearn.gaussian_process.kernels", "sensitivity")
    matern = kernels.Matern(np.ones(shares.shape[1]), (0.05, 100.0), nu=SMOOTHNESS)
    kernel = kernels.ConstantKernel(1.0, (1e-2, 1e3)) * matern + kernels.WhiteKernel(0.01, (1e-6, 1.0))
    process = gaussian.GaussianProcessRegressor(kernel, normalize_y=True)
    with warnings.catch_warnings():
        warnings.simplefilter(
            "ignore", of_extra("sklearn.exceptions", "sensitivity").ConvergenceWarning
        )  # the length scale of a factor without effect goes to its bound
        return process.fit(shares, values)


def cross_validate(shares: np.ndarray, values: np.ndarray, folds: int, seed: int) -> tuple[np.ndarray, list[Any]]:
    """Part (n,) of every run, by number, and the surrogates fitted without each part."""
    fold = np.random.default_rng(seed).permutation(values.size) % folds
    return fold, [fit_surrogate(shares[fold != number], values[fold != number]) for number in range(folds)]


def predict_unseen(shares: np.ndarray, fold: np.ndarray, processes: Sequence[Any]) -> tuple[np.ndarray, np.ndarray]:
    """Prediction (n,) of every run and its standard deviation (n,) by the surrogate that has not seen it."""
    prediction = np.empty((2, len(shares)))
    for number, process in enumerate(processes):
        prediction[:, fold == number] = process.predict(shares[fold == number], return_std=True)
    return prediction[0], prediction[1]


def predictivity(values: np.ndarray, predicted: np.ndarray) -> float:
    """Q2: 1 minus the squared errors over the squared deviations from the mean."""
    return float(1.0 - np.sum((values - predicted) ** 2) / np.sum((values - values.mean()) ** 2))


def posterior_functions(process: Any, draws: int, rng: np.random.Generator) -> Function:
    """Functions drawn from a fitted process: a call at shares (n, d) gives the values (n, draws)."""
    smooth, noise = process.kernel_.k1, process.kernel_.k2.noise_level
    known, d = process.X_train_, process.X_train_.shape[1]
    # The spectral density of a Matern kernel is that of Student's t with 2 nu degrees of freedom.
    stretch = np.sqrt(2 * SMOOTHNESS / rng.chisquare(2 * SMOOTHNESS, FEATURES))
    waves = rng.standard_normal((d, FEATURES)) * stretch / np.reshape(smooth.k2.length_scale, (-1, 1))
    phase, weights = rng.uniform(0.0, 2.0 * np.pi, FEATURES), rng.standard_normal((FEATURES, draws))
    scale = np.sqrt(2.0 * smooth.k1.constant_value / FEATURES)

    def prior(x: np.ndarray) -> np.ndarray:
        return scale * np.cos(x @ waves + phase) @ weights

    mean, deviation = process._y_train_mean, process._y_train_std
    gap = process.y_train_[:, None] - prior(known) - np.sqrt(noise) * rng.standard_normal((len(known), draws))
    correction = np.linalg.solve(process.kernel_(known), gap)
    return lambda x: mean + deviation * (prior(x) + smooth(x, known) @ correction)


def sobol_indices(functions: Function, dimensions: int, points: int, seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Mean (2, d) over the functions of first-order and total indices, and the ends (2, d) of their intervals.

    ``functions`` gives values (n, draws) at shares (n, d); the estimator uses ``points`` rows of d + 2 values, resampled once a draw.
    """
    problem = {"num_vars": dimensions, "names": [str(i) for i in range(dimensions)], "bounds": [[0.0, 1.0]] * dimensions}
    x = of_extra("SALib.sample.sobol", "sensitivity").sample(problem, points, calc_second_order=False, seed=seed)
    y = functions(x).reshape(points, dimensions + 2, -1)
    y -= y.mean(axis=(0, 1))
    draws = y.shape[2]
    resampled = y[np.random.default_rng(seed).integers(points, size=(points, draws)), :, np.arange(draws)].transpose(0, 2, 1)
    spread = np.percentile(_indices(resampled), INTERVAL, axis=2)
    return _indices(y).mean(axis=2), spread[0], spread[1]


def _indices(y: np.ndarray) -> np.ndarray:
    """First-order and total indices (2, d, draws) of values (points, d + 2, draws), centred."""
    a, b, mixed = y[:, 0], y[:, -1], y[:, 1:-1]
    indices = of_extra("SALib.analyze.sobol", "sensitivity")
    estimates = (indices.first_order, indices.total_order)
    return np.array([[estimate(a, mixed[:, i], b) for i in range(mixed.shape[1])] for estimate in estimates])


def sobol_tables(
    sample: pd.DataFrame, axes: Sequence[Axis], quantities: Sequence[Quantity], settings: SobolSettings, seed: int
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Indices, a row per metric and factor, and the cross-validation behind them, a row per metric and run.

    ``axes`` are the factors that the sample varies.  Diverged runs are left out.  Raises ValueError where fewer runs are left than
    there are parts of the cross-validation.
    """
    counts = {"runs": len(sample), "diverged": diverged_runs(sample)}
    indices: list[dict[str, Any]] = []
    validation = [pd.DataFrame(columns=[column.name for column in CROSS_VALIDATION])]
    for quantity in quantities:
        known, shares, values = known_runs(sample, axes, quantity)
        if values.size < settings.folds:
            raise ValueError(f"{quantity.metric}: {values.size} runs with a value are too few for sobol.folds: {settings.folds}")
        words = {"metric": quantity.metric, "quantity": quantity.text, "units": quantity.unit}
        rows = [words | counts | {"factor": axis.name, "verdict": f"{UNTRUSTED}: all runs have the same value"} for axis in axes]
        if np.ptp(values) > 0.0:
            with threadpool_limits(1):  # two threads on matrices this small, on two cores in use: 12 times as long
                fold, processes = cross_validate(shares, values, settings.folds, seed)
                predicted, deviation = predict_unseen(shares, fold, processes)
                rows = [row | numbers for row, numbers in zip(rows, _rows(processes, values, predicted, axes, settings, seed), strict=True)]
            parts = {"run": sample["run"][known], "fold": fold, "computed": values, "predicted": predicted, "predicted_sd": deviation}
            validation.append(pd.DataFrame(words | parts)[validation[0].columns])
        indices += rows
    return pd.DataFrame(indices, columns=[column.name for column in SOBOL]), pd.concat(validation[1:] or validation, ignore_index=True)


def _rows(
    processes: Sequence[Any], values: np.ndarray, predicted: np.ndarray, axes: Sequence[Axis], settings: SobolSettings, seed: int
) -> Iterator[dict[str, Any]]:
    """Indices, their intervals and the facts of the fit, a mapping per factor."""
    rng, each = np.random.default_rng(seed), -(-settings.draws // len(processes))
    drawn = [posterior_functions(process, each, rng) for process in processes]

    def functions(shares: np.ndarray) -> np.ndarray:
        at = np.column_stack([axis.snapped(column) for axis, column in zip(axes, shares.T, strict=True)])
        return np.hstack([function(at) for function in drawn])

    parts = sobol_indices(functions, len(axes), settings.points, seed)
    by_end = dict(zip(("", "_low", "_high"), parts, strict=True))
    q2 = predictivity(values, predicted)
    facts = {
        "q2": q2,
        "rmse": float(np.sqrt(np.mean((values - predicted) ** 2))),
        "noise_share": float(np.median([process.kernel_.k2.noise_level for process in processes])),
        "verdict": TRUSTED if q2 >= settings.least_q2 else f"{UNTRUSTED}: Q² below {settings.least_q2:g}",
    }
    for place in range(len(axes)):
        yield facts | {f"{name}{end}": part[row, place] for end, part in by_end.items() for row, name in enumerate(KINDS)}
