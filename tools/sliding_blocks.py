"""Displacements of slopes beside those of rigid sliding blocks, under a folder of records.

``python -m tools.sliding_blocks FOLDER`` runs every slope of ``SLOPES`` under every record, as accelerations over g in a CSV of time and
acceleration, and writes ``sliding_blocks.csv`` of the package.  Rows of the same solver in ``results/sliding_blocks.csv`` are not made
again; ``--slopes`` names those to run.  ``--figure`` alone draws the table.
"""

from __future__ import annotations

import argparse
import math
import shutil
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from sph.figures.style import DPI, WIDTH, styled
from sph.measures.metrics import measure
from sph.scene.configuration import merge, read_scene
from sph.scene.ground_motion import motion_of
from sph.scene.ground_motion.measures import measure as measure_motion
from sph.scene.ground_motion.record import Record
from sph.scene.schema import make_scene
from sph.solver.compiled.jit import solver_digest
from sph.solver.run import run
from sph.stability.safety import yield_acceleration
from sph.storage.files import whole
from sph.storage.trajectory import Variable
from sph.study.baseline import baseline_metrics
from sph.study.tables import number_column, read_csv, text_column, write_csv
from tools.shipped import MEASURED, SHIPPED, note

SLOPES: dict[str, dict[str, Any]] = {
    "stiff_clay": {"numerics": {"spacing": 1.5}, "coupling": {"softening": {"width": 4.5}}},
    "slope_on_rock": {"numerics": {"spacing": 2.5}, "coupling": {"softening": {"width": 7.5}}},
    "gentle_layered": {"numerics": {"spacing": 2.0}},
}
"""Shipped scenes, and what is changed: spacings of about ten rows over the height, and a width of three spacings."""
PEAKS = (3.0, 1.5)
"""Peak accelerations over the yield acceleration to which records are scaled."""
LOSSES: dict[str, dict[str, Any]] = {"peak strength kept": {"coupling": {"S_R": 1.0}}, "strength lost by slip": {}}
"""What of the strength failed soil keeps."""
MOTION = {"kind": "record", "unit": "g", "baseline": {"degree": 1}, "trim": {"start_share": 0.05, "end_share": 0.95}}
AFTER = 2.0
"""Time after the record, s."""
SMALL = 1.0
"""Displacement up to which slopes and blocks are compared, m."""
LEAST = 1e-3
"""Displacement of either below which there is no ratio, m: what a slope of particles moves elastically."""
PUBLISHED = (0.27, 2.25, 0.75)
"""Blocks over measurements on a shaking table, least, largest and mean (Wartman, Seed and Bray 2005)."""
PARTED = 4.0
"""Arias intensity above which published material-point runs and small-strain methods part, m/s."""

ROWS: tuple[Variable, ...] = (
    text_column("slope", "name of the scene"),
    text_column("strength", "what failed soil keeps"),
    text_column("record", "file of the record"),
    number_column("peak_ratio", "1", "peak acceleration over the yield acceleration"),
    number_column("yield_acceleration", "m s-2", "pseudo-static limit at the spacing of the run"),
    number_column("arias_intensity", "m s-1", "Arias intensity of the motion"),
    number_column("peak_velocity", "m s-1", "peak velocity of the motion"),
    number_column("newmark_displacement", "m", "slip of the rigid block"),
    number_column("displacement", "m", "permanent displacement of the crest edge"),
    text_column("status", "status of the run"),
)
"""Columns of the table."""
KEY = ["slope", "strength", "record", "peak_ratio"]


class Spread(NamedTuple):
    """Ratios of two displacements."""

    pairs: int
    mean: float
    """geometric"""
    scatter: float
    """standard deviation of the natural logarithm; NaN of fewer than two"""
    least: float
    largest: float


def spread(ratios: np.ndarray) -> Spread:
    """Geometric mean, scatter and range of ratios (n,); NaN without any."""
    if not ratios.size:
        return Spread(0, math.nan, math.nan, math.nan, math.nan)
    logs = np.log(ratios)
    deviation = float(logs.std(ddof=1)) if ratios.size > 1 else math.nan
    return Spread(ratios.size, float(np.exp(logs.mean())), deviation, float(ratios.min()), float(ratios.max()))


def compared(table: pd.DataFrame) -> pd.DataFrame:
    """Rows whose displacements both are at least ``LEAST`` and that of the slope at most ``SMALL``, with ``ratio``, block over slope."""
    both = table[["newmark_displacement", "displacement"]].min(axis=1) >= LEAST
    kept = table[both & (table["displacement"] <= SMALL)]
    return kept.assign(ratio=kept["newmark_displacement"] / kept["displacement"])


def scene_under(slope: str, loss: str, record: Path, peak: float) -> dict[str, Any]:
    """The scene of a slope under a record scaled to a peak (m/s2), as a mapping."""
    scene = merge(merge(read_scene(f"config/scenes/{slope}.yaml"), SLOPES[slope]), LOSSES[loss])
    start = make_scene(scene).gravity.duration
    shaken = {**scene, "motion": MOTION | {"file": str(record.resolve()), "start": start, "amplitude": peak}}
    motion = make_scene(shaken).motion
    assert isinstance(motion, Record)
    return {**shaken, "duration": math.ceil(motion.end + AFTER)}


def measured(slope: str, loss: str, record: Path, ratio: float, limit: float) -> dict[str, object]:
    """The row of a run."""
    scene = make_scene(scene_under(slope, loss, record, ratio * limit))
    motion = motion_of(scene)
    shaking = measure_motion(motion.acceleration, float(motion.time[1] - motion.time[0]))
    found = measure(run(scene).trajectory)
    return {
        "slope": slope,
        "strength": loss,
        "record": record.name,
        "peak_ratio": ratio,
        "yield_acceleration": limit,
        "arias_intensity": shaking.arias_intensity,
        "peak_velocity": shaking.peak_velocity,
        "newmark_displacement": baseline_metrics(scene, limit)["newmark_displacement"],
        "displacement": found["displacement_magnitude"],
        "status": found["status"],
    }


def tables(records: Sequence[Path], slopes: Sequence[str], made: pd.DataFrame) -> Iterator[pd.DataFrame]:
    """The table after every run that is not in the one already made."""
    for slope in slopes:
        known = made[made["slope"] == slope]["yield_acceleration"]
        limit = (
            float(known.iloc[0])
            if len(known)
            else yield_acceleration(make_scene(merge(read_scene(f"config/scenes/{slope}.yaml"), SLOPES[slope]))).value
        )
        for ratio in PEAKS:
            for loss in LOSSES:
                for record in records:
                    if (slope, loss, record.name, ratio) in set(made[KEY].itertuples(index=False, name=None)):
                        continue
                    row = measured(slope, loss, record, ratio, limit)
                    print(row, flush=True)
                    made = pd.concat([made, pd.DataFrame([row])], ignore_index=True) if len(made) else pd.DataFrame([row])
                    yield made


def spread_rows(table: pd.DataFrame) -> Iterator[tuple[str, ...]]:
    """Rows (slope, strength, pairs, pairs beyond ``SMALL``, geometric mean, scatter, range) of block over slope; of all slopes last."""
    for loss in LOSSES:
        rows = table[table["strength"] == loss]
        for slope in (*(slope for slope in SLOPES if (rows["slope"] == slope).any()), "all"):
            own = rows if slope == "all" else rows[rows["slope"] == slope]
            found, beyond = spread(compared(own)["ratio"].to_numpy()), int((own["displacement"] > SMALL).sum())
            low_high = f"{found.least:.2f} to {found.largest:.2f}" if found.pairs else ""
            yield slope, loss, str(found.pairs), str(beyond), f"{found.mean:.2f}", f"{found.scatter:.2f}", low_high


def read_blocks(path: Path = MEASURED / "sliding_blocks.csv") -> pd.DataFrame:
    """The table of this release; ValueError where the file is none."""
    return read_csv(path, ROWS, "displacements beside sliding blocks")


@styled
def figure_blocks(table: pd.DataFrame) -> Figure:
    """Displacement of the slope against that of the rigid block, and block over slope against the Arias intensity.

    Filled with strength that is lost by slip.  Lines: equality, and 27 and 225 % of Wartman, Seed and Bray (2005).
    """
    figure = Figure(figsize=(WIDTH, 3.1), layout="constrained")
    left, right = figure.subplots(1, 2)
    span = np.array([LEAST, 30.0])
    for share, dashes in ((1.0, "-"), (PUBLISHED[0], ":"), (PUBLISHED[1], ":")):
        left.plot(span, span / share, color="0.5", linewidth=0.7, linestyle=dashes)
        right.axhline(share, color="0.5", linewidth=0.7, linestyle=dashes)
    right.axvline(PARTED, color="0.5", linewidth=0.7, linestyle="--")
    for marker, slope in zip("os^", SLOPES, strict=True):
        for loss, face in zip(LOSSES, ("white", "black"), strict=True):
            rows = table[(table["slope"] == slope) & (table["strength"] == loss)]
            if len(rows):
                style: Mapping[str, Any] = {"linestyle": "", "marker": marker, "markersize": 3.5, "markeredgewidth": 0.6}
                drawn = rows[["newmark_displacement", "displacement"]].clip(lower=LEAST)
                name = slope.replace("_", " ")
                left.plot(
                    drawn["newmark_displacement"],
                    drawn["displacement"],
                    color="black",
                    markerfacecolor=face,
                    label=f"{name}, {loss}",
                    **style,
                )
                ratio = drawn["newmark_displacement"] / drawn["displacement"]
                right.plot(rows["arias_intensity"], ratio, color="black", markerfacecolor=face, **style)
    left.set(xlabel="rigid block (m)", ylabel="crest edge (m)", xscale="log", yscale="log", xlim=span, ylim=span)
    right.set(xlabel="Arias intensity (m/s)", ylabel="block over slope", xscale="log", yscale="log")
    figure.legend(loc="outside lower center", ncols=2, fontsize="xx-small")
    return figure


def main(arguments: Sequence[str] | None = None) -> None:
    """Run what is missing, write the table and print the spreads."""
    parser = argparse.ArgumentParser(prog="python -m tools.sliding_blocks", description=main.__doc__)
    parser.add_argument("folder", type=Path, nargs="?", help="folder of records, CSV of time (s) and acceleration (g)")
    parser.add_argument("--slopes", nargs="+", choices=list(SLOPES), default=list(SLOPES))
    parser.add_argument("--figure", type=Path, help="draw the table of the package into this file, and run nothing")
    given = parser.parse_args(arguments)
    if given.figure:
        with whole(given.figure) as temporary:
            figure_blocks(read_blocks()).savefig(temporary, dpi=DPI, format="png")
        return
    records = sorted(given.folder.glob("*.csv")) if given.folder else []
    if not records:
        parser.error(f"folder: {given.folder} holds no *.csv; give a folder of records")
    kept = Path("results/sliding_blocks") / f"{solver_digest()}.csv"
    made = read_blocks(kept) if kept.is_file() else pd.DataFrame(columns=[row.name for row in ROWS])
    kept.parent.mkdir(parents=True, exist_ok=True)
    for table in tables(records, given.slopes, made):
        write_csv(table, kept)
        made = table
    shutil.copyfile(kept, SHIPPED["sliding_blocks"].path)
    note("sliding_blocks", solver_digest())
    for line in spread_rows(made):
        print(*line, sep="\t")


if __name__ == "__main__":
    main()
