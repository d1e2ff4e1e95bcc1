"""The two loops over neighbours against C++: ``python tests/benchmarks/loops.py [--spacing M] [--json FILE]``.

The same loops (``loops.cpp``) are compiled with ``-O3 -march=native -ffast-math`` and called on the same arrays, at the literal
smoothing length (66 neighbours inside the slope) and at 1.3 spacings (some 20), with gradients in single precision ("mixed",
the default) and in double.  Results must agree to rounding.  Reported is the speed of numba over that of C++.  Each call
repeats a loop many times, so that the 10 us that Python needs for a call do not show; calls alternate.
"""

from __future__ import annotations

import ctypes
import os
import shutil
import subprocess
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from measuring import AT_REST, REPEATS, command_line, hand_out, medians, paper

from sph.solver.compiled.jit import jit
from sph.solver.physics.momentum import stress_accelerations, velocity_gradients
from sph.solver.simulation import Simulation
from sph.solver.terms import only

SOURCE = Path(__file__).with_suffix(".cpp")
FLAGS = ["-O3", "-march=native", "-ffast-math", "-shared", "-fPIC"]
LOOPS = ("velocity_gradients", "stress_accelerations")
RATIOS = (2.3, 1.3)
PRECISIONS = ("mixed", "double")
ROUNDING = 1e-13
"""Sums of some 60 terms in another order, relative to the largest result."""


def compiler() -> str | None:
    """A C++ compiler: $CXX, g++ or c++."""
    return next((found for name in (os.environ.get("CXX"), "g++", "c++") if name and (found := shutil.which(name))), None)


def compiled(folder: str) -> ctypes.CDLL:
    """The C++ loops as a library built in ``folder``."""
    found = compiler()
    if found is None:
        raise SystemExit("loops.py compares with C++ and finds no compiler (g++, c++ or $CXX)")
    library = Path(folder) / "loops.so"
    subprocess.run([found, *FLAGS, str(SOURCE), "-o", str(library)], check=True)
    return ctypes.CDLL(str(library))


def as_c(argument: np.ndarray | float | int) -> Any:
    """An argument of the C++ functions: arrays as pointers, whole numbers as int64_t."""
    if isinstance(argument, np.ndarray):
        return ctypes.c_void_p(argument.ctypes.data)
    return ctypes.c_double(argument) if isinstance(argument, float) else ctypes.c_int64(argument)


@jit
def repeat_velocity_gradients(times, state, pairs, terms, gradient, n):  # type: ignore[no-untyped-def]
    for _ in range(times):
        velocity_gradients(state, pairs, terms, gradient, 0, n)


@jit
def repeat_stress_accelerations(times, state, pairs, terms, strain_rate, n):  # type: ignore[no-untyped-def]
    for _ in range(times):
        stress_accelerations(state, pairs, terms, strain_rate, 0, n)


def stirred(ratio: float, precision: str, spacing: float) -> Simulation:
    """The paper's slope with velocities and stresses at random."""
    settings = {"numerics.smoothing_ratio": ratio, "numerics.precision": precision, "numerics.spacing": spacing}
    run = Simulation(paper(AT_REST | settings))
    run.prepare()
    generator = np.random.default_rng(1)
    for name in ("vx", "vy", "sxx", "syy", "sxy"):
        getattr(run.state, name)[:] = generator.normal(size=run.state.x.size)
    return run


def compare(library: ctypes.CDLL, ratio: float, precision: str, spacing: float, times: int, repeats: int) -> dict[str, Any]:
    """Nanoseconds an interaction of both loops in numba and C++, and the largest difference of their results."""
    run = stirred(ratio, precision, spacing)
    state, pairs, terms = run.state, run.pairs, run.terms
    n = state.x.size
    plain = only(terms, "artificial_viscosity", "gradient_correction")
    gradient = run.team[0].gradient

    def in_cpp(name: str, *arguments: Any) -> Any:
        converted = [as_c(argument) for argument in arguments]
        function = getattr(library, f"{name}_{precision}")
        return lambda: function(*converted)

    rows = (times, n, pairs.start, pairs.end, pairs.neighbour, pairs.gx, pairs.gy)
    cpp_gradient, viscous_x, viscous_y, ax, ay = np.empty((4, n)), np.empty(n), np.empty(n), np.empty(n), np.empty(n)
    calls = {
        "numba velocity_gradients": lambda: repeat_velocity_gradients(times, state, pairs, plain, gradient, n),
        "C++ velocity_gradients": in_cpp(
            LOOPS[0], *rows, pairs.inverse_norm, state.vx, state.vy, terms.artificial_viscosity.speed, cpp_gradient, viscous_x, viscous_y
        ),
        "numba stress_accelerations": lambda: repeat_stress_accelerations(times, state, pairs, plain, run.team[0].strain_rate, n),
        "C++ stress_accelerations": in_cpp(
            LOOPS[1], *rows, pairs.sum_x, pairs.sum_y, state.sxx, state.syy, state.sxy, viscous_x, viscous_y, ax, ay
        ),
    }
    found = medians(calls, repeats)
    interactions = times * int((pairs.end - pairs.start).sum())
    results = ((gradient, cpp_gradient), (state.viscous_x, viscous_x), (state.viscous_y, viscous_y), (state.ax, ax), (state.ay, ay))
    difference = max(float(np.abs(a - b).max() / np.abs(b).max()) for a, b in results)
    if not difference < ROUNDING:
        raise RuntimeError(f"numba and C++ differ by {difference:.1e} at ratio {ratio}, {precision}")
    return {
        "smoothing_ratio": ratio,
        "precision": precision,
        "particles": n,
        "neighbours_mean": interactions / times / n,
        "difference": difference,
        "ns_per_interaction": {name: 1e9 * seconds / interactions for name, seconds in found.items()},
        "numba_over_cpp_speed": {name: found[f"C++ {name}"] / found[f"numba {name}"] for name in LOOPS},
        "shortest_call_us": 1e6 * min(found.values()),
    }


def table(cases: list[dict[str, Any]]) -> str:
    """The numbers as text."""
    lines = [f"{'ns an interaction':42s}{'numba':>8s}{'C++':>8s}{'speed of numba over C++':>26s}"]
    for case in cases:
        ns = case["ns_per_interaction"]
        for name in LOOPS:
            label = f"{name}, {case['precision']}, {case['neighbours_mean']:.0f} neighbours"
            speed = case["numba_over_cpp_speed"][name]
            lines.append(f"{label:42s}{ns[f'numba {name}']:8.3f}{ns[f'C++ {name}']:8.3f}{speed:26.2f}")
    lines.append(f"results differ by {max(case['difference'] for case in cases):.0e} at most; the shortest call took "
                 f"{min(case['shortest_call_us'] for case in cases):.0f} us, of which Python takes 10")  # fmt: skip
    return "\n".join(lines)


def main(arguments: list[str] | None = None) -> None:
    """Parse the command line, measure, print a table and write JSON."""
    parser = command_line(__doc__)
    parser.add_argument("--spacing", type=float, default=1.0, help="of the particles, m")
    parser.add_argument("--times", type=int, default=50, help="loops in a call")
    parser.add_argument("--repeats", type=int, default=2 * REPEATS, help="calls of which the median is taken")
    options = parser.parse_args(arguments)
    with tempfile.TemporaryDirectory() as folder:
        library = compiled(folder)
        cases = [
            compare(library, ratio, precision, options.spacing, options.times, options.repeats)
            for ratio in RATIOS
            for precision in PRECISIONS
        ]
    found = {"compiler": compiler(), "flags": FLAGS, "cases": cases}
    found["lowest_speed_over_cpp"] = min(min(case["numba_over_cpp_speed"].values()) for case in cases)
    hand_out(found, table(cases), options.json)


if __name__ == "__main__":
    main()
