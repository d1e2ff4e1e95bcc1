"""Hand-made trajectories and studies with known answers."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from sph.output.run import Run
from sph.scene.motion import vertical_acceleration
from sph.scene.schema import Scene, make_scene
from sph.solver.particles import SOIL, locate_probes, place_particles
from sph.storage import trajectory
from sph.study.tables import AXES, VALUES, Layout, joined_dataset, study_rows

PAPER = {
    "scheme": "paper",
    "name": "paper",
    "duration": 15.0,
    "geometry": {"shape": "slope"},
    "motion": {"kind": "tapered_sine"},
    "outputs": {"frame_interval": 0.5, "series_interval": 0.05},
}
"""The paper's slope by its defaults, with few outputs."""

Displacement = Callable[[Scene, np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]]


def translation(ux: float, uy: float = 0.0) -> Displacement:
    """Final displacement that moves the slope material (above the toe) as a rigid block and leaves the rest."""

    def field(scene: Scene, x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        moved = y > scene.geometry.toe[1]
        return np.where(moved, ux, 0.0), np.where(moved, uy, 0.0)

    return field


def step_ramp(start: float, end: float) -> Callable[[np.ndarray], np.ndarray]:
    """Share of the final displacement reached at a time: linear from ``start`` to ``end`` (s)."""
    return lambda time: np.clip((time - start) / (end - start), 0.0, 1.0)


def synthetic(
    displacement: Displacement | None = None,
    share: Callable[[np.ndarray], np.ndarray] = step_ramp(4.0, 8.0),  # noqa: B008
    overrides: Mapping[str, Any] | None = None,
    status: str = "complete",
    **arrays: np.ndarray,
) -> Run:
    """Run in which every soil particle moves along its final displacement as ``share(time)`` says; ``arrays`` replace variables."""
    scene = make_scene({**PAPER, **(overrides or {})})
    particles = place_particles(scene)
    soil = particles.kind == SOIL
    ux, uy = (displacement or translation(0.0))(scene, particles.x, particles.y)
    frames = np.arange(round(scene.duration / scene.outputs.frame_interval) + 1) * scene.outputs.frame_interval
    samples = np.arange(round(scene.duration / scene.outputs.series_interval) + 1) * scene.outputs.series_interval
    at = np.array(list(locate_probes(scene, particles).values()))
    final = {"x": np.where(soil, ux, 0.0), "y": np.where(soil, uy, 0.0)}
    rate = np.gradient(share(samples), samples)
    frame_rate = np.gradient(share(frames), frames)
    mass = particles.mass
    values: dict[str, Any] = {
        "time": frames,
        "sample_time": samples,
        "time_step": np.full(frames.size, scene.numerics.time_step),
        "time_step_limit": np.full(frames.size, 2.0 * scene.numerics.time_step),
        "x0": particles.x,
        "y0": particles.y,
        "kind": particles.kind,
        "mass": mass,
        "layer": particles.layer,
        "t_f": np.full(mass.size, np.nan),
        "probe_particle": at,
        "density": np.full((frames.size, mass.size), scene.soil.density),
        "beta": np.ones((frames.size, mass.size)),
        "failed": np.zeros((frames.size, mass.size)),
        "ground_acceleration": scene.motion.acceleration(samples),
        "ground_acceleration_y": vertical_acceleration(scene.motion, samples),
        "kinetic_energy": 0.5 * float(mass[soil] @ (final["x"] ** 2 + final["y"] ** 2)[soil]) * rate**2,
        "failed_fraction": np.zeros(samples.size),
        "maximum_speed": np.hypot(final["x"], final["y"])[soil].max() * np.abs(rate),
    }
    for axis, u in final.items():
        values[f"displacement_{axis}"] = np.outer(share(frames), u)
        values[axis] = values[f"{axis}0"] + values[f"displacement_{axis}"]
        values[f"velocity_{axis}"] = np.outer(frame_rate, u)
        values[f"probe_displacement_{axis}"] = np.outer(share(samples), u[at])
        values[f"probe_velocity_{axis}"] = np.outer(rate, u[at])
    for variable in trajectory.VARIABLES:
        shape = [{"frame": frames.size, "particle": mass.size, "sample": samples.size, "probe": at.size}[dim] for dim in variable.dims]
        values.setdefault(variable.name, np.zeros(shape))
    cost = {"wall_time_s": 2.0, "particle_steps_per_second": 3e6}
    attrs = trajectory.run_attributes(scene) | {"status": status, "status_reason": "", **cost}
    return Run(trajectory.assembled(values | arrays, list(scene.probes), attrs))


def study_row(S_R: str, gamma: str, amplitude: str, **metrics: Any) -> dict[str, Any]:
    """Row of a study: a finished run of the paper's motion with the given metrics, all others NaN."""
    fixed = {
        "status": "complete",
        "collapse_class": "stable",
        "still_moving": 0,
        "at_rest": 1,
        "diverged": 0,
        "reached_side": "",
        "findings": "",
    }
    values = {metric.name: fixed.get(metric.name, np.nan) for metric in VALUES}
    values |= {"shaking_start": 3.0, "shaking_end": 10.0}
    return {"S_R": S_R, "gamma": gamma, "amplitude": amplitude, **values, **metrics}


def study_of(rows: Sequence[Mapping[str, Any]]) -> xr.Dataset:
    """The smallest grid over the paper's dimensions that holds the rows."""
    labels = tuple(tuple(sorted({str(row[axis.name]) for row in rows}, key=float)) for axis in AXES)
    return joined_dataset([study_rows(rows)], Layout(labels=labels))
