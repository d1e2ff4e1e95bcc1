"""Runs of the two San Fernando dams (``san-fernando-dams.md``).

``python docs/gallery/san_fernando_dams.py`` makes both dams at two spacings and draws them; with ``all`` after it what decides as well.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd

import sph
from sph.scene.configuration import merge
from sph.scene.ground_motion.measures import arias_share
from sph.scene.liquefaction import residual_ratio
from sph.scene.loading import motion_of

LOWER = {
    "freeboard (m)": (-1.5, 4.5),
    "upstream, crest (m)": (5.0, 200.0),
    "downstream side (m)": (0.0, 1.0),
    "begins after the strong shaking (s)": (0.0, 120.0),
}
UPPER = {"downstream, crest (m)": (0.5, 3.0), "settlement, crest (m)": (0.3, 1.5), "speed of the crest at the end (m/s)": (0.0, 0.01)}
"""Ranges of what was seen in 1971."""
RESERVOIR = {"lower": 338.4, "upper": 368.0}
"""Its elevation, m."""
N_FOR_S_R = {
    "lower": {"shell_1": 12.9, "shell_2": 27.7, "shell_3": 23.6, "shell_4": 10.8, "shell_5": 16.9},
    "upper": {"upstream_shell_2": 14.8, "upstream_shell_3": 11.6, "downstream_shell_1": 14.7, "downstream_shell_2": 13.5},
}
"""Blow counts for the residual strength."""
KEPT = {"soil": {"residual_friction_angle": None}}
FREEBOARD, SETTLEMENT = 2.4, 5.3
"""Of the Lower dam and of the Upper dam's crest at 3 m, as the page tells them, m."""


def compute(dam: str, keys: Mapping[str, Any], figure: str | None = None) -> dict[str, Any]:
    """What a run of a dam with other keys did, drawn into a figure."""
    scene = sph.load_scene(f"docs/gallery/{dam}_san_fernando.yaml", keys)
    run = sph.run(scene)
    if figure:
        sph.plot(run, figure)
    end, series, motion = run.trajectory.isel(frame=-1), run.trajectory, motion_of(scene)
    soil, x = end["kind"].values == 0, scene.geometry.in_survey(end["x0"].values, end["y0"].values)[0]
    crest = -series["probe_displacement_x"].values[:, 0]  # towards the toe
    time = scene.outputs.series_interval * np.arange(crest.size)
    strong = motion.time[np.searchsorted(arias_share(motion.acceleration), 0.95)]
    moved = np.flatnonzero(crest > 0.3)
    top = scene.geometry.base + float(end["y"].values[soil].max()) + 0.5 * scene.numerics.spacing
    last = crest[-round(5.0 / scene.outputs.series_interval) :]
    found = {"status": run.trajectory.attrs["status"], "freeboard (m)": top - RESERVOIR[dam]}
    found["upstream, crest (m)" if dam == "lower" else "downstream, crest (m)"] = crest[-1]
    found["settlement, crest (m)"] = -series["probe_displacement_y"].values[-1, 0]
    if dam == "lower":
        found["downstream side (m)"] = float(np.abs(end["displacement_x"].values[soil & (x > 60.0)]).max())
    found["begins after the strong shaking (s)"] = time[moved[0]] - strong if moved.size else np.nan
    found["speed of the crest at the end (m/s)"] = abs(last[-1] - last[0]) / 5.0
    failed = np.isfinite(end["t_f"].values) & (end["pore_pressure_ratio"].values > 0)
    found["liquefied (%)"] = 100.0 * failed[soil].sum() / (end["pore_pressure_ratio"].values[soil] > 0).sum()
    return found


def blows(dam: str, factor: float, apart: bool = False) -> dict[str, Any]:
    """Keys of all blow counts times a factor, with residual strengths without void redistribution if ``apart``."""
    layers = {}
    for name, layer in sph.load_scene(f"docs/gallery/{dam}_san_fernando.yaml").layers.items():
        if layer.soil.blow_count:
            layers[name] = {"soil": {"blow_count": factor * layer.soil.blow_count}}
        if name in N_FOR_S_R[dam]:
            layers[name]["soil"]["liquefied_strength_ratio"] = min(residual_ratio(factor * N_FOR_S_R[dam][name], apart), 1.0)
    return {"layers": layers}


def liquefaction(**keys: Any) -> dict[str, Any]:
    """Keys of the law of liquefaction."""
    return {"water": {"excess_pressure": {"liquefaction": keys}}}


def at_two_spacings() -> pd.DataFrame:
    """Both dams at two spacings, with what they miss of 1971; draws those at 2 m."""
    rows = []
    for dam, limits in (("lower", LOWER), ("upper", UPPER)):
        for spacing in (3.0, 2.0):
            found = compute(dam, {"numerics": {"spacing": spacing}}, f"{dam}.png" if spacing == 2.0 else None)
            missed = [name for name, (low, high) in limits.items() if not low <= found[name] <= high]
            rows.append({"dam": dam, "spacing (m)": spacing, **found, "missed": ", ".join(missed) or "none"})
    return pd.DataFrame(rows)


def changed() -> pd.DataFrame:
    """Both dams at 3 m with one thing changed at a time."""
    rows = []
    for dam in ("lower", "upper"):
        changes = {
            "as published": {},
            "N 20 % less": blows(dam, 0.8),
            "N 20 % more": blows(dam, 1.2),
            "S_r without void redistribution": merge(blows(dam, 1.0, True), liquefaction(strength="idriss_boulanger_no_redistribution")),
            "liquefied from r_u = 0.5": liquefaction(r_u=0.5),
            "liquefied from r_u = 0.9": liquefaction(r_u=0.9),
            "constant stiffness": {"water": {"excess_pressure": {"stiffness_exponent": 0.0}}},
            "alluvium without excess pore pressure": {"layers": {"foundation": {"soil": {"blow_count": None}}}},
            "core and rolled fill keep their strength": merge(KEPT, {"layers": {"core": KEPT}}),
            "strength lost within 30 s": {"coupling": {"gamma": 0.1}},
            "motion reversed": {"motion": {"factor": -1.0}},
        }
        for name, keys in changes.items():
            rows.append({"dam": dam, "run": name, **compute(dam, {**keys, "numerics": {"spacing": 3.0}})})
    return pd.DataFrame(rows)


if __name__ == "__main__":
    table = at_two_spacings()
    print(table.T.to_markdown(floatfmt=".2f"))
    if "all" in sys.argv[1:]:
        print()
        print(changed().drop(columns=["status"]).to_markdown(index=False, floatfmt=".2f"))
    coarse = table[table["spacing (m)"] == 3.0].set_index("dam")
    found = coarse.loc["lower", "freeboard (m)"], coarse.loc["upper", "settlement, crest (m)"]
    assert np.abs(np.subtract(found, (FREEBOARD, SETTLEMENT))).max() < 0.5, found
