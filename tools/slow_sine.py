"""The amplitude at which the slope of V24 goes, against the period of the sine: where shaking departs from a static load.

``python -m tools.slow_sine`` writes ``slow_sine.csv`` of the package, a row a period, from some fifteen runs of V24's scene.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pandas as pd

from cases.slow_sine import COLLAPSE, LIMIT, collapsed
from sph.scene.configuration import merge, read_scene
from sph.scene.gravity import GRAVITY
from sph.scene.motion import TaperedSine
from sph.scene.natural_periods import natural_frequency
from sph.scene.schema import Scene, make_scene
from sph.solver.compiled.jit import solver_digest
from sph.solver.run import run
from sph.stability.newmark import sliding_block
from sph.stability.search import Trial, search
from sph.stability.standing import displacements, slope_height
from sph.storage.trajectory import Variable
from sph.study.tables import number_column, read_csv, write_csv
from tools.shipped import MEASURED, SHIPPED, note

SCENE = "config/scenes/validation/v24_slow_sine.yaml"
PERIODS = (8.0, 4.0, 2.0)
"""Periods of the sine over the natural period of the ground below the crest."""
CYCLES = (2.0, 4.0, 5.0)
"""Cycles until full strength, until it decreases, and to the end, at every period."""
AFTER = 3.5
"""Time after the shaking, s."""
WALK = (0.1, 0.2, 0.3, 0.36, 0.44, 0.52, 0.6, 0.8, 1.0, 1.4, 2.0, 3.0)
"""Amplitudes over g that a search walks along."""
WIDTH = 0.05
"""Width of the brackets over their middle."""
SLOW_SINE: tuple[Variable, ...] = (
    number_column("period_ratio", "1", "period of the sine over the natural period 4 D / V_s of the ground below the crest"),
    number_column("period", "s", "period of the sine"),
    number_column("S_R", "1", "share of its strength that the soil keeps"),
    number_column("slip_at_peak", "m", "slip at which strength begins to fall"),
    number_column("slip_at_residual", "m", "slip at which the residual strength is reached"),
    number_column("lower", "1", "largest amplitude over g at which the slope stands"),
    number_column("upper", "1", "smallest amplitude over g at which it collapses"),
    number_column("block_peak", "1", "amplitude over g at which a rigid block of a yield acceleration k_c g slips by slip_at_peak"),
    number_column("block_residual", "1", "amplitude over g at which it slips by slip_at_residual"),
    number_column("amplification", "1", "mean acceleration over the depth of a damped column on a rigid base, over that of the base"),
    number_column("displacement", "m", "largest displacement of the soil at the amplitude lower"),
)
"""Columns of the table."""


def shaken(scene: dict[str, Any], ratio: float, k: float) -> Scene:
    """The scene under a sine of a period over the natural one, of an amplitude k g, with ``CYCLES``."""
    built = make_scene(scene)
    period, start = ratio / natural_frequency(built, built.geometry.crest), built.gravity.duration
    rise, fall, end = (start + cycles * period for cycles in CYCLES)
    motion = {"kind": "tapered_sine", "amplitude": k * GRAVITY, "frequency": 1.0 / period, "start": start}
    motion |= {"ramp": rise - start, "decay_start": fall, "end": end}
    return make_scene(merge(scene, {"motion": motion, "duration": math.ceil(end + AFTER)}))


def block_limit(scene: Scene, slip: float) -> float:
    """Amplitude over g of the scene's sine at which a rigid block of a yield acceleration k_c g slips by ``slip`` (m)."""
    assert isinstance(scene.motion, TaperedSine)
    time = np.linspace(scene.motion.start, scene.motion.end, 20_001)
    unit = scene.motion.acceleration(time) / scene.motion.amplitude
    low, high = LIMIT, 1e3 * LIMIT
    while high - low > 1e-4 * low:
        middle = math.sqrt(low * high)
        slips = sliding_block(time, middle * GRAVITY * unit, LIMIT * GRAVITY).permanent > slip
        low, high = (low, middle) if slips else (middle, high)
    return low


def mean_amplification(ratio: float, damping: float) -> float:
    """Mean acceleration over the depth of a column with a damping ratio on a rigid base, over that of the base: abs(tan(kD) / kD).

    For vertical shear waves (Kramer 1996) with kD = (pi / 2) / ratio / sqrt(1 + 2 i damping), ``ratio`` the period over the natural one.
    """
    depth = 0.5 * math.pi / ratio / np.sqrt(1.0 + 2.0j * damping)
    return float(abs(np.tan(depth) / depth))


def damping_at(scene: Scene, frequency: float) -> float:
    """Rayleigh damping ratio at a frequency (Hz)."""
    assert scene.damping is not None
    return scene.damping.at(frequency)


def measured(scene: dict[str, Any], ratio: float) -> dict[str, float]:
    """The row of a period over the natural one."""

    def test(k: float) -> Trial:
        made = shaken(scene, ratio, k)
        done = run(made).trajectory
        moved = displacements(done, made.gravity.duration)
        area = np.count_nonzero(moved > COLLAPSE * slope_height(made)) * made.numerics.spacing**2
        trial = Trial(k, not collapsed(made, done), area, float(moved.max()), done.attrs["status"], float(done.attrs["wall_time_s"]))
        print(f"{ratio:g} T: {trial}", flush=True)
        return trial

    bracket = search(test, WALK, WALK.index(0.44), WIDTH)
    stood = [trial.largest_displacement for trial in bracket.trials if trial.value == bracket.stood]
    return row(shaken(scene, ratio, LIMIT), ratio, bracket.stood, bracket.failed, stood[0] if stood else math.nan)


def row(scene: Scene, ratio: float, stood: float, failed: float, displacement: float) -> dict[str, float]:
    """The row of a scene with its sine, from the ends of its bracket (over g) and the displacement (m) at the one that stood."""
    softening, motion = scene.coupling.softening, scene.motion
    assert softening is not None and softening.slip_at_residual is not None and isinstance(motion, TaperedSine)
    return {
        "period_ratio": ratio,
        "period": 1.0 / motion.frequency,
        "S_R": scene.coupling.S_R,
        "slip_at_peak": softening.slip_at_peak,
        "slip_at_residual": softening.slip_at_residual,
        "lower": stood,
        "upper": failed,
        "block_peak": block_limit(scene, softening.slip_at_peak),
        "block_residual": block_limit(scene, softening.slip_at_residual),
        "amplification": mean_amplification(ratio, damping_at(scene, motion.frequency)),
        "displacement": displacement,
    }


def read_slow_sine() -> pd.DataFrame:
    """The table of this release; ValueError where the file is none."""
    return read_csv(MEASURED / "slow_sine.csv", SLOW_SINE, "critical amplitudes of slow sines")


if __name__ == "__main__":
    scene = dict(read_scene(SCENE))
    table = pd.DataFrame([measured(scene, ratio) for ratio in PERIODS])
    write_csv(table[[row.name for row in SLOW_SINE]], SHIPPED["slow_sine"].path)
    note("slow_sine", solver_digest())
    print(table.to_string())
