"""The posterior of factors by what was observed, through the surrogate (Bayes' rule on points that fill the bounds).

The prior is uniform between the bounds of the factors, on a logarithmic scale where the factor has that.  An observation is normal about
the prediction, with the variance of the observation plus that of the prediction.  The points fill the bounds evenly and are weighted by
their likelihood; where too few of them count, they fill the part of the bounds that does.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
import pandas as pd
import scipy  # type: ignore[import-untyped]

from sph.experiments.sensitivity.factors import Axis, Observation
from sph.experiments.sensitivity.surrogate import fit_surrogate, known_runs

POINTS = 8192
"""Points that fill the bounds, a power of 2."""
FEWEST = 200.0
"""Points that must count: the square of the sum of the weights over the sum of their squares."""
ROUNDS = 6
"""Most times that the points fill the bounds or a part of them."""
FAINT = 12.0
"""Natural logarithm of the greatest likelihood over one that does not count."""
EQUAL = 0.01
"""Difference within which two points agree equally well, of the sum of squared distances in standard deviations of the observation."""
CONFIDENCE = 0.9
TAILS = (0.5 - 0.5 * CONFIDENCE, 0.5, 0.5 + 0.5 * CONFIDENCE)
"""Lower end of an interval, median, upper end."""

Prediction = tuple[np.ndarray, np.ndarray]
"""What is analysed (n, m) and its standard deviation (n, m)."""
Predictor = Callable[[np.ndarray], Prediction]
"""Predicts at shares (n, k) of the bounds."""


class Target(NamedTuple):
    """What was observed, as it is analysed."""

    values: np.ndarray
    """(m,)"""
    errors: np.ndarray
    """their standard deviations (m,)"""


class Posterior(NamedTuple):
    """Points that fill the bounds, or the part of them that counts."""

    shares: np.ndarray
    """of the bounds (n, k)"""
    prediction: Prediction
    target: Target

    @property
    def distance(self) -> np.ndarray:
        """Of the prediction from what was observed (n, m), in standard deviations of both together."""
        mean, deviation = self.prediction
        return (mean - self.target.values) / np.hypot(deviation, self.target.errors)

    @property
    def least(self) -> float:
        """Smallest distance of all points, of several metrics the largest."""
        return float(np.abs(self.distance).max(axis=1).min())

    @property
    def likelihood(self) -> np.ndarray:
        """Natural logarithm (n,) of the likelihood of what was observed."""
        return -np.sum(0.5 * self.distance**2 + np.log(np.hypot(self.prediction[1], self.target.errors)), axis=1)

    @property
    def weights(self) -> np.ndarray:
        """Probability (n,) of every point."""
        likelihood = self.likelihood
        weights = np.exp(likelihood - likelihood.max())
        return weights / weights.sum()

    @property
    def mass(self) -> np.ndarray:
        """Probability (n,) of every point and all of a greater likelihood."""
        weights, mass = self.weights, np.empty(len(self.shares))
        order = np.argsort(-weights)
        mass[order] = np.cumsum(weights[order])
        return mass

    @property
    def intervals(self) -> np.ndarray:
        """Lower end, median and upper end (3, k) of the factors' shares."""
        return np.quantile(self.shares, TAILS, axis=0, weights=self.weights, method="inverted_cdf")

    def nearest(self, shares: np.ndarray) -> int:
        """Of the points that agree equally well with what was observed, the one nearest to shares (k,)."""
        squares = np.sum(((self.prediction[0] - self.target.values) / self.target.errors) ** 2, axis=1)
        equal = np.flatnonzero(squares <= squares.min() + EQUAL)
        return int(equal[np.argmin(np.sum((self.shares[equal] - shares) ** 2, axis=1))])


def posterior(predict: Predictor, target: Target, dimensions: int, points: int = POINTS, rounds: int = ROUNDS) -> Posterior:
    """The posterior of factors, ``dimensions`` of them, on ``points`` of a scrambled Sobol' sequence; one round is on all of the bounds."""

    filled = scipy.stats.qmc.Sobol(dimensions, scramble=True, rng=0).random(points)
    low, high = np.zeros(dimensions), np.ones(dimensions)
    for _ in range(rounds):
        shares = low + (high - low) * filled
        distribution = Posterior(shares, predict(shares), target)
        if 1.0 / np.sum(distribution.weights**2) >= FEWEST:
            break
        likelihood = distribution.likelihood
        counting = shares[likelihood > likelihood.max() - FAINT]
        margin = 2.0 * (high - low) * points ** (-1.0 / dimensions)
        low, high = np.maximum(low, counting.min(axis=0) - margin), np.minimum(high, counting.max(axis=0) + margin)
    return distribution


def held(predict: Predictor, distribution: Posterior, factor: int, share: float) -> Posterior:
    """The same points with a factor at a share of its bounds."""
    shares = distribution.shares.copy()
    shares[:, factor] = share
    return Posterior(shares, predict(shares), distribution.target)


def alone(predict: Predictor, target: Target, best: np.ndarray, factor: int) -> np.ndarray:
    """Lower end, median and upper end (3,) of a factor's share with all others as at ``best`` (k,)."""

    def along(shares: np.ndarray) -> Prediction:
        full = np.tile(best, (len(shares), 1))
        full[:, factor] = shares[:, 0]
        return predict(full)

    return posterior(along, target, 1).intervals[:, 0]


def predictor(
    sample: pd.DataFrame, validation: pd.DataFrame, varied: Sequence[Axis], sought: Sequence[Axis], observations: Sequence[Observation]
) -> Predictor:
    """Predictions by surrogates through the runs of a sample over ``varied`` factors, those that are not sought at their base value.

    A standard deviation is that of the surrogate, noise included, times the root mean square of the errors of the cross-validation in
    such standard deviations where this is above 1.
    """
    base = np.array([float(axis.share(np.array(axis.base))) for axis in varied])
    places = [varied.index(axis) for axis in sought]
    fits, wider = [], []
    for seen in observations:
        _, shares, values = known_runs(sample, varied, seen.quantity)
        fits.append(fit_surrogate(shares, values))
        rows = validation[validation["metric"] == seen.quantity.metric]
        errors = ((rows["predicted"] - rows["computed"]) / rows["predicted_sd"]).to_numpy()
        wider.append(max(1.0, float(np.sqrt(np.mean(errors**2)))) if errors.size else 1.0)

    def predict(shares: np.ndarray) -> Prediction:
        full = np.tile(base, (len(shares), 1))
        full[:, places] = shares
        means, deviations = zip(*(fit.predict(full, return_std=True) for fit in fits), strict=True)
        return np.column_stack(means), np.column_stack(deviations) * wider

    return predict
