"""Findings of a ground motion: its peak, drift, offset and direction, and whether the run lasts as long."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
import scipy  # type: ignore[import-untyped]

from sph.checks.finding import Finding, finding, off_by
from sph.scene.geometry import SLOPES, Bodies
from sph.scene.gravity import GRAVITY
from sph.scene.ground_motion import GroundMotion
from sph.scene.ground_motion.record import Record, processed
from sph.scene.loading import loading_of, motion_of
from sph.scene.motion import ConstantAcceleration, NoMotion
from sph.scene.natural_periods import column_at, first_peak, impedance_below, natural_frequency
from sph.scene.schema import Scene
from sph.scene.units import in_both
from sph.stability.newmark import sliding_block

WEAKEST, STRONGEST = 0.01, 2.0
"""Peak accelerations of the ground that are plausible, g: below a hundredth of g no slope that stands is moved, and of all records a
handful exceed 2 g (2.7 g horizontally at MYG004, Tohoku 2011; 3.9 g vertically at IWTH25, Iwate-Miyagi 2008).  Beyond them units are
mistaken more often than not."""
LARGEST_DRIFT = 0.1
"""Velocity of the ground at the end of a record over its largest."""
LARGEST_OFFSET = 0.01
"""Mean acceleration of a record that drifts over its peak: beyond it the drift is an offset of the recorder."""
LARGEST_DISPLACEMENT = 2.0
"""Peak displacement of the ground that is plausible, m: more than that is found beside faults that broke the surface."""
LONGEST_INTERVAL = 0.1
"""Interval of the samples of a record that is plausible, s: recorders have taken 50 and more in a second since the first digital ones."""
LASTING, SHORTEST_LASTING = 0.5, 0.1
"""Displacement of the ground at the end of a record over its largest, and in m, from which on it is told."""
POLARITY_RATIO, POLARITY = 0.5, 1.2
"""Yield over peak acceleration of a sliding block, and its displacement under the record turned round over that under the record as it
is, from which on the direction of a record matters."""

LOWEST, HIGHEST = 0.25, 20.0
"""Frequencies between which a motion has its mean period, Hz."""
MOST_RIGID = 0.1
"""Natural period of the slope over the mean period of the motion up to which a sliding block may be rigid; from there to 1 it slips too
little, beyond that more or less than the slope moves (Jibson 2011)."""
OTHER_DAMPING = 2.0
"""Damping ratio of the first mode over the one that is given, from which on the frequencies of the damping are another column's."""
NO_PEAK = "none: below the base lies soil like the lowest, or softer, so only the depth of the model sets the column frequency"


def cut_off(scene: Scene) -> list[Finding]:
    """A warning if the run ends before the motion does."""
    if isinstance(scene.motion, NoMotion) or scene.motion.end <= scene.duration:
        return []
    end = f"{scene.motion.end:.4g} s"
    return [
        finding(
            "motion-cut-off",
            "the run ends before the motion does",
            f"{scene.duration:g} s",
            f"more than {end}",
            f"duration, above {end}",
            off_by=off_by(scene.duration, scene.motion.end),
        )
    ]


def of_motion(scene: Scene) -> list[Finding]:
    """All findings of the shaking of a scene."""
    loading = loading_of(scene)
    components = {"horizontal": loading.ground, "vertical": loading.vertical}
    return cut_off(scene) + sampled(scene) + of_record(scene) + implausible(components, "motion.amplitude, or the unit of the record")


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
    found = {name: natural_frequency(scene, place) for name, place in places.items()}
    told = [f"{frequency:.3g} Hz below the {name}" for name, frequency in found.items() if math.isfinite(frequency)]
    rows = [("column frequency", f"{', '.join(told)}: first mode of the layers down to the base of the model, held there")]
    column = column_at(scene, geometry.crest)
    below = impedance_below(scene, column)
    if math.isfinite(below):
        peak = first_peak(column, below)
        words = f"{peak.frequency:.3g} Hz, {peak.amplification:.3g} times, undamped" if peak else NO_PEAK
        rows.append(("resonance over the half-space", words))
    if scene.damping is not None and scene.damping.ratio > 0.0:
        frequency = found["crest edge"]
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
    what = f"the first mode of the ground, {frequency:.3g} Hz below the crest edge, is damped more than the ratio that is given"
    low, high = (float(f"{each:.3g}") for each in (frequency, max(frequency * 5.0, scene.damping.frequencies[1])))
    measured, wanted = f"{100 * ratio:.3g} % instead of {100 * given:.3g} %", f"at most {100 * OTHER_DAMPING * given:.3g} %"
    key = f"damping.frequencies to [{low:g}, {high:g}]"
    return [finding("damping-off-frequency", what, measured, wanted, key, off_by=off_by(ratio, given))]


def not_rigid(scene: Scene) -> list[Finding]:
    """A note if the ground below the crest is too soft for a rigid block to move like the slope."""
    if not isinstance(scene.geometry, SLOPES) or isinstance(scene.motion, (NoMotion, ConstantAcceleration)):
        return []
    mean, period = mean_period(motion_of(scene)), 1.0 / natural_frequency(scene, scene.geometry.crest)
    if not mean or period <= MOST_RIGID * mean:
        return []
    tells = "underestimates" if period <= mean else "does not represent"
    what = f"the slope is not rigid under this motion, so a rigid sliding block {tells} its displacement"
    measured = f"a natural period of {period:.2g} s, {period / mean:.2g} times the mean period of the motion"
    return [finding("block-not-rigid", what, measured, f"at most {MOST_RIGID:g} for a rigid block (Jibson 2011)")]


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


def implausible(components: Mapping[str, np.ndarray], key: str) -> list[Finding]:
    """A warning for each peak of accelerations (n,) in m/s2, by direction, the horizontal first, that is not plausible; 0 is."""
    wanted = f"{WEAKEST:g} to {STRONGEST:g} g"
    peaks = {name: float(np.abs(values).max()) for name, values in components.items()}
    return [
        finding(
            "pga-implausible",
            f"the {name} peak acceleration of the ground is implausible",
            in_both(peak),
            wanted,
            key,
            subject=name,
            off_by=off_by(peak, (STRONGEST if peak > STRONGEST * GRAVITY else WEAKEST) * GRAVITY),
        )
        for name, peak in peaks.items()
        if peak > STRONGEST * GRAVITY or name == "horizontal" and 0.0 < peak < WEAKEST * GRAVITY
    ]


def sampled(scene: Scene) -> list[Finding]:
    """A warning if the samples of a scene's record, as read, lie far apart."""
    data = scene.motion.data if isinstance(scene.motion, Record) else None
    return [] if data is None else sparse(data.interval, "motion.file, or its time column")


def sparse(interval: float, key: str) -> list[Finding]:
    """A warning if the samples of a record are further apart (s) than those of recorders."""
    if interval <= LONGEST_INTERVAL:
        return []
    what = "the samples of the record are so far apart that its times may be in another unit"
    return [finding("record-sparse", what, f"a sample every {interval:g} s", f"at most {LONGEST_INTERVAL:g} s", key)]


def drifting(motion: GroundMotion, key: str) -> list[Finding]:
    """Findings of a record whose ground does not come to rest, moves too far or ends elsewhere; ``key`` removes the drift.

    An offset of the recorder moves a sliding block like shaking, whatever drift it leaves.
    """
    time, acceleration = motion
    velocity = scipy.integrate.cumulative_trapezoid(acceleration, time, initial=0.0)
    displacement = scipy.integrate.cumulative_trapezoid(velocity, time, initial=0.0)
    largest, last = float(np.abs(velocity).max()), abs(float(velocity[-1]))
    furthest, lasting = float(np.abs(displacement).max()), abs(float(displacement[-1]))
    found = []
    if last > LARGEST_DRIFT * largest:
        offset, bound = last / float(time[-1] - time[0]), LARGEST_OFFSET * motion.peak
        at_end, wanted = f"{last:.2g} m/s at its end", f"at most {LARGEST_DRIFT * largest:.2g} m/s"
        off = off_by(last, LARGEST_DRIFT * largest)
        if offset > bound:
            measured = f"a mean of {in_both(offset)}, {at_end}"
            what = "the record drifts because of an offset of the recorder"
            found.append(finding("record-offset", what, measured, wanted, key, off_by=off))
        else:
            found.append(finding("record-drift", "the record drifts", at_end, wanted, key, off_by=off))
    if furthest > LARGEST_DISPLACEMENT:
        wanted = f"at most {LARGEST_DISPLACEMENT:g} m, except beside a fault that broke the surface"
        off, what = off_by(furthest, LARGEST_DISPLACEMENT), "the peak displacement of the ground is implausible"
        found.append(finding("record-displacement", what, f"{furthest:.3g} m", wanted, key, off_by=off))
    elif lasting > max(LASTING * furthest, SHORTEST_LASTING):
        measured = f"{lasting:.2g} m, with a peak displacement of {furthest:.2g} m"
        found.append(finding("record-lasting", "the ground is left displaced at the end of the record", measured, "near 0", key))
    return found


def one_sided(motion: GroundMotion, key: str) -> list[Finding]:
    """A note if the reversed record drives a sliding block further."""
    strength = POLARITY_RATIO * motion.peak
    if not strength > 0:
        return []
    as_it_is, turned = (sliding_block(motion.time, sign * motion.acceleration, strength).permanent for sign in (1.0, -1.0))
    if turned <= POLARITY * as_it_is:
        return []
    measured = f"{turned:.2g} m instead of {as_it_is:.2g} m for a block with a yield acceleration of {POLARITY_RATIO:g} PGA"
    return [finding("record-polarity", "the reversed record drives a sliding block further", measured, "computed in both directions", key)]
