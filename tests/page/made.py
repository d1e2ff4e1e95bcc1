"""A finished study of four hand-made runs, one of which diverged."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image
from synthetic import Displacement, study_row, synthetic

from sph.checks.finding import finding
from sph.experiments.paper.claims import decide_claims
from sph.measures.metrics import METRIC_BY_NAME, measure
from sph.output.run import Run
from sph.page.build import StudyFiles
from sph.page.paper import PAPER_SECTIONS
from sph.page.sections import certain, existing
from sph.scene.schema import Scene
from sph.storage import trajectory
from sph.study.dimensions import CASE, Dimension
from sph.study.preflight import Row, write_preflight
from sph.study.tables import Layout, join_study, read_study, read_table, study_rows, write_csv

FOLDER = "results/made/up"
SLIPS = {("0.10", "4.0"): -3.0, ("0.10", "6.0"): -8.0, ("0.50", "4.0"): 0.0, ("0.50", "6.0"): -1.0}
"""Horizontal motion (m) of the soil above the toe, give or take a third, by S_R and amplitude; the last run diverges."""
DIMENSIONS = [Dimension("S_R", "-", "", False), Dimension("gamma", "1/s", "", False), Dimension("amplitude", "m/s2", "", False)]
TITLE = "A slope <b>& more</b>"


def uneven(slip: float) -> Displacement:
    """Displacement that is not the same for all, so that it does not pack to nothing."""

    def field(scene: Scene, x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        ux = np.where(y > scene.geometry.toe[1], slip * (1.0 + np.sin(13.0 * x + 7.0 * y) / 3.0), 0.0)
        return ux, -0.5 * np.abs(ux)

    return field


RIGHT = {"shape": "ground_line", "points": [[180, 440], [125, 440], [110, 465], [76, 465]], "base": 430, "downhill": "right"}
"""A surveyed line of a slope that falls to the right."""


def run_of(S_R: str, amplitude: str, geometry: Mapping[str, Any] | None = None) -> Run:
    """A run of 400 particles; that of S_R 0.50 and 6.0 m/s2 is stopped after 9 s with a particle lost."""
    scene: dict[str, Any] = {
        "title": TITLE,
        "numerics": {"spacing": 2.5},
        "coupling": {"S_R": float(S_R)},
        "motion": {"kind": "tapered_sine", "amplitude": float(amplitude)},
    }
    run = synthetic(uneven(SLIPS[S_R, amplitude]), overrides=scene | ({} if geometry is None else {"geometry": geometry}))
    run.attrs["particle_steps"] = 6_000_000
    if (S_R, amplitude) == ("0.50", "6.0"):
        run = Run(run.trajectory.isel(frame=slice(0, 19), sample=slice(0, 181)))
        run["x"][-1, 7] = np.nan
        run.attrs.update({"status": "diverged", "status_reason": "a particle was too fast"})
    return run


def made_study(geometry: Mapping[str, Any] | None = None) -> StudyFiles:
    """Write the study, of the paper's slope or another one, below the working folder."""
    points = [{"S_R": S_R, "gamma": "100", "amplitude": amplitude} for S_R, amplitude in SLIPS]
    runs, rows = [], []
    for point in points:
        run = run_of(point["S_R"], point["amplitude"], geometry)
        runs.append(f"{FOLDER}/runs/" + "_".join(f"{name}-{value}" for name, value in point.items()) + ".nc")
        trajectory.write(runs[-1], run.trajectory)
        measured = {name: value for name, value in measure(run).items() if name in METRIC_BY_NAME}
        rows.append(study_row(*point.values(), **measured | {"expected_displacement_error": 0.31}))
    layout = Layout(labels=(("0.10", "0.50"), ("100",), ("4.0", "6.0")))
    write_csv(study_rows(rows), f"{FOLDER}/parts/000001.csv")
    join_study([f"{FOLDER}/parts/000001.csv"], layout, f"{FOLDER}/study.nc", f"{FOLDER}/study.csv")
    write_csv(decide_claims(read_study(f"{FOLDER}/study.nc")), f"{FOLDER}/claims.csv")
    gravity = synthetic()
    for name, seconds in {"gravity": 0.5, "pre_failure_amplitude-4.0": 0.75, "pre_failure_amplitude-6.0": 1.0}.items():
        gravity.attrs["wall_time_s"] = seconds
        trajectory.write(f"{FOLDER}/stages/{name}.nc", gravity.trajectory)
    for path in certain(FOLDER, PAPER_SECTIONS):
        if path.endswith(".png"):
            Path(path).parent.mkdir(exist_ok=True)
            Image.linear_gradient("L").save(path)
    weak = finding("fails-unshaken", "soil.cohesion", displaced_area=7.0, status="complete", spacing=1.0, run_spacing=1.0)
    coarse = finding("few-particles", "numerics.spacing", value=4.0, bound=20.0, height=10.0)
    write_preflight(f"{FOLDER}/preflight.csv", [Row(each, 4, next(iter(runs))) for each in (weak, coarse)])
    stages = [(f"{FOLDER}/stages/gravity.nc", f"{FOLDER}/stages/pre_failure_amplitude-{point['amplitude']}.nc") for point in points]
    by_name = {Path(run).stem: run for run in runs}
    return StudyFiles(
        "made", "up", FOLDER, f"{FOLDER}/study.csv", layout, DIMENSIONS, 4, by_name, {}, stages,
        existing(FOLDER, PAPER_SECTIONS), PAPER_SECTIONS, {"fig4": runs[1:3]},
    )  # fmt: skip


def listed_study(study: StudyFiles) -> StudyFiles:
    """The same runs as a list of cases, that of S_R 0.50 and 4.0 m/s2 in a larger box."""
    layout = Layout(tuple(found.variable(True) for found in DIMENSIONS), (), True)
    frame = read_table(study.table)
    frame.insert(0, CASE, [f"case-{number:06d}" for number in range(1, 5)])
    write_csv(frame, study.table)
    runs = dict(zip(frame[CASE], study.runs.values(), strict=True))
    wider = {
        "numerics": {"spacing": 5.0},
        "coupling": {"S_R": 0.5},
        "geometry": {"shape": "slope", "crest_length": 60.0},
        "motion": {"kind": "tapered_sine", "amplitude": 4.0, "end": 11.0},
    }
    run = synthetic(uneven(-2.0), overrides=wider)
    run.attrs["particle_steps"] = 6_000_000
    trajectory.write(runs["case-000003"], run.trajectory)
    return study._replace(layout=layout, runs=runs)
