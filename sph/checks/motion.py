"""Findings of a ground motion: its peak, drift, offset and direction, and whether the run lasts as long."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
import scipy  # type: ignore[import-untyped]

from sph.checks.finding import Finding, finding
from sph.scene.geometry import SLOPES, Bodies
from sph.scene.gravity import GRAVITY
from sph.scene.ground_motion import GroundMotion
from sph.scene.ground_motion.record import Record, processed
from sph.scene.loading import Loading, loading_of
from sph.scene.motion import ConstantAcceleration, NoMotion
from sph.scene.natural_periods import column_at, first_peak, impedance_below, natural_frequency
from sph.scene.schema import Scene
from sph.scene.units import in_both
from sph.stability.newmark import sliding_block

WEAKEST, STRONGEST = 0.01, 2.0
"""Peak accelerations of the ground that are plausible, g: below a hundredth of g no slope that stands is moved, and of all records a
handful exceed 2 g (2.7 g horizontally at MYG004, Tohoku 2011; 3.9 g vertically at IWTH25, Iwate-Miyagi 2008).  Beyond them units are
mistaken more often than not."""
MAX_DRIFT = 0.1
"""Velocity of the ground at the end of a record over its largest."""
MAX_OFFSET = 0.01
"""Mean acceleration of a record that drifts over its peak: beyond it the drift is an offset of the recorder."""
MAX_DISPLACEMENT = 2.0
"""Peak displacement of the ground that is plausible, m: more than that is found beside faults that broke the surface."""
MAX_INTERVAL = 0.1
"""Interval of the samples of a record that is plausible, s: recorders have taken 50 and more in a second since the first digital ones."""
LASTING, MIN_LASTING = 0.5, 0.1
"""Displacement of the ground at the end of a record over its largest, and in m, from which on it is told."""
POLARITY_RATIO, POLARITY = 0.5, 1.2
"""Yield over peak acceleration of a sliding block, and its displacement under the record turned round over that under the record as it
is, from which on the direction of a record matters."""
MIN_SLIP = 1e-3
"""Displacement of a block below which it does not matter, m: the least slip at which soil begins to lose strength (``sph new``)."""

LOWEST, HIGHEST = 0.25, 20.0
"""Frequencies between which a motion has its mean period, Hz."""
MAX_RIGID = 0.1
"""Natural period of the slope over the mean period of the motion up to which a sliding block may be rigid; from there to 1 it slips too
little, beyond that more or less than the slope moves (Jibson 2011)."""
SOFTER = 0.9
"""Impedance of bedrock over that of the lowest soil below which it is told: ground hardly gets softer with depth."""
OTHER_DAMPING = 2.0
"""Damping ratio of the first mode over the one that is given, from which on the frequencies of the damping are another column's."""
NO_PEAK = "none: below the base lies soil like the lowest, or softer, so only the depth of the model sets the column frequency"


def cut_off(scene: Scene) -> list[Finding]:
    """A warning if the run ends before the motion does."""
    if isinstance(scene.motion, NoMotion) or scene.motion.end <= scene.duration:
        return []
    return [finding("motion-cut-off", "duration", value=scene.duration, bound=scene.motion.end)]


def of_motion(scene: Scene, loading: Loading) -> list[Finding]:
    """All findings of the shaking of a scene, from its loads."""
    components = {"horizontal": loading.ground, "vertical": loading.vertical}
    scaling = ("motion.factor", "motion.unit") if isinstance(scene.motion, Record) else ("motion.amplitude",)
    return cut_off(scene) + sampled(scene) + of_record(scene) + implausible(components, *scaling)


def mean_period(motion: GroundMotion) -> float:
    """Mean period of an evenly sampled motion, s: periods weighted by the squared Fourier amplitudes, which lie at most 0.05 Hz apart.

    Rathje, Faraj, Russell and Bray (2004); 0 where there is no motion between ``LOWEST`` and ``HIGHEST``.
    """
    interval = float(motion.time[1] - motion.time[0])
    size = max(motion.acceleration.size, math.ceil(20.0 / interval))
    frequency, power = np.fft.rfftfreq(size, interval), np.abs(np.fft.rfft(motion.acceleration, size)) ** 2
    there = (frequency >= LOWEST) & (frequency <= HIGHEST)
    total = power[there].sum()
    return float((power[there] / frequency[there]).sum() / total) if total > 0.0 else 0.0


def frequency_rows(scene: Scene) -> list[tuple[str, str]]:
    """Label and text of the natural frequencies of the ground and of the damping there, for summaries; none where bodies lie in the box."""
    geometry = scene.geometry
    if isinstance(geometry, Bodies):
        return []
    places = {"crest edge": geometry.crest} | ({"toe": geometry.toe} if isinstance(geometry, SLOPES) else {})
    frequencies = {name: natural_frequency(scene, place) for name, place in places.items()}
    told = [f"{frequency:.3g} Hz below the {name}" for name, frequency in frequencies.items() if math.isfinite(frequency)]
    rows = [("column frequency", f"{', '.join(told)}: first mode of the layers down to the base of the model, held there")]
    column = column_at(scene, geometry.crest)
    below = impedance_below(scene, column)
    if math.isfinite(below):
        peak = first_peak(column, below)
        words = f"{peak.frequency:.3g} Hz, {peak.amplification:.3g} times, undamped" if peak else NO_PEAK
        rows.append(("resonance over the half-space", words))
    if scene.damping is not None and scene.damping.ratio > 0.0:
        frequency = frequencies["crest edge"]
        low, high = scene.damping.frequencies
        words = f"{scene.damping.ratio:.3g} at {low:g} and {high:g} Hz, {scene.damping.at(frequency):.3g} at the {frequency:.3g} Hz"
        rows.append(("damping ratio", f"{words} of the column below the crest edge"))
    return rows


def of_damping(scene: Scene) -> list[Finding]:
    """A warning where the first mode of the ground below the crest edge is damped much more than the ratio that is given."""
    if not isinstance(scene.geometry, SLOPES) or scene.damping is None or scene.damping.ratio == 0.0:
        return []
    frequency, given = natural_frequency(scene, scene.geometry.crest), scene.damping.ratio
    ratio = scene.damping.at(frequency)
    if ratio <= OTHER_DAMPING * given:
        return []
    low, high = (float(f"{each:.3g}") for each in (frequency, max(frequency * 5.0, scene.damping.frequencies[1])))
    key = f"damping.frequencies=[{low:g}, {high:g}]"
    return [finding("damping-off-frequency", key, value=ratio, bound=OTHER_DAMPING * given, given=given, frequency=frequency)]


def soft_bedrock(scene: Scene) -> list[Finding]:
    """A warning if the bedrock of an absorbing base is softer than the ground on it."""
    if not isinstance(scene.geometry, SLOPES):
        return []
    column = column_at(scene, scene.geometry.crest)
    below, lowest = impedance_below(scene, column), float(column.impedance[-1])
    return [finding("soft-bedrock", "walls.bedrock", value=below, bound=lowest)] if below < SOFTER * lowest else []


def not_rigid(scene: Scene, loading: Loading) -> list[Finding]:
    """A note if the ground below the crest is too soft for a rigid block to move like the slope."""
    if not isinstance(scene.geometry, SLOPES) or isinstance(scene.motion, (NoMotion, ConstantAcceleration)):
        return []
    mean, period = mean_period(GroundMotion(loading.time, loading.ground)), 1.0 / natural_frequency(scene, scene.geometry.crest)
    if not mean or period <= MAX_RIGID * mean:
        return []
    return [finding("block-not-rigid", value=period / mean, bound=MAX_RIGID, period=period)]


def peak_accelerations(scene: Scene) -> str:
    """Peak accelerations of the ground in a run, of the motion as processed and scaled."""
    loading = loading_of(scene)
    peaks = {"horizontal": np.abs(loading.ground).max(), "vertical": np.abs(loading.vertical).max()}
    return ", ".join(f"{name} {in_both(float(peak))}" for name, peak in peaks.items() if peak or name == "horizontal")


def of_record(scene: Scene) -> list[Finding]:
    """Findings on the record of a scene after its processing: offset, drift, displacement, polarity."""
    if not isinstance(scene.motion, Record):
        return []
    made = processed(scene.motion)
    motion = GroundMotion(made.time, made.horizontal)
    return drifting(motion, "motion.baseline={}") + one_sided(motion, f"motion.factor={-scene.motion.factor:g}")


def implausible(components: Mapping[str, np.ndarray], *keys: str) -> list[Finding]:
    """A warning for each peak of accelerations (n,) in m/s2, by direction, the horizontal first, that is not plausible; 0 is."""
    least, most = WEAKEST * GRAVITY, STRONGEST * GRAVITY
    peaks = {name: float(np.abs(values).max()) for name, values in components.items()}
    return [
        finding("pga-implausible", *keys, subject=name, value=peak, bound=most if peak > most else least, least=least, most=most)
        for name, peak in peaks.items()
        if peak > most or name == "horizontal" and 0.0 < peak < least
    ]


def sampled(scene: Scene) -> list[Finding]:
    """A warning if the samples of a scene's record, as read, lie far apart."""
    data = scene.motion.data if isinstance(scene.motion, Record) else None
    return [] if data is None else sparse(data.interval, "motion.file")


def sparse(interval: float, *keys: str) -> list[Finding]:
    """A warning if the samples of a record are further apart (s) than those of recorders."""
    return [finding("record-sparse", *keys, value=interval, bound=MAX_INTERVAL)] if interval > MAX_INTERVAL else []


def drifting(motion: GroundMotion, *keys: str) -> list[Finding]:
    """Findings of a record whose ground does not come to rest, moves too far or ends elsewhere; a key removes the drift.

    An offset of the recorder moves a sliding block like shaking, whatever drift it leaves.
    """
    time, acceleration = motion
    velocity = scipy.integrate.cumulative_trapezoid(acceleration, time, initial=0.0)
    displacement = scipy.integrate.cumulative_trapezoid(velocity, time, initial=0.0)
    largest, last = float(np.abs(velocity).max()), abs(float(velocity[-1]))
    furthest, lasting = float(np.abs(displacement).max()), abs(float(displacement[-1]))
    findings, bound = [], MAX_DRIFT * largest
    if last > bound:
        mean = last / float(time[-1] - time[0])
        findings.append(
            finding("record-offset" if mean > MAX_OFFSET * motion.peak else "record-drift", *keys, value=last, bound=bound, mean=mean)
        )
    if furthest > MAX_DISPLACEMENT:
        findings.append(finding("record-displacement", *keys, value=furthest, bound=MAX_DISPLACEMENT))
    elif lasting > max(LASTING * furthest, MIN_LASTING):
        findings.append(finding("record-lasting", *keys, value=lasting, peak=furthest))
    return findings


def one_sided(motion: GroundMotion, *keys: str) -> list[Finding]:
    """A note if the reversed record drives a sliding block further."""
    strength = POLARITY_RATIO * motion.peak
    as_it_is, turned = _both_ways(motion, strength) if strength > 0.0 else (0.0, 0.0)
    if turned <= POLARITY * as_it_is:
        return []
    return [finding("record-polarity", *keys, reversed=turned, as_recorded=as_it_is, yield_ratio=POLARITY_RATIO)]


def _both_ways(motion: GroundMotion, strength: float) -> tuple[float, float]:
    """Displacement (m) of a block with a yield acceleration (m/s2) under a motion as it is and reversed."""
    as_it_is, turned = (sliding_block(motion.time, sign * motion.acceleration, strength).permanent for sign in (1.0, -1.0))
    return as_it_is, turned


def other_direction(scenes: Mapping[str, Scene], strength: float) -> dict[str, Finding]:
    """A warning for each scene, by name, whose record would drive a block with a yield acceleration (m/s2) further if it were reversed,
    unless one of the scenes has it so."""
    records = {name: processed(scene.motion) for name, scene in scenes.items() if isinstance(scene.motion, Record)}
    motions = {name: GroundMotion(made.time, made.horizontal) for name, made in records.items()}
    there = {(motion.acceleration + 0.0).tobytes() for motion in motions.values()}  # without a negative 0
    found: dict[str, Finding] = {}
    for name, motion in motions.items():
        if strength <= 0.0 or motion.peak <= strength or (0.0 - motion.acceleration).tobytes() in there:
            continue
        as_it_is, turned = _both_ways(motion, strength)
        if turned > max(POLARITY * as_it_is, MIN_SLIP):
            told = {"as_recorded": as_it_is, "reversed": turned, "strength": strength}
            found[name] = finding("record-polarity", "motion.factor", subject="", value=as_it_is, bound=turned, **told)
    return found
