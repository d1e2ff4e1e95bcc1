"""The same shaking in other words, and the sliding block under it."""

from __future__ import annotations

import numpy as np
from answers import (
    LOADS,
    Case,
    common,
    same_to_rounding,
    same_values,
)
from relation import relation, shaken
from scenes import GRAVITY_STAGE, TIME_STEP, Data

from sph.scene.gravity import GRAVITY
from sph.scene.loading import make_loading, motion_of
from sph.scene.schema import make_scene
from sph.solver.run import Result
from sph.stability.newmark import sliding_block


def _record_changed(case: Case, changes: Data) -> Result:
    """The run of a scene with another record, whose loads must be the same to rounding."""
    other = case.changed(changes)
    for name in ("ground", "vertical"):
        left, right = (getattr(make_loading(scene), name) for scene in (case.scene, make_scene(other)))
        assert np.abs(left - right).max() <= LOADS * max(np.abs(left).max(), 1.0), f"{name}: loads differ by {np.abs(left - right).max():g}"
    return case.run(other)


@relation(shaken("record"))
def record_resampled_finer(case: Case, chance: np.random.Generator) -> None:
    """A record with samples put between its own, on the straight line: the same to rounding."""
    data = case.data["motion"]["data"]
    times = [m for m in (2, 4, 5) if data["interval"] / m > TIME_STEP * (1 - 1e-6)]
    m, n = int(chance.choice(times)), len(data["x"])
    at = np.arange((n - 1) * m + 1) / m
    finer = {name: np.interp(at, np.arange(n), data[name]).tolist() for name in ("x", "y") if name in data}
    result = _record_changed(case, {"motion.data": {"interval": data["interval"] / m, **finer}})
    same_to_rounding(case.result, result, case.scene)


@relation(shaken("record"))
def record_with_rest_after_it(case: Case, chance: np.random.Generator) -> None:
    """A record that goes on standing still: the same values (a zero may have another sign) at the frames and samples that both have."""
    data = case.data["motion"]["data"]
    zeros = [0.0] * int(chance.integers(1, 60))
    longer = {name: data[name] + zeros for name in ("x", "y") if name in data}
    result = _record_changed(case, {"motion.data": {"interval": data["interval"], **longer}})
    same_values(*common(case.result.trajectory, result.trajectory))
    same_values(case.result.restart, result.restart)


@relation(lambda case: shaken("record")(case) and case.scene.motion.start > GRAVITY_STAGE)
def record_with_rest_before_it(case: Case, chance: np.random.Generator) -> None:
    """A record that stands still at first and begins earlier by as much: the same to rounding."""
    motion = case.data["motion"]
    interval = motion["data"]["interval"]
    zeros = int(chance.integers(1, int((motion["start"] - GRAVITY_STAGE) / interval + 1e-9) + 1))
    earlier = {name: [0.0] * zeros + motion["data"][name] for name in ("x", "y") if name in motion["data"]}
    changes = {"motion.data": {"interval": interval, **earlier}, "motion.start": motion["start"] - zeros * interval}
    same_to_rounding(case.result, _record_changed(case, changes), case.scene)


@relation(shaken("tapered_sine", "velocity_pulse"))
def formula_as_a_record(case: Case, chance: np.random.Generator) -> None:
    """A motion by formula sampled at the time steps is the same record, with or without a vertical component of nothing: to rounding."""
    motion = case.scene.motion
    time = motion.start + TIME_STEP * np.arange(round((motion.end - motion.start) / TIME_STEP) + 1)
    data: Data = {"interval": TIME_STEP, "x": motion.acceleration(time).tolist()}
    record: Data = {"kind": "record", "start": motion.start, "data": data}
    if chance.random() < 0.5:
        record |= {"data": data | {"y": [0.0] * time.size}, "vertical": {}}
    result = _record_changed(case, {"motion": record})
    same_to_rounding(case.result, result, case.scene)


@relation()
def no_shaking(case: Case, chance: np.random.Generator) -> None:
    """No motion, a sine, a pulse and a wavelet of amplitude 0, a record of zeros: the same values, where both have frames."""
    none = case.run({**case.data, "motion": {"kind": "none"}})
    still: Data = chance.choice(
        [
            {"kind": "tapered_sine", "amplitude": 0.0, "start": 1.0, "ramp": 0.25, "decay_start": 1.5, "end": 2.0},
            {"kind": "velocity_pulse", "amplitude": 0.0, "frequency": 2.0, "start": 1.0},
            {"kind": "ricker", "amplitude": 0.0, "frequency": 4.0, "peak": 2.0},
            {"kind": "constant", "amplitude": 0.0, "start": 1.0, "ramp": 0.5},
            {"kind": "record", "start": 1.0, "vertical": {}, "data": {"interval": 0.02, "x": [0.0] * 9, "y": [0.0] * 9}},
        ]
    )
    result = case.run({**case.data, "motion": still})
    same_values(*common(none.trajectory, result.trajectory))
    assert none.status == result.status


@relation(shaken("record"))
def record_in_units(case: Case, chance: np.random.Generator) -> None:
    """A record's file in g, gal, cm/s2 or m/s2, by its header or by ``unit``, as CSV or PEER, with time in s or ms: the same samples.

    A unit, wherever a header names it, is understood or refused.
    """
    g_values = [round(value / GRAVITY, 5) for value in case.data["motion"]["data"]["x"]]
    interval = case.data["motion"]["data"]["interval"]
    sizes = {"g": GRAVITY, "gal": 0.01, "cm/s2": 0.01, "m/s2": 1.0}
    columns = {unit: [value * GRAVITY / size for value in g_values] for unit, size in sizes.items()}
    headers = {
        "t, a": "unit",
        "time (s), ax ({})": "",
        "time [s],acc [{}]": "",
        "time,acc_{}": "",
        "time,ACC ({}) NS": "",
        "time, acc {}": "",
    }
    files: list[tuple[str, str, Data]] = []
    for unit, values in columns.items():
        for header, by_key in headers.items():
            rows = "\n".join(f"{interval * k!r},{value!r}" for k, value in enumerate(values))
            files.append((f"{header.format(unit)}\n{rows}", ".csv", {"unit": unit} if by_key else {}))
    milliseconds = "\n".join(f"{1e3 * interval * k!r},{value!r}" for k, value in enumerate(columns["m/s2"]))
    files += [(f"{header}\n{milliseconds}", ".csv", {}) for header in ("time (ms), a (m/s2)", "time_ms,a", "t [msec],a")]
    peer = "\n".join(" ".join(f"{value:.5E}" for value in g_values[k : k + 5]) for k in range(0, len(g_values), 5))
    files.append(
        (f"PEER\nsomewhere\nACCELERATION TIME SERIES IN UNITS OF G\nNPTS= {len(g_values)}, DT= {interval} SEC\n{peer}\n", ".AT2", {})
    )
    wanted = None
    for number, (text, ending, keys) in enumerate(files):
        path = case.folder / f"record{number}{ending}"
        path.write_text(text)
        case.others[:] = [text[:200]]
        first = text.splitlines()[0]
        try:
            scene = make_scene({**case.data, "motion": {"kind": "record", "file": str(path), "start": 1.0, **keys}})
        except ValueError as error:
            assert any(unit in first for unit in ("_", ") NS", "acc ", "ms")) and "line 1" in str(error), f"{first!r}: {error}"
            continue
        wanted = wanted or scene.motion.data
        assert scene.motion.data.x == wanted.x and np.isclose(scene.motion.data.interval, wanted.interval, rtol=1e-8), (
            f"{first!r} {keys}: read as {max(map(abs, scene.motion.data.x)):g} m/s2 every {scene.motion.data.interval:g} s"
        )


@relation(shaken())
def sliding_block_follows(case: Case, chance: np.random.Generator) -> None:
    """Newmark's block on the scene's motion: twice the motion and yield acceleration give twice the displacement, turned round the same
    upslope (bits); a finer sampling changes rounding only; a lower yield acceleration never slides it less."""
    motion = motion_of(case.scene)
    time, a, yields = motion.time, motion.acceleration, sorted(chance.uniform(0.02, 0.9, 3) * max(motion.peak, 0.01))
    slides = [sliding_block(time, a, float(value)).permanent for value in yields]
    assert slides == sorted(slides, reverse=True), f"yield accelerations {yields} slide it by {slides}"
    both = sliding_block(time, a, yields[0], yields[1])
    assert sliding_block(time, 4.0 * a, 4.0 * yields[0], 4.0 * yields[1]).permanent == 4.0 * both.permanent
    assert sliding_block(time, -a, yields[1], yields[0]).permanent == -both.permanent
    finer = np.interp(np.arange(2 * time.size - 1) / 2, np.arange(time.size), time)
    again = sliding_block(finer, np.interp(finer, time, a), yields[0], yields[1]).permanent
    assert np.isclose(again, both.permanent, rtol=1e-9, atol=1e-12), (again, both.permanent)
