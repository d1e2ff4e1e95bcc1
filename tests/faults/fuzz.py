"""Fuzz everything that a user can write: ``python tests/faults/fuzz.py --examples 10000``.

Scenes, studies, ladders, suites, changes, ground motions, options and files of every kind go through the functions behind the command
and the workflow.  An example passes if it is carried out, a few time steps of its solver included, or refused by a ValueError that
names a key or the file.  Anything else is printed with its example, and the exit code is 1.

The solver runs interpreted, since compiling each combination of terms would take 20 s; with ``--compiled`` it runs compiled, for
scenes with the terms of one of ``SCENES`` only.
"""

from __future__ import annotations

import argparse
import os
import re
import signal
import sys
import tempfile
import traceback
import warnings
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from unittest import mock

if __name__ == "__main__" and "--compiled" not in sys.argv:
    os.environ["NUMBA_DISABLE_JIT"] = "1"

import numba
import numpy as np
import yaml
from configurations import HARD_NUMBERS, HARD_TEXTS, changed, junk, keys, section
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st
from typer.testing import CliRunner

from sph.analysis.advice import shipped_table
from sph.analysis.limits import Limits, load_limits
from sph.analysis.sensitivity import Sensitivity, load_sensitivity
from sph.analysis.study import Study, load_study
from sph.analysis.trade import Trade, load_trade
from sph.analysis.trade_table import summary
from sph.analysis.trigger import SEARCHED, Trigger, load_trigger
from sph.command.cli import app
from sph.configuration import merge
from sph.ground_motion import motion_of
from sph.scene import Scene, load_scene, make_scene
from sph.solver import Run, wanted_terms
from sph.stability.search import Trial
from sph.stability.standing import FailureRule
from sph.validation.suite import Validation, load_suite

ROOT = Path(__file__).resolve().parents[2]
SECONDS = 600
"""Longest time an example may take, compiling on a busy machine included."""
STEPS = 3
FEW, MANY = 400, 200_000
"""Particles up to which a scene is run for some steps, and up to which it is shown."""

TINY: dict[str, Any] = {
    "name": "tiny",
    "duration": 0.02,
    "geometry": {"shape": "block", "width": 4.0, "height": 3.0},
    "gravity": {"ramp": 0.0, "duration": 0.01},
    "numerics": {"spacing": 1.0, "smoothing_ratio": 1.3, "time_step": 1e-4},
    "outputs": {"frame_interval": 0.01, "series_interval": 0.01},
}
SLOPE = {"shape": "slope", "slope_angle": 45.0, "slope_height": 4.0, "base_depth": 2.0, "apron_length": 3.0, "crest_length": 3.0}
BODIES = {
    "shape": "bodies",
    "width": 6.0,
    "height": 4.0,
    "bodies": [
        {"kind": "polygon", "points": [[0.0, 0.0], [3.0, 0.0], [0.0, 3.0]]},
        {"kind": "ring", "centre": [4.0, 2.0], "outer_radius": 1.5, "inner_radius": 0.5},
    ],
}
GROUND = {"shape": "ground_line", "points": [[10.0, 102.0], [13.0, 102.0], [16.0, 105.0], [19.0, 105.0]], "base": 100.0}
SCENES = [
    TINY,
    TINY | {"geometry": SLOPE, "motion": {"kind": "tapered_sine", "start": 0.01, "ramp": 0.0, "decay_start": 0.02, "end": 0.02}},
    TINY | {"geometry": GROUND, "motion": {"kind": "ricker", "amplitude": 1.0, "frequency": 300.0, "peak": 0.015}},
    TINY
    | {
        "layers": {
            "cover": {"region": {"kind": "depth", "bottom": 1.0}, "soil": {"cohesion": 5.0}, "S_R": 0.1},
            "rock": {"region": {"kind": "elevation", "top": 1.0}, "soil": {"density": 2600.0}},
            "lens": {"region": {"kind": "polygon", "points": [[0.0, 0.0], [1.5, 0.0], [0.0, 2.5]]}, "gamma": 2.0},
        }
    },
    TINY
    | {
        "motion": {
            "kind": "record",
            "start": 0.01,
            "amplitude": 2.0,
            "vertical": {"factor": 0.5},
            "baseline": {},
            "band_pass": {"low": 1.0, "high": 20.0},
            "trim": {"taper": 0.01},
            "resample": {"interval": 0.02},
            "data": {"interval": 0.01, "x": [0.0, 1.0, -2.0, 1.0, 0.5, 0.0], "y": [0.0, 1.0, 0.0, -1.0, 0.0, 0.0]},
        }
    },
    TINY
    | {"geometry": BODIES, "walls": {"base": "free_slip", "sides": "free_slip", "friction": {"base": 0.3}}, "early_stop": {"window": 0.01}},
    TINY
    | {
        "geometry": SLOPE,
        "walls": {
            "base": "absorbing",
            "sides": "absorbing",
            "bedrock": {"density": 2e3, "s_wave_speed": 1e3, "p_wave_speed": 2e3},
        },
    },
    merge(
        TINY,
        {
            "walls": {"base": "none", "sides": "periodic"},
            "geometry": {"width": 8.0},
            "coupling": {"initial_state": "fluid", "fluid": {"law": "capped_viscosity", "max_viscosity": 1e3}},
            "motion": {"kind": "constant", "amplitude": 1.0, "start": 0.01, "ramp": 0.0},
            "initial_velocity": {"along": "y", "position": [0.0, 2.0], "x": [0.0, 2.0], "y": [1.0, 1.0]},
            "prescribed_velocity_gradient": {"xy": 1.0},
            "numerics": {
                "adaptive_step": {},
                "artificial_stress": {},
                "gradient_correction": {},
                "kernel": "wendland_c2",
                "precision": "double",
            },
        },
    ),
]
STUDY = {
    "study": "s",
    "scene": "tiny.yaml",
    "fidelity": "a",
    "grid": {"S_R": ["0.1", "0.25"], "gamma": [1], "amplitude": ["6.0"]},
    "fidelities": {"a": {}, "b": {"numerics": {"spacing": 0.5}}},
    "figures": {"strengths": ["0.1"], "gamma": "1", "compared_gammas": ["1"], "compared_strengths": ["0.25"]},
}
ANY = {name: value for name, value in STUDY.items() if name not in ("grid", "figures")}
FREE = [
    ANY | {"grid": {"S_R": ["0.1", "0.25"], "soil.cohesion": [20, "150"], "numerics.kernel": ["cubic_spline", "wendland_c2"]}},
    ANY | {"cases": [{"S_R": "0.1", "walls.layers": 2}, {"S_R": 0.25, "walls.layers": "3"}], "figures": {"runs": ["case-000002"]}},
    ANY | {"sample": {"method": "random", "size": 5, "ranges": {"S_R": [0.1, 0.5], "soil.cohesion": {"bounds": [1, 9], "scale": "log"}}}},
]
"""Studies over other dimensions than the paper's."""
TRADE = {
    "scene": "tiny.yaml",
    "cases": {"weak": {"coupling": {"S_R": 0.1}}, "strong": {"coupling": {"S_R": 0.5}}},
    "timed_case": "weak",
    "reference": {"knob": "spacing", "rung": "1 m"},
    "baseline": "a",
    "knobs": {
        "spacing": {"about": "x", "rungs": {"1 m": {}, "0.5 m": {"numerics": {"spacing": 0.5}}}, "exceptions": {"0.5 m": {"repeats": 1}}}
    },
}
LIMITS = {"scene": "tiny.yaml", "cases": {"weak": {}}, "changes": {"as it is": {}, "S_R 0.1": {"coupling": {"S_R": 0.1}}}}
SENSITIVITY = {
    "factors": {
        "S_R": {"keys": {"coupling.S_R": 1.0}, "bounds": [0.1, 0.5]},
        "height": {"keys": {"geometry.slope_height": 1.0, "geometry.apron_length": 0.75}, "bounds": [3.0, 5.0], "scale": "log"},
    },
    "metrics": {"displacement_magnitude": {"log_offset": 0.01}, "runout": {}},
    "morris": {"trajectories": 2},
    "sobol": {"samples": 8},
    "confirm": {"fidelity": "b", "points": 2},
}
TRIGGER = {
    "cases": {"as it is": {}, "slip": {"walls": {"sides": "free_slip", "layers": 8}}},
    "amplitude": {"lowest": 1.0, "highest": 8.0, "cells": 2},
    "tolerance": 0.5,
    "S_R": ["0.1", 0.25],
    "gamma": [1],
    "confirm": {"fidelity": "b", "S_R": ["0.1"], "gamma": [1], "cases": ["slip"]},
    "maps": {
        "cases": ["slip"],
        "S_R": {"lowest": 0.1, "highest": 0.5, "cells": 1},
        "gamma": {"lowest": 1, "highest": 100, "cells": 1, "scale": "logarithmic"},
    },
}
VALIDATION = {
    "cases": {
        "V1": {
            "title": "t",
            "scene": "tiny.yaml",
            "source": "s",
            "levels": {"1 m": {}, "0.5 m": {"numerics": {"spacing": 0.5}}},
            "quantities": {"q": {"tolerance": 0.1, "coarse": 0.2, "reason": "r"}},
        }
    }
}
MODELS = {
    "scene": Scene,
    "study": Study,
    "trade": Trade,
    "limits": Limits,
    "sensitivity": Sensitivity,
    "trigger": Trigger,
    "validation": Validation,
    "rule": FailureRule,
}
LADDER = shipped_table()
RUNGS = [] if LADDER is None else summary(LADDER)
"""What every scene is compared with to tell its error, put together once."""
WORDS = {name for model in MODELS.values() for path, _ in keys(model) for name in path} | {
    "amplitude",
    "S_R",
    "case",
    "rung",
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
        self.refused: Counter[str] = Counter()
        self.failures: dict[str, str] = {}

    def add(self, kind: str, outcome: str) -> None:
        """Count an example."""
        self.outcomes[kind, outcome] += 1

    def refuse(self, kind: str, message: str, example: Any) -> None:
        """Count a refusal by the key it names; one that names none is a failure."""
        named = [word for word in re.findall(r"[A-Za-z_]+", message) if word in WORDS]
        if not message.strip() or not named and not any(words in message for words in READING):
            self.fail(kind, f"a message that names no key: {message}", example)
        else:
            self.add(kind, "refused")
            key = re.search(r"(?:\.yaml|config|tiny|--\w+)[^:]*: ([\w.]+):", message)
            self.refused[re.sub(r"\.\d+", "[]", key[1]) if key else named[0] if named else "file"] += 1

    def fail(self, kind: str, what: str, example: Any) -> None:
        """Count a failure, and keep the first of each sort."""
        self.add(kind, "FAILED")
        self.failures.setdefault(f"{kind}: {what[-900:]}", repr(example)[:3000])

    def __str__(self) -> str:
        lines = [f"{count:7,}  {kind:<11} {outcome}" for (kind, outcome), count in sorted(self.outcomes.items())]
        total = Counter[str]()
        for (_, outcome), count in self.outcomes.items():
            total[outcome] += count
        lines += [f"{count:7,}  {'all':<11} {outcome}" for outcome, count in sorted(total.items())]
        lines += ["refused by key:", *(f"{count:7,}  {key}" for key, count in self.refused.most_common())]
        for what, example in self.failures.items():
            lines += ["FAILURE " + what, "  with " + example]
        return "\n".join(lines)


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
    with warnings.catch_warnings(), mock.patch("sph.analysis.advice.summary", lambda _: RUNGS):
        warnings.simplefilter("error")
        call("info", path)
        call("check", path)
        if loaded.steps(loaded.duration) < MANY:
            motion_of(loaded)
    if columns * rows > FEW or loaded.walls.layers * (columns + rows) > FEW:
        return "accepted, shown"
    if not numba.config.DISABLE_JIT and variant(loaded) not in map(variant, map(make_scene, SCENES)):
        return "accepted, not compiled"
    warnings.simplefilter("ignore")
    with mock.patch("sph.solver.FIRST_TURNS", STEPS):
        first_steps(loaded)
    return "accepted, run"


def variant(loaded: Scene) -> tuple[object, ...]:
    """What decides which code a scene compiles."""
    return *wanted_terms(loaded), loaded.numerics.precision


def first_steps(loaded: Scene) -> None:
    """Make the first steps of a run, as ``Run.go`` does."""
    run = Run(loaded)
    run.prepare()
    if loaded.gravity.initial_stress != "none":
        run.balance()
    run._adapt()
    run.advance_steps(min(STEPS, loaded.steps(loaded.duration)))
    run._record()


def study(data: Any, folder: Path) -> str:
    """Load a study; its results stay where they belong."""
    plan = load_study(write(folder / "study.yaml", data), [folder])
    _stays(plan.folder, "results")
    for name in (*plan.study.runs, *plan.gravities, *plan.trunks):
        _stays(f"{plan.folder}/runs/{name}.nc", f"{plan.folder}/runs")
    for name in plan.study.runs:
        assert plan.gravity_of(plan.stages(name).trunk) == plan.stages(name).gravity
    assert len(plan.layout.names) == len(set(plan.layout.names))
    return "accepted"


def trade(data: Any, folder: Path) -> str:
    """Load a ladder; every run has a file of its own in its folder."""
    write(folder / "trade.yaml", data)
    for name in load_trade("trade.yaml", STUDY["fidelities"], [folder]).runs:
        _stays(f"results/trade/runs/{name}.nc", "results/trade/runs")
    return "accepted"


def limits(data: Any, folder: Path) -> str:
    """Load changes; every run has a file of its own in its folder."""
    write(folder / "limits.yaml", data)
    found = load_limits("limits.yaml", [folder])
    assert len(found.runs) == len(found.rows), "two runs with one file"
    for name in found.runs:
        _stays(f"results/limits/runs/{name}.nc", "results/limits/runs")
    return "accepted"


def sensitivity(data: Any, folder: Path) -> str:
    """Load an analysis; every run has a file of its own in its folder."""
    write(folder / "sensitivity.yaml", data)
    plan = load_sensitivity("sensitivity.yaml", load_study(STUDY, [folder]), [folder])
    chosen = [axis.name for axis in plan.axes]
    for design in ("morris", "tornado", "sobol", "confirm"):
        for run in plan.design(design, chosen):
            _stays(f"results/s/a/sensitivity/runs/{design}/{run}.nc", f"results/s/a/sensitivity/runs/{design}")
            make_scene(plan.scene(design, run, chosen))
    return "accepted"


def trigger(data: Any, folder: Path) -> str:
    """Load searches; stages and runs of every case stay where they belong, and no two points of a search have one name."""
    write(folder / "trigger.yaml", data)
    plan = load_trigger(load_study(STUDY | {"trigger": "trigger.yaml"}, [folder]), [folder])
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


def validation(data: Any, folder: Path) -> str:
    """Load a suite; every run has a file of its own in its folder."""
    write(folder / "validation.yaml", data)
    suite = load_suite("validation.yaml", [folder])
    assert len(suite.runs) == sum(len(case.runs) * len(case.levels) for case in suite.cases.values()), "two runs with one file"
    for name in suite.runs:
        _stays(f"results/validation/runs/{name}.nc", "results/validation/runs")
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
        shown = call("newmark", path, "--ay", "0.1", "--upslope", "0.3", "--json") + call("motion", path, "--json")
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
    (folder / "record.csv").write_text("0,5.886\n0.2,5.886\n")
    places = {"SCENE": str(tiny), "RECORD": str(folder / "record.csv"), "FOLDER": str(folder)}

    def stand(_scene: Scene, _rule: FailureRule, value: float) -> Trial:
        return Trial(value, value < 1.3, 0.0, 0.0, "complete", 0.0)

    with mock.patch("sph.stability.safety.stand", stand), warnings.catch_warnings():
        warnings.simplefilter("error", RuntimeWarning)
        call(*(places.get(argument, argument) for argument in arguments))
    return "accepted"


def text(value: Any) -> str:
    """A value as an argument of a command line."""
    try:
        return str(value).replace("\0", "")[:4000]
    except ValueError:
        return "9" * 5000


any_text = st.one_of(
    st.sampled_from([*map(text, HARD_NUMBERS), *(t.replace("\0", "") for t in HARD_TEXTS)]), st.text(max_size=12), junk.map(text)
).map(lambda t: t.encode("utf-8", "replace").decode().replace("\0", ""))
a_number = st.one_of(st.sampled_from(["1", "0.25g", "2.5", "1e-6", "0.1"]), st.floats(1e-6, 1.0).map(str), st.floats().map(str), any_text)
dotted_keys = st.sampled_from([".".join(map(str, path)) for path, _ in keys(Scene)])
a_good_setting = st.sampled_from(list(keys(Scene))).flatmap(
    lambda pair: pair[1].map(lambda value: f"{'.'.join(map(str, pair[0]))}={text(yaml.safe_dump(value, default_flow_style=True))}")
)
a_setting = st.one_of(a_good_setting, a_good_setting, st.tuples(dotted_keys, any_text).map("=".join), any_text)
a_rule = st.one_of(st.tuples(st.sampled_from(list(FailureRule.model_fields)), a_number).map("=".join), any_text)
a_file = st.sampled_from(["SCENE", "RECORD", "FOLDER", "/dev/null", "absent", "n" * 300, "/dev/zero/x", "-", ""])
lines = st.one_of(
    st.tuples(st.just("info"), st.just("SCENE"), st.just("--set"), a_setting),
    st.tuples(st.just("newmark"), st.just("SCENE"), st.just("--ay=1"), st.just("--set"), a_setting),
    st.tuples(st.just("newmark"), st.just("RECORD"), a_number.map("--ay={}".format), a_number.map("--scale-to={}".format)),
    st.tuples(
        st.just("newmark"), st.just("RECORD"), a_number.map("--ay={}".format), a_number.map("--upslope={}".format), st.just("--json")
    ),
    st.tuples(st.just("fos"), st.just("SCENE"), st.just("--rule"), a_rule, a_number.map("--tolerance={}".format)),
    st.tuples(st.just("fos"), st.just("SCENE"), any_text.map("--reduce={}".format), st.just("--rule=displacement=0.5")),
    st.tuples(st.just("yield-acceleration"), st.just("SCENE"), st.just("--rule=displacement=0.5"), st.just("--rule"), a_rule),
    st.tuples(st.just("advise"), a_number.map("--error={}".format), any_text.map("--quantity={}".format)),
    st.tuples(st.just("advise"), a_number.map("--error={}".format), any_text.map("--of={}".format)),
    st.tuples(st.just("advise"), st.just("--error=0.2"), a_file.map("--table={}".format)),
    st.tuples(st.sampled_from(["plot", "metrics", "info"]), a_file),
    st.tuples(st.just("newmark"), a_file, st.just("--ay=1")),
    st.tuples(st.just("run"), st.just("SCENE"), a_file.map("--restart={}".format)),
    st.tuples(st.just("run"), st.just("SCENE"), any_text.map("--until={}".format)),
    st.tuples(
        st.just("run"),
        st.just("SCENE"),
        st.sampled_from(["FOLDER", "/", "absent/x.nc", "/dev/null/x.nc", "n" * 300]).map("--out={}".format),
    ),
    st.tuples(st.just("run"), st.just("SCENE"), st.just("--until=x"), any_text.map("--threads={}".format)),
    st.tuples(st.just("reference"), any_text),
)
cells = st.one_of(st.floats(-1e3, 1e3).map(str), st.sampled_from(list(map(text, HARD_NUMBERS))), st.text(max_size=5))
rising = st.lists(st.tuples(st.floats(1e-9, 10.0), st.floats(-1e3, 1e3)), min_size=2, max_size=20).map(
    lambda rows: "\n".join(f"{t},{a}" for t, a in zip(np.cumsum([row[0] for row in rows]).tolist(), [row[1] for row in rows], strict=True))
)
PEER = "A\nB\nACCELERATION TIME SERIES IN UNITS OF G\nNPTS= 7, DT= .01 SEC\n .1E-1 -.2E-1 .3E+0 -.1E-5 0.0\n .1E-1 -.2E-1\n"
SMC = "\n".join(
    ["2 CORRECTED ACCELEROGRAM", *["*"] * 10]
    + [f"{0:10d}" * 7 + f"{1:10d}" if line == 1 else f"{4 if line == 2 else 0:10d}" + f"{0:10d}" * 7 for line in range(6)]
    + ["".join(f"{100.0 if line == 0 and at == 1 else 0.0:15.7E}" for at in range(5)) for line in range(10)]
    + ["| comment", "   -1.0000   20.0000  -30.00001000.00000"]
)
KNET = """Origin Time       2000/01/01 00:00:00
Lat.              38.920
Long.             140.630
Depth. (km)       7
Mag.              5.9
Station Code      AKT013
Station Lat.      39.6069
Station Long.     140.3213
Station Height(m) 34
Record Time       2000/01/01 00:00:39
Sampling Freq(Hz) 4Hz
Duration Time(s)  1
Dir.              E-W
Scale Factor      2000(gal)/8388608
Max. Acc. (gal)   4.383
Last Correction   2000/01/01 00:00:00
Memo.
   1800000  -1700000    10000         0
"""
comma_separated = st.one_of(
    rising,
    st.lists(st.lists(cells, min_size=1, max_size=3).map(",".join), max_size=6).map("\n".join),
    st.lists(st.tuples(st.floats(), st.floats()).map(lambda row: f"{row[0]},{row[1]}"), min_size=2, max_size=5).map("\n".join),
    st.text(max_size=60),
)


def broken(base: Mapping[str, Any] | str) -> st.SearchStrategy[str]:
    """A text, that of a mapping as YAML, with a piece cut out and something put in."""
    whole = base if isinstance(base, str) else yaml.safe_dump(base)
    inserted = st.one_of(
        st.text(max_size=5),
        st.sampled_from(["&a ", "*a", "<<: ", "!!bool ", "\t", "? ", "- ", "{", "[" * 2000, "'", "|", "%", "2001-99-99"]),
    )
    return st.tuples(st.integers(0, len(whole)), st.integers(0, 10), inserted).map(
        lambda cut: whole[: cut[0]] + cut[2] + whole[cut[0] + cut[1] :]
    )


surveys = st.one_of(
    broken("x,y\n120,440\n150,440\n170,465\n200,465\n"),
    broken("LINESTRING Z (0 0 440, 30 0 440, 50 0 465, 80 0 465)"),
    broken('{"type": "Feature", "properties": {}, "geometry": {"type": "LineString", "coordinates": [[0, 440], [30, 440], [50, 465]]}}'),
)

records = st.one_of(
    st.tuples(st.just("csv"), comma_separated),
    *(st.tuples(st.just(ending), st.one_of(st.just(text), broken(text))) for ending, text in (("at2", PEER), ("smc", SMC), ("EW", KNET))),
)
EXAMPLES: dict[str, tuple[int, Callable[[Any, Path], str], st.SearchStrategy[Any]]] = {
    "scene": (
        50,
        scene,
        st.one_of([changed(Scene, base, most) for base in SCENES for most in (1, 2, 4)] + [section(Scene), broken(SCENES[1])]),
    ),
    "study": (8, study, st.one_of([changed(Study, base, most) for base in (STUDY, STUDY, *FREE) for most in (1, 3)] + [broken(STUDY)])),
    "trade": (6, trade, st.one_of(changed(Trade, TRADE, 1), changed(Trade, TRADE), broken(TRADE))),
    "limits": (6, limits, st.one_of(changed(Limits, LIMITS, 1), changed(Limits, LIMITS), broken(LIMITS))),
    "sensitivity": (
        5,
        sensitivity,
        st.one_of(changed(Sensitivity, SENSITIVITY, 1), changed(Sensitivity, SENSITIVITY), broken(SENSITIVITY)),
    ),
    "trigger": (5, trigger, st.one_of(changed(Trigger, TRIGGER, 1), changed(Trigger, TRIGGER), broken(TRIGGER))),
    "validation": (6, validation, st.one_of(changed(Validation, VALIDATION, 1), changed(Validation, VALIDATION), broken(VALIDATION))),
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
        if numba.config.DISABLE_JIT:
            os.environ["SPH_CACHE_DIR"] = name  # nothing is compiled: no need to wait for those who do
        for kind in EXAMPLES:
            fuzz_kind(kind, max(1, examples * EXAMPLES[kind][0] // 100), tally, folder)
            print(f"{kind} done", file=sys.stderr, flush=True)
        os.chdir(ROOT)
    return tally


def fuzz_kind(kind: str, examples: int, tally: Tally, folder: Path) -> None:
    """Try examples of one kind."""
    _, work, strategy = EXAMPLES[kind]
    plain = settings(
        max_examples=examples,
        deadline=None,
        database=None,
        derandomize=True,
        phases=[Phase.generate],
        suppress_health_check=list(HealthCheck),
    )

    @plain
    @given(strategy)
    def each(example: Any) -> None:
        judge(tally, kind, example, lambda: work(example, folder))

    each()


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--examples", type=int, default=10_000)
    parser.add_argument("--compiled", action="store_true", help="run the solver compiled")
    result = fuzz(parser.parse_args().examples)
    print(result)
    sys.exit(bool(result.failures))
