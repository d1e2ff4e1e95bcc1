"""Uncertain keys of a scene: distributions, correlations, and the values that a seed draws.

Every variable has a standard normal score, made of its scene key and the seed alone, so that neither the order in the file nor other
variables or seeds change it.  Correlations mix the scores by the Cholesky factor of their matrix, in the order of the keys.  A score
becomes a value by the quantiles of the variable's distribution (a Gaussian copula: Nataf 1962, Der Kiureghian and Liu 1986): the
correlations are those of the scores.

Strength may vary in space as well: the score of such a variable is a stationary Gaussian random field of the place, whose values vary over
correlation lengths (``RandomField``).  It is a function of the coordinates of the ground alone: the spacing of the particles, the box and
the placing of the lattice do not change it.
"""

from __future__ import annotations

import functools
import math
import re
from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Any, Literal

import numpy as np
import scipy  # type: ignore[import-untyped]
from pydantic import Field, model_validator

from sph.scene.configuration import OwnName, Section, dotted, flat, key, merge, validated
from sph.scene.extras import of_extra
from sph.scene.names import check_known

if TYPE_CHECKING:
    from sph.scene.schema import Scene

DIGITS = 8
"""Significant digits of a drawn value, so that it is the same on every machine."""
LARGEST = 1e12
"""Largest size of a value, in the unit of its key."""
MIN_SHARE = 0.01
"""Smallest probability that bounds may leave of a distribution."""


VARYING = re.compile(r"(?:layers\.(?P<layer>[^.]+)\.)?soil\.(?P<quantity>cohesion|friction_angle)")
"""Keys that can vary in space."""
STEEPEST = 50.0
"""Largest friction angle of a scene, degrees."""


class RandomField(Section):
    """How a strength varies in space: correlation exp(-r) or exp(-r^2) of its scores, r^2 = (dx / horizontal)^2 + (dy / vertical)^2."""

    model: Literal["exponential", "gaussian"] = key(
        "correlation of the scores at two places, exp(-r) or exp(-r²), with the distance r in correlation lengths", default="exponential"
    )
    horizontal_length: float = key("horizontal distance at which the correlation is 1/e", "m", gt=0, le=1e5)
    vertical_length: float = key("vertical distance at which the correlation is 1/e", "m", gt=0, le=1e5)

    def scores(self, seed: int, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Standard normal scores (n,) at places (n,), m."""
        return _field(self.model, self.horizontal_length, self.vertical_length, seed, *(np.asarray(a, float).tobytes() for a in (x, y)))


@functools.lru_cache(maxsize=4)
def _field(model: str, horizontal: float, vertical: float, seed: int, x: bytes, y: bytes) -> np.ndarray:
    """By the randomisation method (Hesse et al. 2014), of GSTools; kept, since a run asks for it at every change of its time step."""
    gstools = of_extra("gstools", "uncertainty")
    shape = {"exponential": gstools.Exponential, "gaussian": gstools.Gaussian}[model]
    covariance = shape(dim=2, var=1.0, len_scale=[horizontal, vertical], rescale=1.0)
    return np.asarray(gstools.SRF(covariance, seed=seed)((np.frombuffer(x), np.frombuffer(y))))


class Variable(Section):
    """A key of the scene that is drawn."""

    of: str = key("the scene's key, by its dotted path", pattern=r"^[A-Za-z][A-Za-z0-9_.]*$", max_length=200)
    kind: Literal["normal", "lognormal"] = key("distribution")
    mean: float = key("mean without bounds, in the unit of the scene's key", ge=-LARGEST, le=LARGEST)
    cov: float | None = key("coefficient of variation without bounds: standard deviation over mean", ge=0, le=10, default=None)
    sd: float | None = key(
        "standard deviation without bounds, instead of cov, in the unit of the scene's key", ge=0, le=LARGEST, default=None
    )
    lower: float | None = key("lower bound, at which the distribution is truncated; null: none", ge=-LARGEST, le=LARGEST, default=None)
    upper: float | None = key("upper bound, at which the distribution is truncated; null: none", ge=-LARGEST, le=LARGEST, default=None)

    field: RandomField | None = key("variation in space, for cohesions and friction angles; null: one value", default=None)

    @model_validator(mode="after")
    def _consistent(self) -> Variable:
        if self.of.split(".")[0] in ("uncertain", "name", "title", "scheme"):
            raise ValueError(f"of: {self.of} is not a quantity that can be drawn; choose a key with a number")
        if (self.cov is None) == (self.sd is None):
            raise ValueError("cov, sd: write one of the two")
        if self.kind == "lognormal" and self.mean <= 0:
            raise ValueError(f"mean: {self.mean:g}; that of a lognormal distribution is positive")
        if self.cov and self.mean == 0:
            raise ValueError("cov: has no meaning with mean: 0; write sd")
        low, high = self._bounds
        if not low <= self.mean <= high or low == high:
            raise ValueError(f"mean: {self.mean:g} must lie between lower: {low:g} and upper: {high:g}; move the bounds")
        if self.share < MIN_SHARE:
            raise ValueError(f"lower, upper: leave {self.share:.2g} of the probability, at least {MIN_SHARE:g}; widen them")
        if self.field is not None:
            self._check_varying()
        return self

    def _check_varying(self) -> None:
        found = VARYING.fullmatch(self.of)
        if found is None:
            raise ValueError(f"field: {self.of} does not vary in space; soil.cohesion and soil.friction_angle do, those of layers as well")
        if self.mean <= 0:
            raise ValueError(f"mean: {self.mean:g}; that of a random field is positive")
        if self.kind == "normal" and (self.lower is None or self.lower < 0):
            raise ValueError("lower: a normal random field of strength needs one of at least 0")
        if found["quantity"] == "friction_angle" and (self.upper is None or self.upper > STEEPEST):
            raise ValueError(f"upper: a random field of the friction angle needs one of at most {STEEPEST:g} degrees")

    @property
    def layer(self) -> str | None:
        """Layer whose key it is; None for a key of the scene's own."""
        sections = self.of.split(".")
        return sections[1] if sections[0] == "layers" else None

    @property
    def quantity(self) -> str:
        """Last part of its key."""
        return self.of.split(".")[-1]

    @property
    def deviation(self) -> float:
        """Standard deviation without bounds."""
        return self.sd if self.sd is not None else (self.cov or 0.0) * abs(self.mean)

    @property
    def _bounds(self) -> tuple[float, float]:
        return -math.inf if self.lower is None else self.lower, math.inf if self.upper is None else self.upper

    @property
    def _normal(self) -> tuple[float, float]:
        """Mean and standard deviation of the value, or of its logarithm."""
        if self.kind == "normal":
            return self.mean, self.deviation
        variance = math.log1p((self.deviation / self.mean) ** 2)
        return math.log(self.mean) - 0.5 * variance, math.sqrt(variance)

    @property
    def _shares(self) -> tuple[float, float]:
        """Probabilities of values below the bounds."""
        center, spread = self._normal
        if spread == 0:
            return 0.0, 1.0
        ends = (self._on_scale(bound) for bound in self._bounds)
        low, high = (float(scipy.special.ndtr((end - center) / spread)) for end in ends)
        return low, high

    def _on_scale(self, value: float) -> float:
        if self.kind == "normal":
            return value
        return math.log(value) if value > 0 else -math.inf

    @property
    def share(self) -> float:
        """Probability that the bounds leave."""
        low, high = self._shares
        return high - low

    def values(self, scores: np.ndarray) -> np.ndarray:
        """Values of standard normal scores, of any shape: the quantiles of the distribution within its bounds."""
        center, spread = self._normal
        if spread == 0:
            return np.full(np.shape(scores), self.mean)
        if self.lower is not None or self.upper is not None:
            low, high = self._shares
            scores = scipy.special.ndtri(low + scipy.special.ndtr(scores) * (high - low))
        normal = center + spread * scores
        return np.clip(np.exp(normal) if self.kind == "lognormal" else normal, *self._bounds)

    def sentence(self) -> str:
        """The distribution in words."""
        spread = f"cov {self.cov:g}" if self.cov is not None else f"sd {self.sd:g}"
        bounds = [f"{word} {bound:g}" for word, bound in (("from", self.lower), ("to", self.upper)) if bound is not None]
        field = self.field and f"{self.field.model} over {self.field.horizontal_length:g} by {self.field.vertical_length:g} m"
        return ", ".join(part for part in (f"{self.kind}, mean {self.mean:g}, {spread}", " ".join(bounds), field) if part)


class Correlation(Section):
    """Correlation of two variables."""

    between: tuple[OwnName, OwnName] = key("names of the two variables")
    value: float = key("correlation coefficient of their standard normal scores", gt=-1, lt=1)


class Uncertain(Section):
    """Keys that are drawn, and the seed of the draw."""

    seed: int = key("seed of the draw; as a dimension of a study, one realisation for each value", ge=0, le=2**31)
    variables: dict[OwnName, Variable] = key("random variables, by names of your choice", min_length=1, max_length=100)
    correlations: Annotated[tuple[Correlation, ...], Field(max_length=5000)] = key(
        "correlations of pairs of variables; pairs that are not listed are not correlated", default=()
    )
    drawn: dict[str, float] | None = key(
        "values drawn with the seed, by scene key; written with results, so that these can be repeated", default=None
    )

    @model_validator(mode="after")
    def _consistent(self) -> Uncertain:
        named: dict[str, str] = {}
        for name, variable in self.variables.items():
            for other, first in named.items():
                if (variable.of + ".").startswith(other + ".") or (other + ".").startswith(variable.of + "."):
                    raise ValueError(f"variables.{name}.of: {variable.of} is drawn by variables.{first} already; leave one")
            named[variable.of] = name
        pairs = set()
        for number, correlation in enumerate(self.correlations):
            where = f"correlations.{number}.between"
            check_known(where, correlation.between, self.variables)
            pair = frozenset(correlation.between)
            if len(pair) == 1:
                raise ValueError(f"{where}: {correlation.between[0]} with itself; name two variables")
            if pair in pairs:
                raise ValueError(f"{where}: {' and '.join(correlation.between)} are there twice; leave one")
            pairs.add(pair)
            if len({self.variables[name].field for name in correlation.between}) > 1:
                raise ValueError(f"{where}: {' and '.join(correlation.between)} must have the same field, or both none, to be correlated")
        smallest = float(np.linalg.eigvalsh(self.correlation_matrix)[0])
        if smallest < 1e-9:
            raise ValueError(
                f"correlations: inconsistent, since their matrix is not positive definite (smallest eigenvalue {smallest:.3g}); "
                "choose smaller ones"
            )
        return self

    @property
    def ordered(self) -> list[Variable]:
        """The variables in the order of their keys."""
        return sorted(self.variables.values(), key=lambda variable: variable.of)

    @property
    def correlation_matrix(self) -> np.ndarray:
        """Correlations (n, n) of the scores, in the order of the keys."""
        names = sorted(self.variables, key=lambda name: self.variables[name].of)
        matrix = np.eye(len(names))
        for correlation in self.correlations:
            one, other = (names.index(name) for name in correlation.between)
            matrix[one, other] = matrix[other, one] = correlation.value
        return matrix

    def values(self) -> dict[str, float]:
        """Drawn values by scene key; of what varies in space, the mean of its distribution."""
        scores = np.linalg.cholesky(self.correlation_matrix) @ [_score(variable.of, self.seed) for variable in self.ordered]
        return {
            variable.of: variable.mean if variable.field else float(f"{float(variable.values(score)):.{DIGITS}g}")
            for variable, score in zip(self.ordered, scores, strict=True)
        }

    def ratios(self, x: np.ndarray, y: np.ndarray) -> dict[str, np.ndarray]:
        """Values (n,) at places (n,) in m over the mean, by scene key, of what varies in space; ValueError where GSTools is missing."""
        varying = [(number, variable) for number, variable in enumerate(self.ordered) if variable.field is not None]
        own = {
            number: variable.field.scores(_seed_of_field(variable.of, self.seed), x, y) for number, variable in varying if variable.field
        }
        mixing = np.linalg.cholesky(self.correlation_matrix)
        return {
            variable.of: variable.values(np.sum([mixing[number, other] * scores for other, scores in own.items()], axis=0)) / variable.mean
            for number, variable in varying
        }

    @property
    def varying(self) -> list[Variable]:
        """What varies in space."""
        return [variable for variable in self.variables.values() if variable.field is not None]


def seed_of(name: str, seed: int) -> np.random.SeedSequence:
    """Seeds of a scene key's own."""
    return np.random.SeedSequence(seed, spawn_key=tuple(name.encode()))


def _score(name: str, seed: int) -> float:
    """Standard normal score of a scene key: a raw number of numpy's PCG64, whose stream numpy keeps, by the inverse of the distribution."""
    raw = np.random.PCG64(seed_of(name, seed)).random_raw()
    return float(scipy.special.ndtri(((raw >> 11) + 0.5) * 2.0**-53))


def _seed_of_field(name: str, seed: int) -> int:
    return int(seed_of(name, seed).generate_state(1)[0])


class _Part(Section):
    """The section alone, under its name."""

    uncertain: Uncertain | None


def drawn(data: Mapping[str, Any], origin: str) -> Mapping[str, Any]:
    """A scene's mapping with the values of its seed; ValueError names a key that the scene writes as another value than
    the mean, or whose layer is not there.

    One into which these values were drawn before, as that of a scene stored with its results, stays as it is.
    """
    if not isinstance(data, Mapping) or not isinstance(data.get("uncertain"), Mapping):
        return data
    settings = validated(_Part, {"uncertain": data["uncertain"]}, origin).uncertain
    assert settings is not None
    values = settings.values()
    if settings.drawn == values:
        return data
    for name, variable in settings.variables.items():
        where = f"{origin}: uncertain.variables.{name}.of: {variable.of}"
        section, *rest = variable.of.split(".")
        layers = data.get("layers")
        if section == "layers":
            check_known(where, rest[:1], layers if isinstance(layers, Mapping) else {})
        written = flat(data).get(variable.of)
        if settings.drawn is None and written not in (None, variable.mean):
            raise ValueError(
                f"{where} is drawn with mean: {variable.mean:g} and the scene writes {written}; leave it out there, or write the mean"
            )
    return merge({**data, "uncertain": {**data["uncertain"], "drawn": values}}, dotted(values))


def at_mean(data: Mapping[str, Any], origin: str) -> Mapping[str, Any]:
    """A scene's mapping in which nothing is uncertain: what is drawn has its mean without bounds; a scene without is itself."""
    if not isinstance(data.get("uncertain"), Mapping):
        return data
    settings = validated(_Part, {"uncertain": data["uncertain"]}, origin).uncertain
    assert settings is not None
    means = {variable.of: variable.mean for variable in settings.variables.values()}
    return merge({name: value for name, value in data.items() if name != "uncertain"}, dotted(means))


def told(data: Mapping[str, Any], origin: str, refusal: str) -> list[str]:
    """A line on each value that was drawn and that the refusal of a scene names."""
    uncertain = data.get("uncertain") if isinstance(data, Mapping) else None
    if not isinstance(uncertain, Mapping):
        return []
    settings = validated(_Part, {"uncertain": uncertain}, origin).uncertain
    assert settings is not None
    values = settings.values()
    return [
        f"{origin}: uncertain.seed: {settings.seed} draws {variable.of} = {values[variable.of]:g}; "
        f"uncertain.variables.{name}.lower and upper keep it in range"
        for name, variable in settings.variables.items()
        if variable.of in refusal
    ]


def check_varying(scene: Scene) -> None:
    """Refuse strength that varies in space where the scene has no room for it."""
    for variable in scene.varying:
        if scene.walls.kinds.sides.periodic:
            raise ValueError(f"walls.sides: periodic, and the random field of {variable.of} is not; choose other sides")
        soil = scene.soil if variable.layer is None else scene.layers[variable.layer].soil
        if variable.quantity == "friction_angle" and soil.dilation_angle > (variable.lower or 0.0):
            raise ValueError(
                f"uncertain: the random field of {variable.of} goes below the dilation angle, {soil.dilation_angle:g} degrees; "
                "set its key lower to at least that angle"
            )
