"""What a run records: frames of the particles' fields, and dense series."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from sph.scene.schema import Scene
from sph.solver.early_stop import quiet_from
from sph.solver.particles import locate_probes
from sph.solver.physics.cyclic_pore_pressure import pressure_ratio
from sph.solver.simulation import Simulation
from sph.solver.state import FAILED, GRAVITY, INTERNAL, MASS_DAMPING, REPULSION, SHAKING, VISCOUS, WALLS
from sph.storage import trajectory
from sph.storage.netcdf import Group


class Recording:
    """The frames and series of a run so far."""

    def __init__(self, simulation: Simulation) -> None:
        self.simulation = simulation
        self.probes = locate_probes(simulation.scene, simulation.particles)
        self.landmarks = landmarks(simulation.scene)
        self.frames: dict[str, list[np.ndarray]] = {v.name: [] for v in trajectory.VARIABLES if v.dims[0] == "frame"}
        self.frames |= {} if simulation.terms.cyclic_pore_pressure is None else {"pore_pressure_ratio": []}
        self.series: dict[str, list[Any]] = {v.name: [] for v in trajectory.VARIABLES if v.dims[0] == "sample"}

    def is_regular(self) -> bool:
        """Whether the present step is one of the interval of frames."""
        return self._at_interval(self.simulation.step)

    def has_frame(self, step: int) -> bool:
        """Whether the fields are stored at a step: at every interval, and at the ends of the gravity stage, the shaking and the run."""
        return self._at_interval(step) or step in self.landmarks

    def _at_interval(self, step: int) -> bool:
        return step % self.simulation.scene.steps(self.simulation.scene.outputs.frame_interval) == 0

    def add_sample(self) -> None:
        """Add a sample of the series."""
        simulation, state, n_soil = self.simulation, self.simulation.state, self.simulation.particles.n_soil
        soil, moving = slice(0, n_soil), slice(0, simulation.terms.n_moving)
        speed_square = state.vx[moving] ** 2 + state.vy[moving] ** 2
        work = state.work
        elastic = simulation.elastic_energy()
        at = np.array(list(self.probes.values()), dtype=int)
        sample = {
            "sample_time": simulation.time,
            "probe_displacement_x": state.x[at] - simulation.particles.x[at],
            "probe_displacement_y": state.y[at] - simulation.particles.y[at],
            "probe_velocity_x": state.vx[at],
            "probe_velocity_y": state.vy[at],
            "ground_acceleration": simulation.loading.ground[simulation.step * simulation.substeps],
            "ground_acceleration_y": simulation.loading.vertical[simulation.step * simulation.substeps],
            "kinetic_energy": 0.5 * float(simulation.particles.mass[moving] @ speed_square),
            "elastic_energy": elastic + work[REPULSION],
            "potential_energy": -work[GRAVITY],
            "dissipated_energy": work[INTERNAL] - elastic + work[MASS_DAMPING] + work[VISCOUS] + work[WALLS],
            "viscous_energy": work[VISCOUS],
            "shaking_work": work[SHAKING],
            "failed_fraction": float(np.mean(state.phase[soil] == FAILED)),
            "maximum_speed": float(np.sqrt(speed_square[soil].max())),
        }
        for name, values in self.series.items():
            values.append(sample[name])

    def add_frame(self) -> None:
        """Add a frame of the fields."""
        simulation, state = self.simulation, self.simulation.state
        stress = simulation.cauchy_stress()
        frame = {
            "time": simulation.time,
            "time_step": simulation.terms.dt,
            "time_step_limit": simulation.limit,
            "x": state.x,
            "y": state.y,
            "displacement_x": state.x - simulation.particles.x,
            "displacement_y": state.y - simulation.particles.y,
            "velocity_x": state.vx,
            "velocity_y": state.vy,
            "stress_xx": stress[:, 0],
            "stress_yy": stress[:, 1],
            "stress_zz": stress[:, 2],
            "stress_xy": stress[:, 3],
            "density": state.density * (simulation.particles.mass / simulation.terms.cell_mass),
            "beta": state.beta,
            "failed": state.phase == FAILED,
            "pore_pressure_ratio": pressure_ratio(simulation.terms.cyclic_pore_pressure, state),
        }
        for name, values in self.frames.items():
            values.append(np.array(frame[name], dtype=trajectory.BY_NAME[name].dtype))

    def moved_since(self, time: float) -> np.ndarray:
        """How far each soil particle (n,) has moved since the first frame at or after a time (s), or since the last, m."""
        simulation, soil = self.simulation, slice(0, self.simulation.particles.n_soil)
        first = min(int(np.searchsorted(self.frames["time"], time - 1e-9)), len(self.frames["time"]) - 1)
        now = ((simulation.state.x, "x"), (simulation.state.y, "y"))
        return np.asarray(np.hypot(*(place[soil] - self.frames[axis][first][soil] for place, axis in now)))

    def take_over(self, old: Group) -> None:
        """Take over the history of an earlier run of the scene; the end of a shorter run is no frame of a longer one."""
        simulation = self.simulation
        frames = [number for number, at in enumerate(old["time"].values) if self.has_frame(simulation.scene.steps(float(at)))]
        for name in self.frames:
            self.frames[name] = list(old[name].values[frames])
        for name in self.series:
            self.series[name] = list(old[name].values if name in old else np.full(old.sizes["sample"], np.nan))  # of an earlier version
        # The last sample's kick is still to come, under this scene's motion, which may not be that of the gravity stage.
        self.series["ground_acceleration"][-1] = simulation.loading.ground[simulation.step * simulation.substeps]
        self.series["ground_acceleration_y"][-1] = simulation.loading.vertical[simulation.step * simulation.substeps]

    def largest_ratio(self) -> float:
        """Largest time step over its measured limit, over the frames."""
        return float(np.max(np.array(self.frames["time_step"]) / np.array(self.frames["time_step_limit"]), initial=0.0))

    def trajectory(self, attrs: dict[str, Any]) -> Group:
        """The trajectory so far, with the attributes of the scene and these."""
        simulation, particles = self.simulation, self.simulation.particles
        arrays: dict[str, np.ndarray] = {
            "x0": particles.x,
            "y0": particles.y,
            "kind": particles.kind,
            "mass": particles.mass,
            "layer": particles.layer,
            "t_f": simulation.state.t_f,
            "probe_particle": np.array(list(self.probes.values()), dtype=int),
        }
        sizes = {"particle": particles.x.size, "probe": len(self.probes)}
        for name, values in (self.frames | self.series).items():
            variable = trajectory.BY_NAME[name]
            shape = (len(values), *(sizes[dim] for dim in variable.dims[1:]))
            arrays[name] = np.array(values, dtype=variable.dtype).reshape(shape)
        return trajectory.assembled(arrays, list(self.probes), trajectory.run_attributes(simulation.scene) | attrs)


def landmarks(scene: Scene) -> set[int]:
    """Steps with a frame whatever the interval of frames: the end of the gravity stage, the last sample of the shaking, the end."""
    sample = scene.steps(scene.outputs.series_interval)
    shaken = math.floor((quiet_from(scene) / scene.outputs.series_interval) * (1 + 1e-9)) * sample
    return {scene.steps(scene.gravity.duration), shaken, scene.steps(scene.duration)}
