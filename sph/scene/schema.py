"""The scene: everything a run needs, validated before any work and immutable.

A scene file (YAML) holds the sections below.  Users write kPa and degrees; the
properties ending in ``_si`` give pascals and radians to the solver.  Every key is
declared here once, with its unit, allowed range, default and source, and
``docs/reference/scene-keys.md`` has its table from these declarations (``python -m tools.reference scene`` prints it).

A term of physics that a scene does not want is ``null``; a term it wants is a small
record of its own coefficients.  There are no on/off flags beside coefficients.
"""

from __future__ import annotations

import functools
import math
import re
import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field, ModelWrapValidatorHandler, field_validator, model_validator

from sph.scene.configuration import OwnName, Section, key, merge, read_scene, validated, whole_multiple
from sph.scene.geometry import Geometry
from sph.scene.gravity import (
    FAILED_AREA,
    FAILED_SHARE,
    MIN_MOVED,
    UNSHAKEN,
    GravityStage,
    InitialVelocity,
    UniformStress,
    VelocityGradient,
)
from sph.scene.ground_motion.record import Record, own_peak, processed
from sph.scene.laboratory import RESIDUALS, as_computed
from sph.scene.layers import Layer, LayerMaterial, check_coupling, materials_of
from sph.scene.motion import MISSED, STEPS_IN_PERIOD, ConstantAcceleration, Motion, NoMotion, Ricker, vertical_acceleration
from sph.scene.numerics import Numerics
from sph.scene.places import ABOVE, RIGHT, Point
from sph.scene.scheme import filled, missing
from sph.scene.seams import Seam, check_seams
from sph.scene.soil import Coupling, Soil
from sph.scene.uncertain import Uncertain, Variable, check_varying, drawn, told
from sph.scene.units import in_both
from sph.scene.walls import Walls, check_walls
from sph.scene.water import Water, check_water

MAX_PARTICLES = 5_000_000
"""Most particles of a scene: lattice points of the box and its walls."""

MAX_PAIRS = 1_000_000_000
"""Most pairs of neighbours, whose lists take some 30 bytes each."""

MAX_STEPS = 20_000_000
"""Most time steps of a run; the loads of every step are kept, 40 bytes each."""

MAX_SAMPLES = 1_000_000
"""Most samples of the series of a run."""

MAX_STORED = 200_000_000
"""Most frames times particles of a run, whose fields take 58 bytes each."""

Frequency = Annotated[float, Field(ge=1e-3, le=1e4)]


class RayleighDamping(Section):
    """Rayleigh damping from one damping ratio met at two frequencies (Sec. 2.5)."""

    ratio: float = key("damping ratio at both frequencies", source="ours", ge=0, le=0.5, default=0.02)
    frequencies: tuple[Frequency, Frequency] = key("the two frequencies, from 0.001 to 10000 Hz", "Hz", default=(1.0, 5.6))

    @model_validator(mode="after")
    def _increasing(self) -> RayleighDamping:
        if not self.frequencies[0] < self.frequencies[1]:
            raise ValueError(f"damping: frequencies {list(self.frequencies)} must be increasing")
        return self

    @property
    def mass_coefficient(self) -> float:
        """alpha, 1/s."""
        w1, w2 = (2 * math.pi * f for f in self.frequencies)
        return 2 * self.ratio * w1 * w2 / (w1 + w2)

    @property
    def stiffness_coefficient(self) -> float:
        """beta_R, s."""
        w1, w2 = (2 * math.pi * f for f in self.frequencies)
        return 2 * self.ratio / (w1 + w2)

    def at(self, frequency: float | np.ndarray) -> Any:
        """Damping ratio at a frequency, Hz, or an array of those at an array of any shape."""
        omega = 2.0 * math.pi * frequency
        return 0.5 * (self.mass_coefficient / omega + self.stiffness_coefficient * omega)


class EarlyStop(Section):
    """When a run may end before its duration: after the shaking, once the soil has stood still and its loss of strength is over."""

    speed: float = key(
        "speed below which the soil (root mean square over its mass) and every probe stay throughout the window",
        "m/s",
        gt=0,
        le=100,
        default=0.02,
    )
    window: float = key("length of the interval at rest after the shaking; the run ends with it", "s", gt=0, le=1000, default=1.0)
    solid_weight: float = key(
        "largest weight of the solid state (beta) left in any failed particle; with more, the slope may stand now and fail later",
        ge=0,
        lt=1,
        default=0.05,
    )


class Outputs(Section):
    """What a run stores, and how often."""

    frame_interval: float = key(
        "interval of the particle fields, which are also stored at the ends of the gravity stage, the shaking and the run",
        "s",
        gt=0,
        le=1e4,
        default=0.25,
    )
    series_interval: float = key("interval of probes, energies and other series", "s", gt=0, le=1e4, default=0.01)


Place = Literal["crest_edge", "toe"] | Point


class Scene(Section):
    """One simulation."""

    name: str = key("name used in file names and titles", pattern=r"^[A-Za-z0-9][A-Za-z0-9_.-]{0,63}$")
    title: str = key("one line for figures and tables", default="", max_length=200)
    scheme: Literal["resolved", "paper"] = key(
        "defaults of keys that are left out: resolved, walls and discretisation for your own slopes, which must give soil, coupling and"
        " damping; paper, the paper's scene",
        default="resolved",
    )
    duration: float = key("simulated time", "s", "Sec. 4 (15 s)", gt=0, le=1e4, default=15.0)
    geometry: Geometry = key("shape of the soil", source="Fig. 1")
    walls: Walls = key("the box", source="Sec. 2.4", default=Walls())
    soil: Soil = key("material", source="Tables 1-2", default=Soil())
    layers: dict[OwnName, Layer] = key(
        "regions of other soil, by name; where two overlap, the later one counts", default={}, max_length=100
    )
    seams: dict[OwnName, Seam] = key(
        "weak planes, thinner than the particles, by name: continuous at any spacing", default={}, max_length=100
    )
    water: Water | None = key("water in the pores; null: none", default=None)
    uncertain: Uncertain | None = key("keys of this scene that are drawn from distributions; null: none", default=None)
    coupling: Coupling = key("solid-fluid coupling", source="Sec. 2.3", default=Coupling())
    motion: Motion = key("ground motion", source="Sec. 3.2", default=NoMotion())
    gravity: GravityStage = key("gravity stage", default=GravityStage())
    initial_velocity: InitialVelocity | None = key("velocity at the start", default=None)
    prescribed_velocity_gradient: VelocityGradient | None = key(
        "velocity gradient of the soil in an element test, throughout the run", default=None
    )
    damping: RayleighDamping | None = key("Rayleigh damping", source="Sec. 2.5", default=RayleighDamping())
    early_stop: EarlyStop | None = key("end of a run before its duration, once the soil has come to rest", default=None)
    numerics: Numerics = key("discretisation", source="Secs. 2.6, 4", default=Numerics())
    outputs: Outputs = key("stored data", default=Outputs())
    probes: dict[OwnName, Place] = key(
        "particles whose motion is recorded, by name: a place ('crest_edge', 'toe') or [x, y] in m, in the coordinates of the survey if"
        " there is one; the nearest particle is taken",
        source="particle A: Figs. 6-7",
        default={"A": "crest_edge"},
    )

    @model_validator(mode="wrap")
    @classmethod
    def _complete_layers(cls, data: Any, make: ModelWrapValidatorHandler[Scene]) -> Scene:
        """Layers whose soil is the scene's own but for the keys they name, which their soil knows as the keys that were set."""
        if not isinstance(data, Mapping) or not isinstance(data.get("layers"), Mapping):
            return make(data)
        own = data.get("soil", {})
        named = {
            name: layer.get("soil", {})
            for name, layer in data["layers"].items()
            if isinstance(layer, Mapping) and isinstance(own, Mapping) and isinstance(layer.get("soil", {}), Mapping)
        }
        complete = {name: {**data["layers"][name], "soil": merge(own, soil)} for name, soil in named.items()}
        scene = make({**data, "layers": {**data["layers"], **complete}})
        for name, soil in named.items():
            scene.layers[name].soil.model_fields_set.intersection_update(soil)
        return scene

    @field_validator("title")
    @classmethod
    def _one_line(cls, title: str) -> str:
        if not title.isprintable():
            raise ValueError("must be one line of printable characters")
        return title

    @model_validator(mode="after")
    def _consistent(self) -> Scene:
        self._check_size()
        dt = self.numerics.time_step
        for name in ("series_interval", "frame_interval"):
            whole_multiple(getattr(self.outputs, name), dt, f"outputs.{name}", "numerics.time_step")
        whole_multiple(self.outputs.frame_interval, self.outputs.series_interval, "outputs.frame_interval", "outputs.series_interval")
        whole_multiple(self.duration, self.outputs.series_interval, "duration", "outputs.series_interval")
        whole_multiple(self.gravity.duration, self.outputs.series_interval, "gravity.duration", "outputs.series_interval")
        if self.early_stop is not None:
            whole_multiple(self.early_stop.window, self.outputs.series_interval, "early_stop.window", "outputs.series_interval")
        if not isinstance(self.motion, NoMotion) and self.motion.start < self.gravity.duration * (1 - 1e-9):
            where = "motion.peak: the start of the wavelet," if isinstance(self.motion, Ricker) else "motion.start:"
            raise ValueError(f"{where} {self.motion.start:g} s lies inside the gravity stage (gravity.duration: {self.gravity.duration} s)")
        self._check_sampling()
        if self.gravity.ramp > self.gravity.duration:
            raise ValueError(f"gravity.ramp: {self.gravity.ramp} s is longer than gravity.duration: {self.gravity.duration} s")
        if self.gravity.initial_stress == "geostatic" and self.gravity.ramp > 0:
            raise ValueError(
                f"gravity.ramp: {self.gravity.ramp} s with gravity.initial_stress: geostatic, "
                "which balances gravity in full from the start; set gravity.ramp: 0"
            )
        self._check_at_rest()
        if self.gravity.initial_stress == "geostatic" and self.gravity.inclination != 0:
            raise ValueError(
                f"gravity.inclination: {self.gravity.inclination} degree must be 0 with gravity.initial_stress: geostatic (level ground)"
            )
        if self.gravity.duration > self.duration:
            raise ValueError(f"gravity.duration: {self.gravity.duration} s is longer than duration: {self.duration} s")
        if isinstance(self.gravity.initial_stress, UniformStress):
            pressure, bulk_modulus = self.gravity.initial_stress.pressure, 1e-3 * min(soil.bulk_modulus_si for soil in self.soils)
            if not abs(pressure) < bulk_modulus:
                raise ValueError(
                    f"gravity.initial_stress.pressure: {pressure} kPa is not smaller than the bulk modulus, {bulk_modulus:g} kPa"
                )
        if 2 * self.numerics.smoothing_length < 1.2 * self.numerics.spacing * (1 - 1e-9):
            raise ValueError(
                f"numerics.smoothing_ratio: {self.numerics.smoothing_ratio} with smoothing_length_is: {self.numerics.smoothing_length_is} "
                "ends the kernel within 1.2 spacings, where it holds too few neighbours"
            )
        check_coupling(self)
        check_walls(self)
        check_water(self)
        check_seams(self)
        check_varying(self)
        if self.numerics.spacing * 2 > min(self.geometry.height, self.geometry.width):
            raise ValueError(f"numerics.spacing: {self.numerics.spacing} m leaves fewer than two particles across the soil")
        return self

    def _check_size(self) -> None:
        """Refuse what no machine at hand can hold or finish, before anything is made of it."""
        numerics, outputs, layers = self.numerics, self.outputs, self.walls.layers
        columns, rows = self.lattice
        particles, steps = (columns + 2 * layers) * (rows + 2 * layers), self.steps(self.duration)
        box = f"in the box of {self.geometry.width:g} x {self.geometry.height:g} m"
        if particles > MAX_PARTICLES:
            raise ValueError(
                f"numerics.spacing: {numerics.spacing} m makes {particles:,} particles {box}, walls included, at most {MAX_PARTICLES:,}; "
                "choose a larger spacing or a smaller geometry"
            )
        pairs = particles * math.pi * (2 * numerics.smoothing_length / numerics.spacing + numerics.neighbour_skin) ** 2
        if pairs > MAX_PAIRS:
            raise ValueError(
                f"numerics.smoothing_ratio: {numerics.smoothing_ratio} makes {pairs:.3g} pairs of {particles:,} particles {box}, "
                f"at most {MAX_PAIRS:,}; choose a smaller one or a larger numerics.spacing"
            )
        if steps > MAX_STEPS:
            raise ValueError(
                f"numerics.time_step: {numerics.time_step} s makes {steps:,} steps of duration: {self.duration} s, at most {MAX_STEPS:,}; "
                "choose a larger step or a shorter duration"
            )
        if self.duration > MAX_SAMPLES * outputs.series_interval:
            raise ValueError(
                f"outputs.series_interval: {outputs.series_interval} s makes more than {MAX_SAMPLES:,} samples of duration: "
                f"{self.duration} s; choose a longer interval or a shorter duration"
            )
        if particles * self.duration > MAX_STORED * outputs.frame_interval:
            raise ValueError(
                f"outputs.frame_interval: {outputs.frame_interval} s stores {particles:,} particles more than {MAX_STORED:,} times in "
                f"duration: {self.duration} s; choose a longer interval, a shorter duration or a larger numerics.spacing"
            )

    def _check_sampling(self) -> None:
        """Refuse a motion that the time steps do not resolve; adaptive steps are at most as long.

        A load that is brought on within a step (``constant``) acts from that step on.
        """
        step, motion = self.numerics.time_step, self.motion
        if isinstance(motion, Record):
            self._check_record(motion)
        elif not isinstance(motion, (NoMotion, ConstantAcceleration)) and motion.amplitude > 0:
            longest = motion.shortest_period / STEPS_IN_PERIOD
            if step > longest * (1 + 1e-9):
                raise ValueError(
                    f"numerics.time_step: {step:g} s is too long for motion ({motion.kind}), whose shortest period, "
                    f"{motion.shortest_period:.3g} s, must hold {STEPS_IN_PERIOD} steps; choose at most {longest:.3g} s, or a slower motion"
                )

    def _check_record(self, record: Record) -> None:
        if record.data is not None and record.data.instrument == "borehole" and self.walls.kinds.base.absorbs:
            raise ValueError(
                f"motion.file: {record.file} was recorded in a borehole, within the ground, and walls.base: {self.walls.base} needs the "
                "motion of an outcrop; name the record of the instrument at the surface (.EW2, .NS2), if the ground there is that below "
                "the base, or let the model end at the depth of the borehole with walls.base: no_slip, whose motion is that within it"
            )
        step, made = self.numerics.time_step, processed(record)
        interval = float(made.time[1])
        if step > interval * (1 + 1e-6):
            raise ValueError(
                f"numerics.time_step: {step:g} s would skip samples of motion, a record every {interval:.6g} s; "
                "choose a shorter step, or a longer motion.resample.interval"
            )
        for samples in (made.horizontal, made.vertical):
            peak = int(np.abs(samples).argmax())
            before = math.floor((record.start + made.time[peak]) / step + 1e-6)
            felt = np.interp(step * np.array([before, before + 1]) - record.start, made.time, samples, left=0.0, right=0.0)
            if np.abs(felt).max() < (1.0 - MISSED) * abs(samples[peak]):
                raise ValueError(
                    f"numerics.time_step: {step:g} s misses {1.0 - np.abs(felt).max() / abs(samples[peak]):.1%} of the peak of motion, "
                    f"a record every {interval:.6g} s from {record.start:g} s on; choose a step that divides both, or a shorter one"
                )

    def _check_at_rest(self) -> None:
        """Refuse a K0 that nothing would take."""
        for path, soil in zip(self.soil_keys, self.soils, strict=True):
            if soil.K0 is not None and self.gravity.initial_stress != "geostatic":
                raise ValueError(
                    f"{path}.K0: {soil.K0:g} with gravity.initial_stress: {self.gravity.initial_stress}, which ramps gravity up in "
                    "stress-free soil; leave out gravity.initial_stress and gravity.ramp, or set them to geostatic and 0, or K0 to null"
                )

    @property
    def varying(self) -> list[Variable]:
        """Variables that vary in space."""
        return [] if self.uncertain is None else self.uncertain.varying

    @property
    def strength_varies(self) -> bool:
        """Whether soil of one kind has another strength from place to place: by a random field, or since it grows with depth."""
        return bool(self.varying) or any(soil.gradient for soil in self.soils)

    def stored(self) -> str:
        """The scene as JSON: all its keys, but of a layer's soil those that it names, so that what is laid over the scene reaches it."""

        def inherited(layer: Layer) -> set[str]:
            kept = {key for key, value in self.soil if key not in layer.soil.model_fields_set and getattr(layer.soil, key) == value}
            return kept if layer.S_R is None else {key for key in kept if key not in RESIDUALS or getattr(self.soil, key) is None}

        return self.model_dump_json(exclude={"layers": {name: {"soil": inherited(layer)} for name, layer in self.layers.items()}})

    @functools.cached_property
    def materials(self) -> tuple[LayerMaterial, ...]:
        """The material of the scene's own soil and those of its layers in order, with what they take from the whole scene."""
        return materials_of(self)

    def model_copy(self, *, update: Mapping[str, Any] | None = None, deep: bool = False) -> Scene:
        """A copy with other sections, not validated; what follows from the sections is worked out anew."""
        copied = super().model_copy(update=update, deep=deep)
        copied.__dict__.pop("materials", None)
        return copied

    @property
    def soils(self) -> tuple[Soil, ...]:
        """The scene's own soil and those of its layers in order."""
        return self.soil, *(layer.soil for layer in self.layers.values())

    @property
    def soil_keys(self) -> tuple[str, ...]:
        """Dotted keys of these soils."""
        return "soil", *(f"layers.{name}.soil" for name in self.layers)

    @property
    def largest_p_wave_speed(self) -> float:
        """V_p of the stiffest soil, m/s."""
        return max(soil.p_wave_speed for soil in self.soils)

    @property
    def lattice(self) -> tuple[int, int]:
        """Columns and rows of the lattice at half offsets that fills the box."""
        sides = ((self.geometry.width, RIGHT), (self.geometry.height, ABOVE))
        columns, rows = (math.ceil(side / self.numerics.spacing - 0.5 - shift) for side, shift in sides)
        return columns, rows

    @property
    def layers_filling_support(self) -> int:
        """Layers of boundary particles that fill the kernel's support but for one spacing, where the gradient fades."""
        return math.ceil(2 * self.numerics.smoothing_length / self.numerics.spacing - 1 - 1e-9)

    @property
    def shaken_from(self) -> float:
        """Time from which on shaking can be the cause of failure, s: of the first acceleration above ``UNSHAKEN`` of gravity; infinite
        where there is none."""
        steps = self.steps(self.duration) + 1
        for first in range(0, steps, 10_000):  # all at once would take more memory than the run's metrics
            time = np.arange(first, min(first + 10_000, steps)) * self.numerics.time_step
            ground, vertical = self.motion.acceleration(time), vertical_acceleration(self.motion, time)
            shaken = np.maximum(np.abs(ground), np.abs(vertical)) > UNSHAKEN * self.gravity.acceleration
            if shaken.any():
                return float(time[np.argmax(shaken)])
        return math.inf

    def held(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Which places (n,) in the box lie within the kernel's support of a fixed side wall or lid, m.

        Soil that settles under gravity is carried by such a wall, and yields for that; a fixed base supports it from below.
        """
        (columns, rows), dx, support = self.lattice, self.numerics.spacing, 2.0 * self.numerics.smoothing_length
        held = np.zeros(np.shape(x), bool)
        if self.walls.kinds.sides.holds_soil:
            held |= np.minimum(x, columns * dx - x) < support
        if self.walls.kinds.top.holds_soil:
            held |= rows * dx - y < support
        return held

    def unshaken(self, t_f: np.ndarray, held: np.ndarray | bool = False) -> np.ndarray:
        """Which particles (n,) failed under gravity alone, by their times of failure (s): when the gravity stage ended, or from then until
        the ground is shaken (``shaken_from``), but for those that walls ``held``, which fail at the least shaking because a wall carries
        them.  Soil that a prescribed deformation moves fails by that."""
        failed = self.gravity.failed(t_f)
        if self.prescribed_velocity_gradient is not None:
            return failed
        return failed | ((t_f > self.gravity.duration) & (t_f < self.shaken_from - 0.5 * self.numerics.time_step) & ~np.asarray(held))

    def length_in_soil(self, seam: Seam) -> float:
        """Length of a seam below the ground and above the base, m, to a two-hundredth of each part of its line."""
        x, y = self.geometry.in_box(*seam.middles(200))
        lengths = np.repeat(np.hypot(*np.diff(np.array(seam.points), axis=0).T) / 200, 200)
        inside = (x > 0.0) & (x < self.geometry.width) & (y > 0.0) & (y < self.geometry.ground(x))
        return float(lengths[inside].sum())

    def fails_unshaken(self, failed: int, moved: int = 0, failed_of_moved: int = 0) -> bool:
        """Whether so many soil particles, failed under gravity alone, are a slope that has failed.

        They cover more than ``FAILED_AREA`` H^2; or of the soil that has moved in the end, by more than ``MOVED`` H since the gravity
        stage, more than ``FAILED_SHARE`` is among them, as in a mechanism that is small beside H^2.
        """
        height = self.geometry.crest[1] - self.geometry.toe[1]
        falls = moved >= MIN_MOVED and failed_of_moved > FAILED_SHARE * moved
        return falls or failed * self.numerics.spacing**2 > FAILED_AREA * height**2

    def steps(self, time: float) -> int:
        """Number of time steps to a time (s)."""
        return round(time / self.numerics.time_step)


def make_scene(data: Mapping[str, Any], origin: str = "scene") -> Scene:
    """Validate a mapping; raises ValueError with one line per bad key: where, value, what is allowed.

    Keys that ``uncertain`` draws take the values of its seed.
    """
    return _made(as_computed(drawn(data, origin), origin), origin)


def _made(data: Mapping[str, Any], origin: str) -> Scene:
    needed = missing(data, origin)
    try:
        made = validated(Scene, filled(data), origin)
    except ValueError as error:
        raise ValueError("\n".join([str(error), *needed, *told(data, origin, str(error))])) from error
    if needed:
        raise ValueError("\n".join(needed))
    return made


def stored_scene(data: Mapping[str, Any], origin: str = "scene") -> Scene:
    """The scene that a file of this or an earlier version holds; ValueError as above.

    Every version has written every key, with what the scheme filled in, so the scheme fills in nothing here.  What has become a key since
    then was as in the paper's scene, but for the solid state of failed soil, which stayed on its yield surface.  Fixed walls were called
    sticky by 0.1.0.
    """
    walls = data.get("walls")
    if isinstance(walls, Mapping):
        data = {**data, "walls": {name: "fixed" if kind == "sticky" else kind for name, kind in walls.items()}}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", FutureWarning)  # nobody can write a stored scene anew
        earlier = {"scheme": "paper", "coupling": {"solid_after_failure": "elastic_plastic"}}
        return validated(Scene, merge(earlier, data), origin)


def written_scene(path: Path | str) -> dict[str, Any]:
    """Mapping in a scene's file; the default probes are among its keys, so that one laid over it stands beside them."""
    return {"probes": Scene.model_fields["probes"].default, **read_scene(path)}


def check_unit(amplitude: Any, scene: Scene, where: str) -> None:
    """ValueError where an ``amplitude``, as it is written for a scene with a record, is a number below 1 without a unit and the record has
    more than 1 m/s2: it may be meant in g."""
    texts = [amplitude] if isinstance(amplitude, (int, float, str)) else []
    bare = [text for text in texts if isinstance(text, (int, float)) or re.fullmatch(r"\s*\d*\.?\d+\s*", text)]
    if bare and isinstance(scene.motion, Record) and 0.0 < float(bare[0]) < 1.0 < (peak := own_peak(scene.motion)):
        raise ValueError(
            f"{where}: {bare[0]} has no unit, and the record has {in_both(peak)}: write {bare[0]}g or '{bare[0]} m/s2', whichever is meant"
        )


def written_amplitude(data: Mapping[str, Any]) -> Any:
    """``motion.amplitude`` of a scene's mapping as it is written; None without it."""
    motion = data.get("motion")
    return motion.get("amplitude") if isinstance(motion, Mapping) else None


def load_scene(path: Path | str, overrides: Mapping[str, Any] | None = None) -> Scene:
    """Scene of a YAML file with nested overrides laid over it; raises ValueError before any work."""
    data = merge(written_scene(path), overrides or {})
    scene = make_scene(data, str(path))
    check_unit(written_amplitude(data), scene, f"{path}: motion.amplitude")
    return scene
