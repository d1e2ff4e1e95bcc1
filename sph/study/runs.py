"""The runs of a study, a row each, with the stages that they share and the searches of their slopes.

Runs share the *gravity stage* if they agree in every key that acts before the shaking, and the *pre-failure run*, which shakes until the
first failure, if they agree in all keys but ``sph.solver.restart.BRANCH_KEYS``.

A stage is named after the dimensions that act in it (``gravity_soil.cohesion-20``, ``pre_failure_soil.cohesion-20_motion.frequency-1``;
over S_R, gamma and amplitude they are ``gravity`` and ``pre_failure_amplitude-6.0``), or, where runs are numbered, after the first run
that needs it.  A search is named after its limit and ends as the gravity stage of its slope does.  Draws of uncertain soil share the
search for the yield acceleration, of the mean soil, unless each is to be searched.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterator, Mapping
from enum import StrEnum
from typing import Any, Literal, NamedTuple

from sph.scene.configuration import dotted, flat, merge
from sph.scene.names import check_known
from sph.scene.schema import Scene, make_scene
from sph.scene.strict_json import to_json
from sph.scene.uncertain import at_mean
from sph.solver.restart import BRANCH_KEYS, FREE_KEYS, is_among
from sph.solver.run import Until
from sph.stability.record import SLOPE_LIMITS, YIELD
from sph.study.dimensions import ALTERNATIVE, BASE, point_name, scene_key, value_of

SIMULATION = "simulation"
MAX_KEPT = 10_000
"""Scenes of a study that stay in memory, of 4 to 25 kB each."""
LATER = ("motion", "early_stop")
"""Sections without effect in the gravity stage."""


class Kind(StrEnum):
    """What a run is for."""

    GRAVITY = "gravity"
    PRE_FAILURE = "pre_failure"
    RUN = "run"
    SEARCH = "search"


IDLE = {Kind.GRAVITY: (*BRANCH_KEYS, *FREE_KEYS, *LATER), Kind.PRE_FAILURE: BRANCH_KEYS}
"""Keys and sections without effect in a stage, as the solver compares scenes before it continues a stage."""
UNTIL: dict[Kind, Until] = {Kind.GRAVITY: "gravity", Kind.PRE_FAILURE: "first_failure", Kind.RUN: "end", Kind.SEARCH: "end"}


OF_MEAN = "_of_mean"
"""Part of the name of a search that all draws of uncertain soil share."""
DRAW = re.compile(r"uncertain\.(?!variables\.[^.]+\.mean$)")
"""Keys that change what is drawn and not the mean soil."""


class BaseScene:
    """A scene, as a mapping, and its alternatives by name, over which points are laid.  The scene at a point is built once, of the first
    ``MAX_KEPT`` points."""

    def __init__(self, keys: Mapping[str, Any], alternatives: Mapping[str, Mapping[str, Any]] | None = None) -> None:
        self.keys, self._alternatives = keys, {BASE: {}, **(alternatives or {})}
        self._built: dict[frozenset[tuple[str, str]], Scene] = {}

    def at(self, point: Mapping[str, str]) -> dict[str, Any]:
        """The scene with values of dimensions set, as a mapping; ValueError for an alternative that it has not."""
        own = {scene_key(name): value_of(value) for name, value in point.items() if name != ALTERNATIVE}
        return merge(merge(self.keys, self._alternative(point)), dotted(own))

    def acts(self, name: str, point: Mapping[str, str], idle: Collection[str]) -> bool:
        """Whether a dimension of a point has an effect where some keys and sections have none."""
        keys = flat(self._alternative(point)) if name == ALTERNATIVE else [scene_key(name)]
        return not all(is_among(key, idle) for key in keys)

    def _alternative(self, point: Mapping[str, str]) -> Mapping[str, Any]:
        name = point.get(ALTERNATIVE, BASE)
        check_known(ALTERNATIVE, [name], self._alternatives)
        return self._alternatives[name]

    def built(self, point: Mapping[str, str], origin: str) -> Scene:
        """The validated scene with these set; ValueError, whose lines begin with the origin, where it is refused."""
        values = frozenset(point.items())
        scene = self._built.get(values) or make_scene(self.at(point), origin)
        if len(self._built) < MAX_KEPT:
            self._built[values] = scene
        return scene


class PlannedRun(NamedTuple):
    """A run as a job of the workflow makes it: a run, a stage that runs go on from, or a search that makes many of one scene."""

    base: BaseScene
    """over which the point is laid"""
    id: str = ""
    """its name in the folder of its results"""
    point: Mapping[str, str] = {}
    """values of the dimensions that it sets, as written"""
    folder: str = ""
    """of its results, relative to the working folder"""
    place: Literal["runs", "stages"] = "runs"
    """where its file lies in that folder"""
    kind: Kind = Kind.RUN
    parent: str | None = None
    """file of the stage that it goes on from"""
    by: str = SIMULATION
    """or the search that makes many runs of the scene (``sph.stability.record.SEARCHES``)"""
    extrapolates: bool = False
    """whether a search is made at two spacings"""
    enforce_limit: bool = True
    """whether a time step above its limit is refused"""
    group: str = ""
    """runs of one group take about as long"""
    target: str = ""
    """that it belongs to, where that is not the study itself"""

    @property
    def scene(self) -> dict[str, Any]:
        """Its scene as a mapping."""
        return self.base.at(self.point)

    @property
    def built(self) -> Scene:
        """Its scene; ValueError names its file where that is refused."""
        return self.base.built(self.point, self.file)

    @property
    def slope(self) -> str:
        """The keys of its scene that act before the shaking: a limit of two slopes in which these agree is one."""
        acting = {name: value for name, value in flat(self.scene).items() if not is_among(name, IDLE[Kind.GRAVITY])}
        return to_json([acting, list(self.scene.get("layers") or ())], sort_keys=True)

    @property
    def until(self) -> Until:
        """Where it ends."""
        return UNTIL[self.kind]

    @property
    def needs(self) -> str:
        """What is done with its scene, by which a job asks for resources (``sph.study.cost.needs``)."""
        return self.by if self.by != SIMULATION else "gravity" if self.kind == Kind.GRAVITY else "end"

    @property
    def file(self) -> str:
        """Its file, relative to the working folder; its log and benchmark are beside that."""
        return f"{self.folder}/{self.place}/{self.id}.nc"

    @property
    def log(self) -> str:
        """Its log."""
        return f"{self.folder}/logs/{self.id}.log"

    @property
    def benchmark(self) -> str:
        """Its benchmark."""
        return f"{self.folder}/benchmarks/{self.id}.tsv"


class SharedRuns:
    """The runs at some points, by name, with what they share.

    ``pattern`` is what the rows have in common; ``stands`` says whether the scene with some of the dimensions set is a scene.
    """

    def __init__(
        self,
        points: Mapping[str, Mapping[str, str]],
        pattern: PlannedRun,
        numbered: bool,
        stands: Callable[[Mapping[str, str]], bool],
        each_draw: bool = False,
    ) -> None:
        self._pattern, self._numbered, self._stands = pattern, numbered, stands
        self._first: dict[tuple[str, ...], str] = {}
        self.runs: dict[str, PlannedRun] = {}
        """by name"""
        self._stages: dict[Kind, dict[str, PlannedRun]] = {Kind.GRAVITY: {}, Kind.PRE_FAILURE: {}}
        self._gravity_of: dict[str, PlannedRun] = {}
        for name, point in points.items():
            self._add(name, point)
        means: dict[tuple[tuple[str, str], ...], PlannedRun] = {}
        self._searches = {
            (gravity.id, limit): _search(gravity, limit)
            if limit != YIELD or each_draw
            else means.setdefault(_certain(gravity), _search_of_mean(gravity, limit, numbered))
            for gravity in self.gravities
            for limit in SLOPE_LIMITS
        }

    def _add(self, name: str, point: Mapping[str, str]) -> None:
        gravity = self._stage(Kind.GRAVITY, name, point)
        pre_failure = self._stage(Kind.PRE_FAILURE, name, point, gravity.file)
        self._gravity_of[name] = gravity
        self.runs[name] = self._pattern._replace(id=name, point=point, parent=pre_failure.file, group=f"runs of {pre_failure.id}")

    def _stage(self, kind: Kind, run: str, point: Mapping[str, str], parent: str | None = None) -> PlannedRun:
        """The stage of a run; of one that is known already the last parent counts."""
        acting = self._acting(kind, point)
        label = self._first.setdefault((kind, *(f"{key} {value}" for key, value in acting.items())), run)
        name = f"{kind}_{label if self._numbered else point_name(acting)}" if acting else str(kind)
        known = self._stages[kind].get(name)
        stage = known or self._pattern._replace(id=name, point=acting, place="stages", kind=kind, group=str(kind))
        self._stages[kind][name] = stage._replace(parent=parent)
        return stage

    def _acting(self, kind: Kind, point: Mapping[str, str]) -> Mapping[str, str]:
        """The dimensions of a point that act in a stage; all of them where the scene with these alone is refused."""
        acting = {name: value for name, value in point.items() if self._pattern.base.acts(name, point, IDLE[kind])}
        return acting if len(acting) == len(point) or self._stands(acting) else point

    @property
    def gravities(self) -> list[PlannedRun]:
        """All gravity stages."""
        return list(self._stages[Kind.GRAVITY].values())

    @property
    def pre_failures(self) -> list[PlannedRun]:
        """All shared pre-failure runs."""
        return list(self._stages[Kind.PRE_FAILURE].values())

    def gravity_of(self, run: str) -> PlannedRun:
        """The gravity stage of a run."""
        return self._gravity_of[run]

    def search_of(self, run: str) -> PlannedRun:
        """The search for the yield acceleration of the slope of a run."""
        return self._searches[self._gravity_of[run].id, YIELD]

    def searches(self, limit: str) -> list[PlannedRun]:
        """The searches for a limit of all slopes."""
        return list({search.file: search for (_, sought), search in self._searches.items() if sought == limit}.values())

    def __iter__(self) -> Iterator[PlannedRun]:
        """Stages, runs and searches."""
        searches = {search.file: search for search in self._searches.values()}
        yield from (*self.gravities, *self.pre_failures, *self.runs.values(), *searches.values())


def _search(gravity: PlannedRun, limit: str) -> PlannedRun:
    """The search for a limit of the slope of a gravity stage."""
    name = limit + gravity.id.removeprefix(Kind.GRAVITY)
    return gravity._replace(id=name, kind=Kind.SEARCH, by=limit, extrapolates=True, group="search")


def _certain(gravity: PlannedRun) -> tuple[tuple[str, str], ...]:
    """The values of a gravity stage without those of the draw of uncertain soil; the means of its distributions are kept."""
    return tuple((name, value) for name, value in gravity.point.items() if not DRAW.match(scene_key(name)))


def _search_of_mean(gravity: PlannedRun, limit: str, numbered: bool) -> PlannedRun:
    """The same with the means of what is uncertain, where the draw differs from run to run: all draws share it."""
    own, known = _search(gravity, limit), dict(_certain(gravity))
    if len(known) == len(gravity.point):
        return own
    label = gravity.id.removeprefix(Kind.GRAVITY) if numbered else f"_{point_name(known)}" if known else ""
    return own._replace(base=BaseScene(at_mean(gravity.scene, gravity.id)), point={}, id=f"{limit}{OF_MEAN}{label}")
