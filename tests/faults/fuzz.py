"""Fuzz everything that a user can write: ``python tests/faults/fuzz.py --examples 10000``.

Scenes, studies, experiments, suites, changes, ground motions, options and files of every kind go through the functions behind the command
and the workflow.  An example passes if it is carried out, a few time steps of its solver included, or refused by a ValueError that
names a key or the file.  Anything else is printed with its example, and the exit code is 1.

The solver runs interpreted, since compiling each combination of terms would take 20 s.
"""

from __future__ import annotations

import argparse
import functools
import os
import re
import signal
import sys
import tempfile
import traceback
import warnings
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from unittest import mock

if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
    os.environ["NUMBA_DISABLE_JIT"] = "1"

import yaml
from configurations import changed, keys, section
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st
from inputs import (
    ASSUMPTIONS,
    COST_ACCURACY,
    FREE,
    MODELS,
    SCENES,
    SENSITIVITY,
    STUDY,
    TINY,
    TRIGGER,
    broken,
    comma_separated,
    lines,
    records,
    surveys,
)
from small_scenes import study_plan
from typer.testing import CliRunner

from sph.command.cli import app
from sph.experiments.paper.design import AnyStudy
from sph.experiments.registry import load_study
from sph.experiments.sensitivity.design import load_sensitivity
from sph.experiments.sensitivity.schema import Sensitivity
from sph.experiments.trigger.design import SEARCHED, load_trigger
from sph.experiments.trigger.schema import Trigger
from sph.experiments.variants.advice import shipped_table
from sph.experiments.variants.design import load_variants
from sph.experiments.variants.schema import Assumptions, CostAccuracy, Variants
from sph.experiments.variants.table import summary
from sph.scene.loading import motion_of
from sph.scene.schema import Scene, load_scene, make_scene
from sph.solver.run import Run
from sph.stability.search import Trial
from sph.stability.standing import FailureRule

ROOT = Path(__file__).resolve().parents[2]
SECONDS = 600
"""Longest time an example may take, compiling on a busy machine included."""
STEPS = 3
FEW, MANY = 400, 200_000
"""Particles up to which a scene is run for some steps, and up to which it is shown."""

PLAIN = settings(deadline=None, database=None, derandomize=True, phases=[Phase.generate], suppress_health_check=list(HealthCheck))
LADDER = shipped_table()
RUNGS = [] if LADDER is None else summary(LADDER)
"""What every scene is compared with to tell its error, put together once."""
WORDS = {name for model in MODELS.values() for path, _ in keys(model) for name in path} | {
    "amplitude",
    "S_R",
    "case",
    "variant",
    "level",
    "tolerance",
}
READING = (
    "--",
    ", line ",
    ", lines ",
    "cannot be read",
    "must hold a mapping",
    "Keys should be strings",
    "raw data as a unicode",
    "there is no such key",
)


class Tally:
    """What became of the examples."""

    def __init__(self) -> None:
        self.outcomes: Counter[tuple[str, str]] = Counter()
        self.failures: dict[str, str] = {}

    def add(self, kind: str, outcome: str) -> None:
        """Count an example, of its kind and of all."""
        self.outcomes.update([(kind, outcome), ("all", outcome)])

    def refuse(self, kind: str, message: str, example: Any) -> None:
        """Count a refusal; one that names no key is a failure."""
        if message.strip() and (WORDS.intersection(re.findall(r"[A-Za-z_]+", message)) or any(words in message for words in READING)):
            self.add(kind, "refused")
        else:
            self.fail(kind, f"a message that names no key: {message}", example)

    def fail(self, kind: str, what: str, example: Any) -> None:
        """Count a failure, and keep the first of each sort."""
        self.add(kind, "FAILED")
        self.failures.setdefault(f"{kind}: {what[-900:]}", repr(example)[:3000])

    def __str__(self) -> str:
        lines = [f"{count:7,}  {kind:<11} {outcome}" for (kind, outcome), count in self.outcomes.items()]
        return "\n".join(lines + [f"FAILURE {what}\n  with {example}" for what, example in self.failures.items()])


@contextmanager
def in_time() -> Iterator[None]:
    """Raise TimeoutError where an example takes too long."""

    def stop(*_: Any) -> None:
        raise TimeoutError(f"longer than {SECONDS} s")

    signal.signal(signal.SIGALRM, stop)
    signal.alarm(SECONDS)
    try:
        yield
    finally:
        signal.alarm(0)


def judge(tally: Tally, kind: str, example: Any, work: Callable[[], str]) -> None:
    """Carry out an example and count what became of it; ``work`` returns its outcome."""
    try:
        with in_time():
            tally.add(kind, work())
    except ValueError as error:
        tally.refuse(kind, str(error), example)
    except (Exception, SystemExit):
        tally.fail(kind, traceback.format_exc(limit=-4), example)


def call(*arguments: object) -> str:
    """Call the command; ValueError where it refuses, its exception where it fails."""
    result = CliRunner().invoke(app, [str(argument) for argument in arguments])
    if result.exception is not None and not isinstance(result.exception, SystemExit):
        raise RuntimeError("the command failed") from result.exception
    if result.exit_code == 2:
        raise ValueError(result.stderr)
    if result.exit_code not in (0, 3):
        raise RuntimeError(f"exit code {result.exit_code}: {result.output}")
    return result.stdout


def write(path: Path, data: Any) -> Path:
    """Data as YAML, or a text as it is."""
    path.write_text(data if isinstance(data, str) else _dumped(data), encoding="utf-8", errors="surrogateescape")
    return path


def _dumped(data: Any) -> str:
    try:
        return yaml.safe_dump(data)
    except ValueError:  # an integer of more digits than Python writes
        return "name: " + "9" * 5000


def scene(data: Any, folder: Path) -> str:
    """Show a scene, place it, and make a few steps."""
    path = write(folder / "scene.yaml", data)
    loaded = load_scene(path)
    columns, rows = loaded.lattice
    if columns * rows > MANY:
        return "accepted, too large to run here"
    with warnings.catch_warnings(), mock.patch("sph.experiments.variants.advice.summary", lambda _: RUNGS):
        warnings.simplefilter("error")
        call("info", path)
        call("check", path)
        if loaded.steps(loaded.duration) < MANY:
            motion_of(loaded)
    if columns * rows > FEW or loaded.walls.layers * (columns + rows) > FEW:
        return "accepted, shown"
    warnings.simplefilter("ignore")
    with mock.patch("sph.solver.simulation.FIRST_POWER_ITERATIONS", STEPS):
        first_steps(loaded)
    return "accepted, run"


def first_steps(loaded: Scene) -> None:
    """Make the first steps of a run, as ``Run.go`` does."""
    run = Run(loaded)
    run.simulation.prepare()
    if loaded.gravity.initial_stress != "none":
        run.simulation.balance()
    run._adapt()
    run.simulation.advance_steps(min(STEPS, loaded.steps(loaded.duration)))
    run._record()


def study(data: Any, folder: Path) -> str:
    """Load a study; its results stay where they belong."""
    plan = load_study(write(folder / "study.yaml", data), [folder])
    _stays(plan.folder, "results")
    rows = {run.file: run for run in plan.shared}
    for run in rows.values():
        _stays(run.file, f"{plan.folder}/{run.place}")
        assert run.parent is None or rows[run.parent].kind in ("gravity", "pre_failure")
    assert len(plan.layout.names) == len(set(plan.layout.names))
    return "accepted"


def variants(name: str, keys: type[Variants], data: Any, folder: Path) -> str:
    """Load a scene in variants; every run has a file of its own in its folder."""
    write(folder / f"{name}.yaml", data)
    found = load_variants(name, keys, f"{name}.yaml", study_plan(STUDY["fidelities"]), [folder])
    assert {*found.runs} == {run for row in found.rows for run in row.runs}, "runs of no row"
    for run in found.runs:
        _stays(f"results/{name}/runs/{run}.nc", f"results/{name}/runs")
    return "accepted"


def sensitivity(data: Any, folder: Path) -> str:
    """Load an analysis; every run has a file of its own in its folder."""
    write(folder / "sensitivity.yaml", data)
    plan = load_sensitivity("sensitivity.yaml", load_study(STUDY, [folder]), [folder])
    chosen = [axis.name for axis in plan.axes]
    for design in ("morris", "tornado", "sobol", "confirm"):
        for run in plan.rows(design, chosen):
            _stays(run.file, f"results/s/a/sensitivity/runs/{design}")
            make_scene(run.scene)
    return "accepted"


def trigger(data: Any, folder: Path) -> str:
    """Load searches; stages and runs of every case stay where they belong, and no two points of a search have one name."""
    write(folder / "trigger.yaml", data)
    plan = load_trigger("trigger.yaml", load_study(STUDY, [folder]), [folder])
    assert len(set(plan.folders.values())) == len(plan.plans)
    for place in plan.plans:
        _stays(place, "results")
    for search in SEARCHED.values() if plan.trigger.maps else ["trigger"]:
        for lattice in plan.lattices(search):
            for name, span in lattice.spans.items():
                steps = range(span.cells * 2 ** plan.levels(search) + 1)
                labels = {lattice.label(name, span.value(step / 2 ** plan.levels(search))) for step in steps[:: max(1, len(steps) // 50)]}
                assert len(labels) == len(steps[:: max(1, len(steps) // 50)]), "two points with one name"
    return "accepted"


def _stays(path: str, folder: str) -> None:
    whole = Path("/study").joinpath(path)
    assert Path(os.path.normpath(whole)) == whole and whole.is_relative_to(f"/study/{folder}"), f"{path} leaves {folder}"
    assert all(0 < len(part.encode()) <= 250 for part in whole.parts) and path.isprintable(), f"{path[:80]} is no file name"


def record(example: tuple[str, str], folder: Path) -> str:
    """Slide a block on a record, and measure it."""
    ending, text = example
    path = folder / f"record.{ending}"
    path.write_text(text, encoding="utf-8", errors="surrogateescape")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        shown = call("newmark", path, "--ay", "0.1 m/s2", "--upslope", "0.3 m/s2", "--json") + call("motion", path, "--json")
    assert "NaN" not in shown and "Infinity" not in shown, shown
    return "accepted"


def survey(text: str, folder: Path) -> str:
    """Look at a scene whose ground is in a file."""
    (folder / "ground").write_text(text, encoding="utf-8", errors="surrogateescape")
    ground = {"shape": "ground_line", "file": "ground", "base": -1100.0}
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        call("check", write(folder / "survey.yaml", TINY | {"geometry": ground, "numerics": TINY["numerics"] | {"spacing": 5.0}}))
    return "accepted"


def line(arguments: list[str], folder: Path) -> str:
    """A command line; searches are answered without simulating."""
    tiny = write(folder / "tiny.yaml", SCENES[1])
    (folder / "record.csv").write_text("t,a (m/s2)\n0,5.886\n0.2,5.886\n")
    places = {"SCENE": str(tiny), "RECORD": str(folder / "record.csv"), "FOLDER": str(folder)}

    def stand(_scene: Scene, _rule: FailureRule, value: float) -> Trial:
        return Trial(value, value < 1.3, 0.0, 0.0, "complete", 0.0)

    with mock.patch("sph.stability.safety.stand", stand), warnings.catch_warnings():
        warnings.simplefilter("error", RuntimeWarning)
        call(*(places.get(argument, argument) for argument in arguments))
    return "accepted"


EXAMPLES: dict[str, tuple[int, Callable[[Any, Path], str], st.SearchStrategy[Any]]] = {
    "scene": (
        50,
        scene,
        st.one_of([changed(Scene, base, most) for base in SCENES for most in (1, 2, 4)] + [section(Scene), broken(SCENES[1])]),
    ),
    "study": (8, study, st.one_of([changed(AnyStudy, base, most) for base in (STUDY, STUDY, *FREE) for most in (1, 3)] + [broken(STUDY)])),
    "cost-accuracy": (
        6,
        functools.partial(variants, "cost-accuracy", CostAccuracy),
        st.one_of(changed(CostAccuracy, COST_ACCURACY, 1), changed(CostAccuracy, COST_ACCURACY), broken(COST_ACCURACY)),
    ),
    "assumptions": (
        6,
        functools.partial(variants, "assumptions", Assumptions),
        st.one_of(changed(Assumptions, ASSUMPTIONS, 1), changed(Assumptions, ASSUMPTIONS), broken(ASSUMPTIONS)),
    ),
    "sensitivity": (
        5,
        sensitivity,
        st.one_of(changed(Sensitivity, SENSITIVITY, 1), changed(Sensitivity, SENSITIVITY), broken(SENSITIVITY)),
    ),
    "trigger": (5, trigger, st.one_of(changed(Trigger, TRIGGER, 1), changed(Trigger, TRIGGER), broken(TRIGGER))),
    "record": (9, record, records),
    "survey": (9, survey, st.one_of(surveys, comma_separated)),
    "line": (10, line, lines.map(list)),
}
"""Share in per cent, what is done and examples of each kind."""


def fuzz(examples: int) -> Tally:
    """Try that many examples, the same every time."""
    tally = Tally()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        write(folder / "tiny.yaml", SCENES[1])
        os.chdir(folder)
        os.environ["SPH_CACHE_DIR"] = name  # nothing is compiled: no need to wait for those who do
        for kind in EXAMPLES:
            fuzz_kind(kind, max(1, examples * EXAMPLES[kind][0] // 100), tally, folder)
        os.chdir(ROOT)
    return tally


def fuzz_kind(kind: str, examples: int, tally: Tally, folder: Path) -> None:
    """Try examples of one kind."""
    _, work, strategy = EXAMPLES[kind]
    plain = settings(PLAIN, max_examples=examples)

    @plain
    @given(strategy)
    def each(example: Any) -> None:
        judge(tally, kind, example, lambda: work(example, folder))

    each()


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--examples", type=int, default=10_000)
    result = fuzz(parser.parse_args().examples)
    print(result)
    sys.exit(bool(result.failures))
