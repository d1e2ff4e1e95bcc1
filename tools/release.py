"""What a release states of the paper's study: the verdicts on its claims, and its fidelities against ``paper``; and times of commands.

The tables measured for this release are part of the package.  ``python -m tools.release`` writes ``claims.csv``,
``fidelities.csv``, ``resolved_claims.csv`` and ``solid_states.csv`` from what lies in ``results``, or the one named;
``python -m tools.times`` measures ``times.csv``.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd

import sph
from sph.experiments.paper.claims import COLUMNS
from sph.experiments.paper.design import DIMENSIONS
from sph.storage.trajectory import Variable, read, scene_of
from sph.study.tables import count_column, number_column, read_csv, read_table, text_column, write_csv
from sph.study.verdicts import NOT_YET
from tools.shipped import MEASURED, SHIPPED, note, solver_of

STUDY = Path("results/paper")
"""Folder of the paper's study, which holds one a fidelity."""
BASELINE = "paper"
"""The fidelity that the others are compared with, and that the claims are decided at."""
STUDY_AT = "study at "
"""The time of the whole study at a fidelity but ``BASELINE`` is that of the task with this before its name."""
RESOLVED_STUDIES = ("paper_resolved", "long_box")
"""Studies of the paper's slope with the scheme of one's own slopes: in the paper's box, and in one long enough to hardly matter."""
SOLID_STATES_STUDY = Path("results/paper_solid_states")
"""Folder of the study of the paper's slope with either solid state of failed soil."""
READ_AT = (10.0, 15.0, 20.0)
"""Times (s) at which A's displacement is read there: the end of the shaking, the time of Figs. 4 and 5, and later."""
MIN_DISPLACEMENT = 0.1
"""Displacement of A (m) at the baseline below which a relative difference says nothing."""

ORIGIN = text_column("origin", "version that was measured")
CLAIMS: tuple[Variable, ...] = (
    count_column("claim", "number of the claim"),
    text_column("statement", "what the paper says, in our words"),
    text_column("test", "by which number it is decided"),
    text_column("measured", "the number"),
    text_column("verdict", "holds or fails"),
    ORIGIN,
)
FIDELITIES: tuple[Variable, ...] = (
    text_column("fidelity", "name of the fidelity"),
    count_column("runs", "runs of the study"),
    count_column("same_class", f"runs of the class that they have at {BASELINE}"),
    number_column(
        "displacement_difference",
        "1",
        f"largest difference of A's displacement over that at {BASELINE}, of runs of the same class in which A moves by more than "
        f"{MIN_DISPLACEMENT:g} m",
    ),
    ORIGIN,
)
RESOLVED_CLAIMS: tuple[Variable, ...] = (
    text_column("study", "name of the study, one with the scheme resolved"),
    text_column("fidelity", "name of its fidelity"),
    *CLAIMS,
)
SOLID_STATES: tuple[Variable, ...] = (
    text_column("solid_after_failure", "solid state of failed soil"),
    number_column("S_R", "1", "strength ratio"),
    number_column("gamma", "s-1", "rate of the loss of strength"),
    *(number_column(f"displacement_{time:g}", "m", f"A's displacement at {time:g} s") for time in READ_AT),
    ORIGIN,
)
TIMES: tuple[Variable, ...] = (
    text_column("task", "what was timed"),
    number_column("wall_time", "s", "time from its start to its end"),
    text_column("conditions", "what was there before"),
    text_column("machine", "processor and number of cores"),
    ORIGIN,
)
"""Columns of the tables ``claims``, ``fidelities``, ``resolved_claims``, ``solid_states`` and ``times``."""
_VARIABLES = {
    "claims": CLAIMS,
    "fidelities": FIDELITIES,
    "resolved_claims": RESOLVED_CLAIMS,
    "solid_states": SOLID_STATES,
    "times": TIMES,
}


def read_measured(name: str) -> pd.DataFrame:
    """A table of this release by name; ValueError names a file that is none."""
    return read_csv(MEASURED / f"{name}.csv", _VARIABLES[name], f"the {name} of a release")


def measured_claims(study: Path) -> pd.DataFrame:
    """The claims with the columns ``CLAIMS`` from the results of a study; ValueError without them.

    The claim that a grid of runs cannot decide is that of the search for the critical amplitude, in its first case; ValueError without.
    """
    claims = pd.read_csv(_found(study / BASELINE / "claims.csv", "snakemake --cores 2"), keep_default_na=False)
    searched = sorted(study.glob("*/trigger/claim.csv"))
    open_claims = claims["verdict"] == NOT_YET
    if open_claims.any():
        if not searched:
            raise ValueError(f"{study}: no trigger/claim.csv; run 'snakemake --cores 2 trigger'")
        decided = pd.read_csv(searched[0], keep_default_na=False).iloc[0]
        rounds = next(study.glob("*/trigger/rounds"))  # of the fidelity that the search names, whatever the study's
        told = f"{decided['measured']}, searched at fidelity `{rounds.parents[1].name}`"
        claims.loc[open_claims, ["test", "measured", "verdict"]] = [decided["test"], told, decided["verdict"]]
    return claims[list(COLUMNS)].assign(origin=sph.__version__)


def resolved_claims(results: Path) -> pd.DataFrame:
    """The claims of ``RESOLVED_STUDIES`` at every fidelity in a folder of results, with the columns ``RESOLVED_CLAIMS``.

    ValueError without any.
    """
    tables = [
        pd.read_csv(path, keep_default_na=False)[list(COLUMNS)].assign(study=name, fidelity=path.parent.name, origin=sph.__version__)
        for name in RESOLVED_STUDIES
        for path in sorted((results / name).glob("*/claims.csv"))
    ]
    if not tables:
        raise ValueError(f"{results}: no claims of {RESOLVED_STUDIES[0]}; run 'snakemake --cores 2 --configfile config/studies/NAME.yaml'")
    return pd.concat(tables, ignore_index=True)[[row.name for row in RESOLVED_CLAIMS]]


def solid_states(study: Path) -> pd.DataFrame:
    """A's displacement at ``READ_AT`` in the runs of a study of both solid states: columns ``SOLID_STATES``; ValueError without any."""
    rows = []
    for path in sorted(study.glob("*/runs/*.nc")):
        run = read(path)
        coupling, time = scene_of(run, str(path)).coupling, run["sample_time"].values
        away = np.hypot(run["probe_displacement_x"].values[:, 0], run["probe_displacement_y"].values[:, 0])
        moved = {f"displacement_{at:g}": float(np.interp(at, time, away, right=math.nan)) for at in READ_AT}
        rows.append({**coupling.model_dump(include={"solid_after_failure", "S_R", "gamma"}), **moved, "origin": sph.__version__})
    if not rows:
        raise ValueError(f"{study}: no runs; run '{SHIPPED['solid_states'].renewal}'")
    table = pd.DataFrame(rows)[[row.name for row in SOLID_STATES]]
    return table.sort_values(["solid_after_failure", "gamma", "S_R"], ignore_index=True)


def compared_fidelities(study: Path) -> pd.DataFrame:
    """Every fidelity of a study but the baseline against it, with the columns ``FIDELITIES``; ValueError without two of them."""
    baseline = read_table(_found(study / BASELINE / "study.csv", "snakemake --cores 2"))
    rows = [
        {"fidelity": path.parent.name, **agreement(read_table(path), baseline), "origin": sph.__version__}
        for path in sorted(study.glob("*/study.csv"))
        if path.parent.name != BASELINE
    ]
    if not rows:
        raise ValueError(f"{study}: no other fidelity; run for instance 'snakemake --cores 2 --config fidelity=standard'")
    return pd.DataFrame(rows, columns=[row.name for row in FIDELITIES])


def agreement(study: pd.DataFrame, baseline: pd.DataFrame) -> dict[str, float]:
    """Runs, those of the same class, and the largest relative difference of A's displacement (see ``FIDELITIES``) of two tables."""
    both = study.merge(baseline, on=list(DIMENSIONS), suffixes=("", "_baseline"), validate="one_to_one")
    if len(both) < len(baseline):
        raise ValueError(f"the study has {len(both)} of the {len(baseline)} runs that it is compared with")
    same = both["collapse_class"] == both["collapse_class_baseline"]
    displacement, reference = both["displacement_magnitude"], both["displacement_magnitude_baseline"]
    differences = (displacement / reference - 1.0).abs()[same & (reference > MIN_DISPLACEMENT)]
    return {"runs": len(both), "same_class": int(same.sum()), "displacement_difference": float(differences.max())}


def write_time(task: str, seconds: float, conditions: str, machine: str) -> None:
    """Put the time of a task into the table ``times`` of this release, in the place of an earlier one."""
    row = {"task": task, "wall_time": seconds, "conditions": conditions, "machine": machine, "origin": sph.__version__}
    times = read_measured("times")
    kept = times[times["task"] != task]
    write_csv(pd.concat([kept, pd.DataFrame([row])], ignore_index=True), MEASURED / "times.csv")


def _found(path: Path, command: str) -> Path:
    if not path.is_file():
        raise ValueError(f"{path}: no such file; run '{command}'")
    return path


if __name__ == "__main__":
    made: dict[str, Callable[[], pd.DataFrame]] = {
        "claims": lambda: measured_claims(STUDY),
        "fidelities": lambda: compared_fidelities(STUDY),
        "resolved_claims": lambda: resolved_claims(STUDY.parent),
        "solid_states": lambda: solid_states(SOLID_STATES_STUDY),
    }
    for name in sys.argv[1:] or made:
        table, solver = made[name](), solver_of(SHIPPED[name].runs)
        write_csv(table, MEASURED / f"{name}.csv")
        note(name, solver)
        print(MEASURED / f"{name}.csv")
