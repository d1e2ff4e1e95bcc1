"""Kill runs and studies with SIGKILL at random instants, give the same command again, and compare every bit.

    python tests/faults/kills.py --kills 200 --studies 20

prints where the kills hit, what they cost, and whether all results equal the uninterrupted ones.
"""

from __future__ import annotations

import argparse
import random
import statistics
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path
from typing import Any, NamedTuple

import yaml

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT), str(ROOT / "tests")]

from comparison import same_files, same_variables  # noqa: E402
from killing import CHECKPOINT, TIMINGS, killed, start  # noqa: E402
from small_scenes import SLOPE  # noqa: E402

from sph.scene.configuration import dotted, merge  # noqa: E402
from sph.storage import trajectory  # noqa: E402
from sph.storage.files import beside  # noqa: E402
from sph.study.tables import read_study  # noqa: E402

SCENE = merge(SLOPE, dotted({"duration": 4.0, "numerics.time_step": 1e-4, "outputs.frame_interval": 0.05}))
"""The small slope for a second or two of computing, with a long history to write."""
STUDY: dict[str, Any] = {
    "study": "killed",
    "scene": "slope.yaml",
    "fidelity": "draft",
    "grid": {"S_R": ["0.10", "0.50"], "gamma": ["100"], "amplitude": ["8.0"]},
    "fidelities": {"draft": {"walls": {"sides": "free_slip", "layers": 4}, "numerics": {"spacing": 2.5, "time_step": 5e-4}}},
    "figures": {"strengths": ["0.10"], "compared_gammas": ["100"], "compared_strengths": ["0.10"]},
    "claims": {"amplitude": 8.0},
}
RESULTS = Path("results", "killed", "draft")
LAST_STEP = 6.0
"""Seconds in which Snakemake starts and measures a finished study."""


class Kill(NamedTuple):
    """One kill: where it hit, judged by what lay there, and the wall time since the last checkpoint, which it cost."""

    hit: str
    lost: float | None


def command(*arguments: object) -> list[str]:
    return [sys.executable, "-m", "sph.command.cli", *map(str, arguments)]


def finish(arguments: list[str], folder: Path) -> None:
    process = start(arguments, folder)
    assert process.wait(600) == 0, (folder / "output.log").read_text()


# ---------------------------------------------------------------- one run


def run_arguments(until: str) -> list[str]:
    return command("run", "slope.yaml", "--out", "run.nc", "--until", until)


def hit_of(folder: Path) -> Kill:
    out = folder / "run.nc"
    kept = beside(out, "checkpoint")
    lost = time.time() - kept.stat().st_mtime if kept.exists() else None
    for what, path in (("writing a checkpoint", kept), ("writing the result", out)):
        if beside(path, "part").exists():
            return Kill(what, lost)
    if out.exists():
        return Kill("after the result", 0.0)
    if kept.exists():
        return Kill("solver, after a checkpoint", lost)
    return Kill("solver, before a checkpoint" if beside(out, "run").exists() else "before the run", lost)


def whole_or_absent(folder: Path) -> None:
    """What lies under a final name can be read."""
    for path in (folder / "run.nc", beside(folder / "run.nc", "checkpoint")):
        if path.exists():
            trajectory.read_run(path)
            trajectory.read_restart(path)


def killed_run(folder: Path, reference: Path, until: str, instants: random.Random, longest: float, most: int = 5) -> list[Kill]:
    """Kill one run up to ``most`` times, let it finish, and compare it with the uninterrupted one."""
    folder.mkdir(parents=True)
    (folder / "slope.yaml").write_text(yaml.safe_dump(SCENE))
    kills = []
    while len(kills) < most and killed(start(run_arguments(until), folder), instants.uniform(0.0, longest)):
        whole_or_absent(folder)
        kills.append(hit_of(folder))
    finish(run_arguments(until), folder)
    same_files(folder / "run.nc", reference)
    left = sorted(path.name for path in folder.iterdir())
    assert left == ["output.log", "run.nc", "slope.yaml"], left
    return kills


def uninterrupted(folder: Path, until: str) -> tuple[Path, float]:
    """The reference, and the seconds it took (compiled code in the cache, checkpoints written)."""
    folder.mkdir(parents=True)
    (folder / "slope.yaml").write_text(yaml.safe_dump(SCENE))
    finish([*run_arguments(until), "--checkpoint", "0"], folder)
    (folder / "run.nc").rename(folder / "reference.nc")
    began = time.monotonic()
    finish(run_arguments(until), folder)
    same_files(folder / "run.nc", folder / "reference.nc")
    return folder / "reference.nc", time.monotonic() - began


# ---------------------------------------------------------------- a study


def study_arguments(folder: Path) -> list[str]:
    snakemake = [sys.executable, "-m", "snakemake", "--snakefile", str(ROOT / "Snakefile"), "--directory", str(folder)]
    return [*snakemake, "--cores", "2", "--configfile", str(folder / "study.yaml"), "--rerun-incomplete"]


def study_folder(folder: Path) -> Path:
    folder.mkdir(parents=True)
    (folder / "slope.yaml").write_text(yaml.safe_dump(SLOPE))
    (folder / "study.yaml").write_text(yaml.safe_dump(STUDY))
    return folder


def target(folder: Path) -> list[str]:
    return [*study_arguments(folder), str(RESULTS / "study.csv")]


def killed_study(folder: Path, reference: Path, after: float, last_step: bool = False) -> bool:
    """Kill Snakemake and its jobs, in the measuring of finished runs if so wished; unlock, let it finish, and compare.

    False if it ended before it was killed.
    """
    study_folder(folder)
    runs = sorted(path.relative_to(reference) for path in (reference / RESULTS).glob("*/*.nc"))
    if last_step:
        finish([*study_arguments(folder), *map(str, runs)], folder)
    hit = killed(start(target(folder), folder), after)
    if hit:
        finish([*study_arguments(folder), "--unlock"], folder)
    finish(target(folder), folder)
    for run in runs:
        if run.stem != "yield_acceleration":
            same_files(folder / run, reference / run)
    left, right = (read_study(f / RESULTS / "study.nc").drop_vars(TIMINGS) for f in (folder, reference))
    same_variables(left, right)
    leftovers = [str(path.relative_to(folder)) for path in (folder / RESULTS).rglob(".*")]
    assert not leftovers, leftovers
    return hit


# ---------------------------------------------------------------- the campaign


def kill_runs(folder: Path, instants: random.Random, wanted: int) -> None:
    """Kill single runs, some of them stages, and print where the kills hit and what they cost."""
    references = {until: uninterrupted(folder / "reference" / until, until) for until in ("end", "first_failure")}
    kills: list[Kill] = []
    runs = 0
    while len(kills) < wanted:
        until = "first_failure" if runs % 4 == 3 else "end"
        reference, takes = references[until]
        kills += killed_run(folder / f"run{runs}", reference, until, instants, 1.1 * takes, min(5, wanted - len(kills)))
        runs += 1
    print(f"{len(kills)} kills in {runs} runs, all finished with the same bits; uninterrupted {references['end'][1]:.1f} s")
    for hit, number in Counter(kill.hit for kill in kills).most_common():
        print(f"{number:5d}  {hit}")
    lost = [kill.lost for kill in kills if kill.lost]
    print(f"lost since the last checkpoint (every {CHECKPOINT} s): median {statistics.median(lost):.2f} s, largest {max(lost):.2f} s")


def kill_studies(folder: Path, instants: random.Random, wanted: int) -> None:
    """Kill Snakemake with its jobs, every other time in measuring."""
    for name in ("compiling", "reference"):
        reference = study_folder(folder / name)
        began = time.monotonic()
        finish(target(reference), reference)
    takes = time.monotonic() - began
    made = studies = 0
    while made < wanted:
        last_step = made % 2 == 1
        after = instants.uniform(0.0, LAST_STEP if last_step else takes)
        made += killed_study(folder / f"study{studies}", reference, after, last_step)
        studies += 1
    print(f"{made} kills of Snakemake with its jobs in {studies} studies, all finished with the same bits; uninterrupted {takes:.1f} s")


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--kills", type=int, default=200, help="of single runs")
    options.add_argument("--studies", type=int, default=20, help="kills of Snakemake with its jobs, every other one in measuring")
    options.add_argument("--seed", type=int, default=1)
    chosen = options.parse_args()
    for kill, wanted in ((kill_runs, chosen.kills), (kill_studies, chosen.studies)):
        with tempfile.TemporaryDirectory() as folder:
            if wanted:
                kill(Path(folder), random.Random(chosen.seed), wanted)


if __name__ == "__main__":
    main()
