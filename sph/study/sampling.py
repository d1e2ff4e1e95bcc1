"""Runs of a study that do not form a grid: a list of cases, written out or in a CSV file, or a sample of ranges."""

from __future__ import annotations

import csv
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
import scipy  # type: ignore[import-untyped]
import yaml
from pydantic import BeforeValidator, model_validator

from sph.scene.configuration import Section, found_file, key
from sph.study.dimensions import in_si

MAX_RUNS = 100_000
"""Most runs of a study."""
MAX_TABLE = 50_000_000
"""Largest CSV file of cases, bytes."""
DIGITS = 8
"""Significant digits of a sampled value."""


class Range(Section):
    """A range that is sampled; ``[low, high]`` stands for a linear one."""

    bounds: tuple[float, float] = key("smallest and largest value, in the unit of the scene's key")
    scale: Literal["linear", "log"] = key("scale on which the range is filled evenly", default="linear")

    @model_validator(mode="after")
    def _increasing(self) -> Range:
        low, high = self.bounds
        if not low < high or self.scale == "log" and low <= 0:
            raise ValueError(
                f"bounds: [{low:g}, {high:g}] must increase" + (" and be positive on a log scale" if self.scale == "log" else "")
            )
        return self

    def values(self, shares: np.ndarray) -> list[str]:
        """Values, as they are written, at shares (n,) of the range."""
        low, high = np.log(self.bounds) if self.scale == "log" else self.bounds
        values = low + shares * (high - low)
        return [f"{value:.{DIGITS}g}" for value in (np.exp(values) if self.scale == "log" else values)]


def _as_bounds(value: Any) -> Any:
    return {"bounds": value} if isinstance(value, list) else value


Ranges = Annotated[
    dict[str, Annotated[Range, BeforeValidator(_as_bounds, json_schema_input_type=Range | tuple[float | str, float | str])]],
    BeforeValidator(in_si),
]


class Sample(Section):
    """Runs that fill ranges of scene keys."""

    method: Literal["latin_hypercube", "sobol", "random"] = key(
        "sobol (a scrambled Sobol' sequence) and random: a larger sample keeps the runs of a smaller one; latin_hypercube: every range "
        "is filled evenly, a larger sample is a new one",
        default="sobol",
    )
    size: int = key("number of runs; powers of 2 suit sobol best", ge=1, le=MAX_RUNS)
    seed: int = key("seed of the sample", ge=0, le=2**31, default=1)
    ranges: Ranges = key("range of each dimension: [low, high] or {bounds: [low, high], scale: log}", min_length=1, max_length=100)

    def points(self) -> list[dict[str, str]]:
        """The runs in their order."""
        count = len(self.ranges)
        if self.method == "sobol":
            shares = scipy.stats.qmc.Sobol(count, scramble=True, rng=self.seed).random_base2(math.ceil(math.log2(self.size)))[: self.size]
        elif self.method == "random":
            shares = np.random.default_rng(self.seed).random((self.size, count))
        else:
            shares = scipy.stats.qmc.LatinHypercube(count, rng=self.seed).random(self.size)
        columns = [span.values(shares[:, place]) for place, span in enumerate(self.ranges.values())]
        return [dict(zip(self.ranges, values, strict=True)) for values in zip(*columns, strict=True)]


def read_cases(folders: Sequence[Path], name: str) -> list[dict[str, str]]:
    """The cases in a CSV file, dimensions in its first row and one case in each after it; ValueError names file, line and value."""
    path = found_file(folders, name, "cases")
    try:
        if path.stat().st_size > MAX_TABLE:
            raise ValueError(f"it is larger than {MAX_TABLE:,} bytes")
        with path.open(newline="", encoding="utf-8-sig") as file:
            head, *rows = ([cell.strip() for cell in row] for row in csv.reader(file, strict=True) if row)
    except (OSError, ValueError, csv.Error) as error:
        raise ValueError(f"cases: {name}: cannot be read as a table of cases: {error}") from error
    for line, row in enumerate(rows, 2):
        if len(row) != len(head):
            raise ValueError(f"cases: {name}: row {line} has {len(row)} values for {len(head)} dimensions")
    if len(set(head)) < len(head):
        raise ValueError(f"cases: {name}: a dimension appears twice in {', '.join(head)}")
    return [dict(zip(head, row, strict=True)) for row in rows]


def chosen_study(config: Mapping[str, Any], given: Mapping[str, Any]) -> dict[str, Any]:
    """The study of a configuration over which another, ``given``, has been laid.

    One that names its scene stands alone: what the other configuration says is for its own scene.  Of one that names none, the grid,
    cases or sample take the place of the other's.  ValueError for one that stands alone and lacks its name or its runs.
    """
    chosen = {kind: given[kind] for kind in KINDS if given.get(kind) is not None}
    if "scene" in given:
        if "study" not in given:
            raise ValueError(f"study: a study of {given['scene']} needs a name of its own, for the folder of its results")
        if not chosen:
            raise ValueError(f"scene: {given['scene']}: a study of another scene must say which runs it has, by one of {', '.join(KINDS)}")
        return dict(given)
    if chosen:
        return {name: value for name, value in config.items() if name not in KINDS} | chosen
    return dict(config)


def keys_of(path: Path | str) -> set[str]:
    """The keys of a file of a configuration, whatever they hold; none of one that is not a mapping."""
    node = yaml.compose(Path(path).read_text(encoding="utf-8"), yaml.SafeLoader)
    return {str(name.value) for name, _ in node.value} if isinstance(node, yaml.MappingNode) else set()


KINDS = ("grid", "cases", "sample")
"""Keys that say which runs a study has; one of them is set."""
