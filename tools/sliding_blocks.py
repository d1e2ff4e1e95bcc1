"""Displacements of slopes beside those of rigid sliding blocks, under a folder of records.

``python -m tools.sliding_blocks FOLDER`` runs every slope of ``SLOPES`` under every record, as accelerations over g in a CSV of time and
acceleration, and writes ``sliding_blocks.csv`` of the package.  Rows of the same solver in ``results/sliding_blocks.csv`` are not made
again; ``--slopes`` names those to run.  ``--figure`` alone draws the table.
"""

from __future__ import annotations

import argparse
import itertools
import math
import shutil
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
import scipy  # type: ignore[import-untyped]
from matplotlib.figure import Figure

from sph.checks.scene import level_ground
from sph.figures.style import DPI, WIDTH, styled
from sph.measures.metrics import measure
from sph.scene.configuration import merge, read_scene
from sph.scene.ground_motion import GroundMotion
from sph.scene.ground_motion.measures import measure as measure_motion
from sph.scene.ground_motion.record import Record
from sph.scene.loading import motion_of
from sph.scene.natural_periods import natural_frequency
from sph.scene.schema import Scene, make_scene
from sph.solver.compiled.jit import solver_digest
from sph.solver.particles import place_particles
from sph.solver.run import run
from sph.stability.newmark import sliding_block
from sph.stability.safety import yield_acceleration
from sph.storage.files import whole
from sph.storage.trajectory import Variable
from sph.study.baseline import baseline_metrics
from sph.study.tables import number_column, read_csv, text_column, write_csv
from tools.shipped import MEASURED, SHIPPED, note
from tools.slow_sine import damping_at

SLOPES: dict[str, tuple[str, dict[str, Any]]] = {
    "stiff_clay": ("stiff_clay", {"numerics": {"spacing": 1.5}, "coupling": {"softening": {"width": 4.5}}}),
    "stiff_clay, E x 10": (
        "stiff_clay",
        {"numerics": {"spacing": 1.5}, "coupling": {"softening": {"width": 4.5}}, "soil": {"youngs_modulus": 2.0e6}},
    ),
    "slope_on_rock": ("slope_on_rock", {"numerics": {"spacing": 2.5}, "coupling": {"softening": {"width": 7.5}}}),
    "gentle_layered": ("gentle_layered", {"numerics": {"spacing": 2.0}}),
}
"""Shipped scenes by what they are called here, and what is changed: spacings of about ten rows over the height, a width of three spacings,
and the stiffness of one, to see what compliance does."""
PEAKS = (3.0,)
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
PUBLISHED = (0.27, 2.25)
"""Blocks over measurements on a shaking table, least and largest; 0.75 on average (Wartman, Seed and Bray 2005)."""
ROWS: tuple[Variable, ...] = (
    text_column("slope", "name of the scene"),
    text_column("strength", "what failed soil keeps"),
    text_column("record", "file of the record"),
    number_column("peak_ratio", "1", "peak acceleration over the yield acceleration"),
    number_column("yield_acceleration", "m s-2", "pseudo-static limit at the spacing of the run"),
    number_column("arias_intensity", "m s-1", "Arias intensity of the motion"),
    number_column("peak_velocity", "m s-1", "peak velocity of the motion"),
    number_column("newmark_displacement", "m", "slip of the rigid block"),
    number_column("column_displacement", "m", "slip of the block under the mean acceleration of the ground below the crest"),
    number_column("overload", "1", "peak mean acceleration of that ground, elastic, over that at which level ground fails in shear"),
    number_column("displacement", "m", "permanent displacement of the crest edge"),
    text_column("status", "status of the run"),
)
"""Columns of the table."""
KEY = ["slope", "strength", "record", "peak_ratio"]


BLOCKS = {"newmark_displacement": "under the motion of the base", "column_displacement": "under that of the column"}
"""The two blocks: decoupled from the ground, and under the mean acceleration of the ground that stands still below it."""
SHARE = 8.0 / math.pi**2
"""Share of the first mode in the mean acceleration over the depth of a uniform column on a rigid base."""


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


def compared(table: pd.DataFrame, block: str = "newmark_displacement") -> pd.DataFrame:
    """Rows whose displacements both are at least ``LEAST`` and that of the slope at most ``SMALL``, with ``ratio``, block over slope."""
    both = table[[block, "displacement"]].min(axis=1) >= LEAST
    kept = table[both & (table["displacement"] <= SMALL)]
    return kept.assign(ratio=kept[block] / kept["displacement"])


def column_motion(scene: Scene) -> GroundMotion:
    """Mean acceleration over the depth of the ground below the crest, an elastic column on a rigid base, in its first mode.

    The relative displacement y of the mode follows y'' + 2 xi w y' + w^2 y = -a with w of the natural period and the scene's
    damping there; the mean is a + 8 / pi^2 y'', as of soil of one stiffness.  An absorbing base is left out.
    """
    motion, period = motion_of(scene), 1.0 / natural_frequency(scene, scene.geometry.crest)
    step = min(period / 40.0, float(np.diff(motion.time).min()))
    time = np.arange(motion.time[0], motion.time[-1] + 10.0 * period, step)
    base, w = np.interp(time, motion.time, motion.acceleration, right=0.0), 2.0 * math.pi / period
    xi = damping_at(scene, 1.0 / period)
    oscillator = scipy.signal.StateSpace([[0.0, 1.0], [-w * w, -2.0 * xi * w]], [[0.0], [-1.0]], [[-w * w, -2.0 * xi * w]], [[-1.0]])
    return GroundMotion(time, base + SHARE * scipy.signal.lsim(oscillator, base, time)[1])


def scene_of(slope: str) -> dict[str, Any]:
    """The scene of a slope, as a mapping."""
    name, changes = SLOPES[slope]
    return dict(merge(read_scene(f"config/scenes/{name}.yaml"), changes))


def scene_under(slope: str, loss: str, record: Path, peak: float) -> dict[str, Any]:
    """The scene of a slope under a record scaled to a peak (m/s2), as a mapping."""
    scene = merge(scene_of(slope), LOSSES[loss])
    start = make_scene(scene).gravity.duration
    shaken = {**scene, "motion": MOTION | {"file": str(record.resolve()), "start": start, "amplitude": peak}}
    motion = make_scene(shaken).motion
    assert isinstance(motion, Record)
    return {**shaken, "duration": math.ceil(motion.end + AFTER)}


def measured(slope: str, loss: str, record: Path, ratio: float, limit: float) -> dict[str, object]:
    """The row of a run."""
    scene = make_scene(scene_under(slope, loss, record, ratio * limit))
    motion, column = motion_of(scene), column_motion(scene)
    carried, _ = level_ground(scene, place_particles(scene))
    shaking = measure_motion(motion.acceleration, float(motion.time[1] - motion.time[0]))
    metrics = measure(run(scene).trajectory)
    return {
        "slope": slope,
        "strength": loss,
        "record": record.name,
        "peak_ratio": ratio,
        "yield_acceleration": limit,
        "arias_intensity": shaking.arias_intensity,
        "peak_velocity": shaking.peak_velocity,
        "newmark_displacement": baseline_metrics(scene, limit)["newmark_displacement"],
        "column_displacement": sliding_block(column.time, column.acceleration, limit).permanent,
        "overload": float(np.abs(column.acceleration).max()) / carried,
        "displacement": metrics["displacement_magnitude"],
        "status": metrics["status"],
    }


def tables(records: Sequence[Path], slopes: Sequence[str], made: pd.DataFrame) -> Iterator[pd.DataFrame]:
    """The table after every run that is not in the one already made."""
    limits = dict(zip(made["slope"], made["yield_acceleration"], strict=True))
    known = set(made[KEY].itertuples(index=False, name=None))
    for ratio, loss, slope in itertools.product(PEAKS, LOSSES, slopes):
        if slope not in limits:
            limits[slope] = yield_acceleration(make_scene(scene_of(slope))).value
        for record in records:
            if (slope, loss, record.name, ratio) not in known:
                row = pd.DataFrame([measured(slope, loss, record, ratio, limits[slope])])
                print(row.to_string(header=False, index=False), flush=True)
                made = pd.concat([made, row], ignore_index=True) if len(made) else row
                yield made


def spread_rows(table: pd.DataFrame) -> Iterator[tuple[str, ...]]:
    """Rows (slope, strength, block, pairs, pairs beyond ``SMALL``, geometric mean, scatter, range) of block over slope, and the median
    overload of level ground by the elastic column."""
    for (loss, slope), rows in table.groupby(["strength", "slope"], sort=False):
        for block, said in BLOCKS.items():
            ratios, beyond = spread(compared(rows, block)["ratio"].to_numpy()), int((rows["displacement"] > SMALL).sum())
            numbers = ["", "", ""]
            if ratios.pairs:
                numbers = [f"{ratios.mean:.2f}", f"{ratios.scatter:.2f}", f"{ratios.least:.2f} to {ratios.largest:.2f}"]
            overload = f"{rows['overload'].median():.1f}" if block == "column_displacement" else ""
            yield str(slope), str(loss), said, str(ratios.pairs), str(beyond), *numbers, overload


def cause_rows(table: pd.DataFrame) -> Iterator[tuple[str, ...]]:
    """Rows (slope, Arias intensity, overload, block under the column over slope, correlations of the logarithm of that ratio with those of
    the overload and of the Arias intensity) of the slopes that keep their peak strength."""
    for slope, rows in compared(table[table["strength"] == next(iter(LOSSES))], "column_displacement").groupby("slope", sort=False):
        ranges = (f"{rows[name].min():.2g} to {rows[name].max():.2g}" for name in ("arias_intensity", "overload", "ratio"))
        ratio, *causes = (np.log(rows[name].to_numpy(float)) for name in ("ratio", "overload", "arias_intensity"))
        yield str(slope), *ranges, *(f"{np.corrcoef(ratio, cause)[0, 1]:.2f}" for cause in causes)


def read_blocks(path: Path = MEASURED / "sliding_blocks.csv") -> pd.DataFrame:
    """The table of this release; ValueError where the file is none."""
    return read_csv(path, ROWS, "displacements beside sliding blocks")


@styled
def figure_blocks(table: pd.DataFrame) -> Figure:
    """Displacement of the slope against that of the rigid block, under the motion of the base and under the mean of the column.

    Filled with strength that is lost by slip.  Lines: equality, and 27 and 225 % of Wartman, Seed and Bray (2005).
    """
    figure = Figure(figsize=(WIDTH, 3.3), layout="constrained")
    axes, span = figure.subplots(1, 2, sharey=True), np.array([LEAST, 100.0])
    for ax, (block, said) in zip(axes, BLOCKS.items(), strict=True):
        for share, dashes in ((1.0, "-"), (PUBLISHED[0], ":"), (PUBLISHED[1], ":")):
            ax.plot(span, span / share, color="0.5", linewidth=0.7, linestyle=dashes)
        for marker, slope in zip("osD^", SLOPES, strict=True):
            for loss, face in zip(LOSSES, ("white", "black"), strict=True):
                rows = table[(table["slope"] == slope) & (table["strength"] == loss)]
                if len(rows):
                    x, y = (rows[name].clip(lower=LEAST) for name in (block, "displacement"))
                    label = f"{slope.replace('_', ' ')}, {loss}"
                    ax.plot(x, y, linestyle="", marker=marker, markersize=3.5, color="black", markerfacecolor=face, label=label)
        ax.set(xlabel=f"rigid block {said} (m)", xscale="log", yscale="log", xlim=span, ylim=span)
    axes[0].set_ylabel("crest edge (m)")
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=2, fontsize="xx-small")
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
