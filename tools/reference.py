"""Tables of every key, variable and command, made from their declarations, and of what was measured for this release.

``python -m tools.reference NAME`` prints a table.  A page of ``docs`` has that command in place of the table, which is made with the
site (``snakemake docs``) and not kept.  Those of ``README.md`` are kept, between marks, ``<!-- sph reference NAME -->`` and
``<!-- end -->``; without a name the command fills them again and writes the schemas in ``config/schemas``.  A test fails where one differs.
"""

from __future__ import annotations

import functools
import json
import math
import re
import subprocess
import sys
import typing
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

import pandas as pd
from pydantic import BaseModel
from pydantic.fields import FieldInfo

from cases.slow_sine import LIMIT
from cases.suite import SHIPPED_VALIDATION, VALIDATION, read_validation
from sph.checks.messages import MESSAGES, Message, Severity, meaning
from sph.command.new import ROWS
from sph.command.schema import MODELS, schema_file, schema_text
from sph.experiments.paper.design import AnyStudy
from sph.experiments.registry import EXPERIMENTS
from sph.experiments.sensitivity.back_analysis import BACK_ANALYSIS, MEASURED, PREDICTED
from sph.experiments.sensitivity.elementary_effects import MORRIS
from sph.experiments.sensitivity.schema import SAMPLE
from sph.experiments.sensitivity.surrogate import CROSS_VALIDATION, SOBOL
from sph.experiments.sensitivity.tables import CONFIRMED, TORNADO
from sph.experiments.trigger.annual import annual_columns
from sph.experiments.trigger.critical import confirm_columns, critical_columns
from sph.experiments.trigger.design import Searched
from sph.experiments.trigger.efficiency import MEASURE_COLUMNS
from sph.experiments.trigger.exceedance import exceedance_columns, width_columns
from sph.experiments.trigger.fragility import curve_columns, fit_columns
from sph.experiments.trigger.maps import cell_columns, share_columns
from sph.experiments.trigger.points import point_columns
from sph.experiments.variants import advice
from sph.experiments.variants.advice import percent
from sph.experiments.variants.assumptions import ASSUMPTIONS, read_assumptions
from sph.experiments.variants.assumptions import QUANTITIES as CHANGED
from sph.experiments.variants.convergence import CONVERGENCE
from sph.experiments.variants.figures_robustness import REFUSED
from sph.experiments.variants.robustness import ROBUSTNESS, read_robustness
from sph.experiments.variants.schema import FIDELITY, TIME_STEP, Variants
from sph.experiments.variants.second_spacing import spacing_columns
from sph.experiments.variants.table import COST_ACCURACY, Summary, summary
from sph.measures.places import place_columns
from sph.scene.configuration import flat, validated
from sph.scene.schema import Scene, load_scene
from sph.scene.scheme import NEEDED, RESOLVED
from sph.stability.standing import FailureRule
from sph.storage.trajectory import OPTIONAL, VARIABLES, Status, Variable
from sph.study.dimensions import SHORT_NAMES, dimension, named_sections, sections
from sph.study.machine import duration
from sph.study.preflight import PREFLIGHT
from sph.study.tables import VALUES
from sph.study.verdicts import HOLDS, MISSES, tally
from tools import shipped
from tools.levels import read_levels
from tools.release import BASELINE, READ_AT, STUDY_AT, read_measured
from tools.sliding_blocks import cause_rows, read_blocks, spread_rows
from tools.slow_sine import read_slow_sine


class Reference(NamedTuple):
    """A table: headings, rows and a note below; the first column holds names, as in the program."""

    head: Sequence[str]
    rows: Sequence[Sequence[str]]
    note: str = ""


class Strong(str):
    """A cell that is set in bold."""


TABLES: dict[str, Callable[[], Reference]] = {}
"""The tables by name."""
Lines = Iterator[tuple[str, ...]]
Rows = TypeVar("Rows", bound=Callable[[Any], Lines])


def table(name: str, head: str, of: Callable[[], Any] | None = None, note: Callable[[Any], str] = lambda _: "") -> Callable[[Rows], Rows]:
    """Make a function the rows of a table with headings, apart by bars, and a note, of what ``of`` reads: a table of the release."""
    read = of or functools.partial(read_measured, name)

    def made(rows: Rows) -> Rows:
        TABLES[name] = lambda: Reference(head.split(" | "), list(rows(data := read())), note(data))
        return rows

    return made


def _validation() -> pd.DataFrame:
    return read_validation(SHIPPED_VALIDATION)


def key_rows(model: type[BaseModel], prefix: str = "") -> Iterator[tuple[str, str, str, str, str, str]]:
    """Rows (key, unit, default, allowed, source, meaning), sections first, then what they hold."""
    for name, field in model.model_fields.items():
        extra = typing.cast(dict[str, Any], field.json_schema_extra or {})
        path = prefix + name
        yield path, extra["unit"], _default(field), _allowed(field), extra["source"], field.description or ""
        variants = sections(field.annotation)
        for section in variants:
            yield from key_rows(section, f"{path} ({_tag(section)})." if len(variants) > 1 else f"{path}.")
        for section in named_sections(field.annotation):
            yield from key_rows(section, f"{path}.<name>.")
        listed = sections(typing.get_args(field.annotation)[0]) if typing.get_origin(field.annotation) is tuple else []
        for section in listed:
            yield from key_rows(section, f"{path}[] ({_tag(section)})." if len(listed) > 1 else f"{path}[].")


def markdown(table: Reference) -> str:
    """A table and its note in Markdown; without rows the note alone."""
    lines = ["| " + " | ".join(table.head) + " |", "|" + " --- |" * len(table.head)]
    lines += ["| `" + first.replace("|", "\\|") + "` | " + " | ".join(map(_cell, cells)) + " |" for first, *cells in table.rows]
    return "\n\n".join(filter(None, ("\n".join(lines) if table.rows else "", table.note)))


def _cell(text: str) -> str:
    """Text of a cell: bars, lone asterisks and the beginnings of tags stand for themselves."""
    if isinstance(text, Strong):
        return f"**{_cell(str(text))}**"
    return re.sub(r"<(?=[A-Za-z/])", "&lt;", re.sub(r"(?<!\*)\*(?!\*)", r"\\*", text.replace("|", "\\|")))


def _measured(scheme: str = "paper") -> Reference:
    """Table of the shipped cost-accuracy study of a scheme with the machine as its note; without rows while there is none."""
    head = ("variant", "particle-steps/s", "one run", "A's displacement within", "run-out within", "same class as the reference")
    table = advice.shipped_table(scheme)
    if table is None:
        return Reference(head, [], f"{advice.NOT_MEASURED_YET[0].upper()}{advice.NOT_MEASURED_YET[1:]}.")
    rows = []
    for variant in summary(table):
        errors = ("reference", "reference") if variant.reference else _errors(variant)
        speed = f"{variant.particle_steps_per_second / 1e6:.1f} M"
        rows.append((variant.name, speed, f"{variant.cost:.3g} s", *errors, f"{variant.classes_agree} of {variant.cases}"))
    cases = "; ".join(dict.fromkeys(table["case"]))
    return Reference(head, rows, f"Cases {cases}; one core of {table['machine'].iloc[0]}, runs side by side.")


def _code_words(table: pd.DataFrame) -> str:
    cases = table[table["code"] != ""].groupby("code")["case"].unique()
    return "Runs made by " + "; ".join(f"{code}: {', '.join(names)}" for code, names in cases.items()) + "."


@table(
    "validation",
    "case | quantity | computed | reference | error, coarse to fine | tolerance | order | verdict | cost",
    _validation,
    note=_code_words,
)
def case_lines(table: pd.DataFrame) -> Lines:
    """Every result of the suite; title and cost once a case."""
    seen = set()
    for row in table.to_dict("records"):
        first, exact = row["case"] not in seen, row["reference"] == 0
        seen.add(row["case"])
        unit = "" if row["units"] == "1" else f" {row['units']}"
        errors = [float(error) for error in row["errors"].split(", ")]
        yield (
            row["case"],
            f"**{row['title']}**: {row['text']}" if first else row["text"],
            f"{row['computed']:.4g}{unit}",
            f"{row['reference']:.4g}{unit}",
            " / ".join(f"{error:.1e}" if exact else _per_cent(error) for error in errors),
            f"{row['tolerance']:.2g}" if exact else f"{100 * row['tolerance']:.2g} %",
            "" if math.isnan(row["order"]) else f"{row['order']:.1f}",
            _verdict(row),
            f"{row['cost']:.3g} s" if first else "",
        )


def _verdict(row: Mapping[Any, Any]) -> str:
    return row["verdict"] if row["verdict"] == HOLDS else Strong(row["verdict"])


def _per_cent(error: float) -> str:
    return f"{100 * error:.0f} %" if abs(error) >= 0.1 else f"{100 * error:.2g} %"


def change_lines(table: pd.DataFrame) -> Iterator[tuple[str, ...]]:
    """Rows (change, then for every case A's displacement and run-out over those of the scene as it is) of the assumptions."""
    cases = list(dict.fromkeys(table["case"]))
    for change, rows in table.groupby("change", sort=False):
        by_case = rows.set_index("case")
        cells = []
        for case in cases:
            row = by_case.loc[case]
            reference = change == table["change"].iloc[0]
            for name in CHANGED:
                value = f"{row[name]:.3g} m"
                cells.append(value if reference else f"{value} ({100 * row[f'{name}_change']:+z.0f} %)")
        yield str(change), *cells


def _assumptions() -> Reference:
    table = read_assumptions()
    cases = dict.fromkeys(table["case"])
    return Reference(("change", *(f"{case}, {what}" for case in cases for what in ("A", "run-out"))), list(change_lines(table)))


@table(
    "robustness",
    "key | values | sound | diverged | refused | energy gap up to | area of the deposit | "
    "5th percentile of nearest distance, at least | depth in walls up to | apart from the mass up to",
    read_robustness,
)
def sweep_lines(table: pd.DataFrame) -> Lines:
    """The sweeps, with the worst of the sound runs' checks."""
    for sweep, rows in table[table["sweep"] != TIME_STEP].groupby("sweep", sort=False):
        sound = rows[~rows["status"].isin((Status.DIVERGED, REFUSED))]
        diverged, refused = (
            ", ".join(dict.fromkeys(rows["value"][rows["status"] == status])) or "-" for status in (Status.DIVERGED, REFUSED)
        )
        worst = (
            f"{100 * sound['energy_gap'].max():.2g} %",
            f"{100 * sound['area_change'].min():+.2g} to {100 * sound['area_change'].max():+.2g} %",
            f"{sound['nearest_p05'].min():.2f}",
            f"{sound['penetration'].max():.2f}",
            f"{100 * sound['stragglers'].max():.2g} %",
        )
        yield str(sweep), ", ".join(dict.fromkeys(rows["value"])), f"{len(sound)} of {len(rows)}", diverged, refused, *worst


def too_long(steps: pd.DataFrame) -> pd.Series:
    """Which time steps are too long: the run diverges, or its slope, which stands at short steps, fails under gravity alone."""
    return steps["status"].isin((Status.DIVERGED, Status.FAILED_UNSHAKEN))


@table("outcomes", "section | settings | sound | diverged | failed under gravity alone, unlike at shorter steps | refused", read_robustness)
def outcome_lines(table: pd.DataFrame) -> Lines:
    """How many settings of each section of the configuration end how."""
    for section, rows in (("parameters", table[table["sweep"] != TIME_STEP]), ("time_steps", table[table["sweep"] == TIME_STEP])):
        diverged, refused = ((rows["status"] == status).sum() for status in (Status.DIVERGED, REFUSED))
        fallen = too_long(rows).sum() - diverged if section == "time_steps" else 0
        yield section, *(str(count) for count in (len(rows), len(rows) - diverged - fallen - refused, diverged, fallen, refused))


@table("time_steps", "scheme | largest sound step over the limit | first that is too long", read_robustness)
def step_lines(table: pd.DataFrame) -> Lines:
    """The time steps of each scheme, over the limit from theory."""
    for scheme, rows in table[table["sweep"] == TIME_STEP].groupby("case", sort=False):
        factors = rows["value"].astype(float)
        first = factors[too_long(rows)].min()
        sound = factors[~(factors >= first)].max()
        yield str(scheme), f"{sound:g}", "none" if math.isnan(first) else f"{first:g}"


@table("claims", f"claim | the paper says | verdict | measured at `{BASELINE}`, 6 m/s²")
def claim_lines(table: pd.DataFrame) -> Lines:
    """The paper's claims."""
    for row in table.to_dict("records"):
        yield str(row["claim"]), row["statement"], _verdict(row), row["measured"]


@table("resolved_claims", "claim | the paper says | study, fidelity | verdict | measured at 6 m/s²")
def resolved_claim_lines(table: pd.DataFrame) -> Lines:
    """The claims with the scheme of one's own slopes."""
    for row in table.sort_values("claim", kind="stable").to_dict("records"):
        yield str(row["claim"]), row["statement"], f"{row['study']}, {row['fidelity']}", _verdict(row), row["measured"]


SLIP_CASES = ("2.5 m", "5/3 m", "1.5 m", "1.25 m", "1 m", "0.75 m", "0.5 m")


@table("slip_levels", f"study | S_R | residual strength after | {' | '.join(SLIP_CASES)}", read_levels)
def slip_level_lines(table: pd.DataFrame) -> Lines:
    """Brackets of the critical amplitude at each spacing."""
    table = table[table["slip_at_residual"].notna()]
    for (study, ratio, slip), rows in table.groupby(["study", "S_R", "slip_at_residual"], sort=False, dropna=False):
        brackets = {row["case"]: _bracket(row) for row in rows.to_dict("records")}
        said = "" if math.isnan(float(str(ratio))) else f"{ratio:.2f}"
        yield str(study), said, f"{1e3 * float(str(slip)):.0f} mm", *(brackets.get(case, "") for case in SLIP_CASES)


@table("slip_choices", "changed | critical amplitude, m/s² | change", read_levels)
def slip_choice_lines(table: pd.DataFrame) -> Lines:
    """The same of a choice that should not matter, and its change against the scene as it is."""
    rows = table[table["slip_at_residual"].isna()].assign(level=lambda frame: 0.5 * (frame["lower"] + frame["upper"])).to_dict("records")
    for row in rows:
        yield row["case"], _bracket(row), f"{100 * (row['level'] / rows[0]['level'] - 1):+.0f} %"


def _bracket(row: Mapping[Any, Any]) -> str:
    return f"above {row['lower']:.4g}" if math.isnan(row["upper"]) else f"{row['lower']:.4g} to {row['upper']:.4g}"


@table(
    "slow_sine",
    "period over T | S_R | slip at peak and residual strength | amplitude at which the slope fails | over k_c | "
    "rigid block over k_c | amplification of a column",
    read_slow_sine,
)
def slow_sine_lines(table: pd.DataFrame) -> Lines:
    """The slow sines."""
    for row in table.to_dict("records"):
        slips = f"{1e3 * row['slip_at_peak']:.0f} and {1e3 * row['slip_at_residual']:.0f} mm"
        over = 100.0 * (0.5 * (row["lower"] + row["upper"]) / LIMIT - 1.0)
        block = " to ".join(f"{100.0 * (row[name] / LIMIT - 1.0):+.0f}" for name in ("block_peak", "block_residual"))
        yield (
            f"{row['period_ratio']:g}",
            f"{row['S_R']:g}",
            slips,
            f"{_bracket(row)} g",
            f"{over:+.0f} %",
            f"{block} %",
            f"{row['amplification']:.2f}",
        )


table(
    "sliding_blocks",
    "slope | strength | rigid block | pairs | moved further | block over slope, geometric mean | "
    "standard deviation of ln | range | overload, median",
    read_blocks,
)(spread_rows)
table(
    "block_causes",
    "slope | Arias intensity, m/s | overload | block under the column over slope | correlation with overload | with Arias intensity",
    read_blocks,
)(cause_rows)


@table("findings", "code | severity | meaning", lambda: MESSAGES)
def finding_lines(messages: Mapping[str, Message]) -> Lines:
    """All that can be found."""
    for code, (severity, *_) in messages.items():
        yield code, str(severity) if isinstance(severity, Severity) else "note or warning", meaning(code)


@table("solid_states", f"solid state of failed soil | γ, 1/s | S_R | {' | '.join(f'A at {time:g} s' for time in READ_AT)}")
def solid_state_lines(table: pd.DataFrame) -> Lines:
    """A's displacement with either solid state of failed soil."""
    for row in table.to_dict("records"):
        moved = (f"{row[f'displacement_{time:g}']:.3g} m" for time in READ_AT)
        yield row["solid_after_failure"], f"{row['gamma']:g}", f"{row['S_R']:.2f}", *moved


def _study_tasks() -> set[str]:
    """The timed tasks that are the whole study, one a fidelity."""
    table = advice.shipped_table()
    return set() if table is None else {STUDY_AT + fidelity for fidelity in table["variant"][table["parameter"] == FIDELITY]}


@table("times", "what | time | conditions | machine")
def time_lines(table: pd.DataFrame) -> Lines:
    """The README's commands."""
    studies = _study_tasks()
    for row in table.to_dict("records"):
        if row["task"] not in studies:
            yield row["task"], duration(row["wall_time"]), row["conditions"], row["machine"]


def _history() -> list[Any]:
    """Stored measurements of speed, by pytest-benchmark."""
    folder = Path(__file__).parents[1] / "tests" / "benchmarks" / "history"
    return [json.loads(path.read_text(encoding="utf-8")) for path in folder.rglob("*.json")]


@table("speed", "processor | what | measured | code | when", _history)
def speed_lines(runs: Sequence[dict[str, Any]]) -> Lines:
    """The newest of each stored measurement of speed on each processor."""
    newest: dict[tuple[str, str], tuple[str, ...]] = {}
    for run in sorted(runs, key=lambda run: run["datetime"]):
        machine, commit = run["machine_info"], run["commit_info"]
        code = f"{commit['version']}, solver {commit['solver'][:8]}"
        for each in run["benchmarks"]:
            told, least = each["extra_info"], each["stats"]["min"]
            speed = f"{told['particle_steps'] / least / 1e6:.2g} M particle-steps/s" if "particle_steps" in told else f"{least:.3g} s"
            when = f"{run['datetime'][:10]}, load average {told['load']:g}"
            newest[each["fullname"], machine["processor"]] = machine["processor"], told["what"], speed, code, when
    yield from newest.values()


def _fidelities_note(table: pd.DataFrame) -> str:
    studies = table[table["task"].isin(_study_tasks())]
    where = "; ".join(dict.fromkeys(f"{row['machine']}, {row['conditions'].partition(';')[0]}" for row in studies.to_dict("records")))
    return f"Whole study: {where}. Errors: one run against the finest of the cost-accuracy study."


@table(
    "fidelities",
    f"fidelity | whole study | class as at `{BASELINE}` | A's displacement against `{BASELINE}` | one run | "
    "A's displacement, error | run-out, error",
    functools.partial(read_measured, "times"),
    note=_fidelities_note,
)
def fidelity_lines(table: pd.DataFrame) -> Lines:
    """The fidelities against the baseline, and their errors."""
    times = table.set_index("task")["wall_time"]
    compared = read_measured("fidelities").set_index("fidelity")
    measured_trade = advice.shipped_table()
    for variant in [] if measured_trade is None else summary(measured_trade[measured_trade["parameter"] == FIDELITY]):
        task = "study" if variant.variant == BASELINE else STUDY_AT + variant.variant
        against = ("-", "-")
        if variant.variant in compared.index:
            row: Any = compared.loc[variant.variant]
            against = (f"{row['same_class']} of {row['runs']}", f"within {percent(row['displacement_difference'])}")
        whole = duration(times[task]) + ", with installing" * (task == "study") if task in times.index else "not run"
        yield variant.variant, whole, *against, f"{variant.cost:.3g} s", *_errors(variant)


@table("origins", "table | solver | configuration | version | renewed by", shipped.read_origins)
def origin_lines(table: pd.DataFrame) -> Lines:
    """What the tables of the release were measured with, and the command that renews each."""
    noted = {row["table"]: row for row in table.to_dict("records")}
    for name, measured in shipped.SHIPPED.items():
        row = noted.get(name, {})
        solver, *others = (row.get(key, shipped.NOT_RECORDED) for key in ("solver", "configuration", "version"))
        repeated = f" ({row['repeated']} repeated)" if row.get("repeated") else ""
        commands = ", ".join(f"`{command}`" for command in measured.renewal.split(" && "))
        yield name, solver + repeated, *others, commands


def _missed_note(table: pd.DataFrame) -> str:
    held = table["verdict"] == HOLDS
    whole = held.groupby(table["case"]).all()
    return f"{held.sum()} of {len(table)} quantities are within their tolerance, in {whole.sum()} of {len(whole)} cases all of them."


@table("missed", "case | problem | missed | worst error (tolerance)", _validation, note=_missed_note)
def missed_lines(table: pd.DataFrame) -> Lines:
    """The cases that miss any of their quantities."""
    for case, rows in table.groupby("case", sort=False):
        missed = rows.assign(over=rows["error"] / rows["tolerance"])[rows["verdict"] == MISSES]
        if len(missed):
            errors = [
                f"{row['text']}: {_per_cent(row['error'])} ({_per_cent(row['tolerance'])})"
                for row in missed.sort_values(["over", "error"], key=abs, ascending=False).to_dict("records")
            ]
            yield str(case), rows["title"].iloc[0], f"{len(missed)} of {len(rows)}", errors[0]


def trust_text() -> str:
    """The README's summary: known answers, the errors of 25 rows and of those that ``sph new`` writes, and the paper's claims."""
    known, claims, table = read_validation(SHIPPED_VALIDATION), read_measured("claims"), advice.shipped_table("resolved")
    held, (count, others) = known["verdict"] == HOLDS, tally(dict(zip(claims["claim"], claims["verdict"], strict=True)))
    missed = ", ".join(known["case"][~held].unique()) or "none"
    strong = known[~held & known["text"].str.startswith(("F,", "amplitude")) & (known["error"] > 0)]  # resists more than it should
    lines = [
        f"* **Known answers:** {held.sum()} of {len(held)} results (waves, columns, factors of safety, yield accelerations, flows, water) "
        f"are within their tolerance, set before the runs but for [a few](docs/evidence/validation.md). Missed: {missed} "
        "([which, and why](docs/evidence/validation.md#what-is-missed-and-why)); on the unsafe side "
        f"{', '.join(strong['case'].unique())}, by up to {percent(strong['error'].max())}. No case is a "
        "[displacement measured on a shaking table](docs/evidence/validation.md#shaking-table-tests-that-we-do-not-reproduce-and-why). "
        "Of [two dams of 1971](docs/gallery/san-fernando-dams.md), one that flowed and one that stood, the latter settles too much here.",
        f"* **The paper's claims:** {'; '.join(filter(None, (count, others)))} ([each with its numbers](docs/evidence/claims.md)).",
    ]
    if table is not None:
        fidelities = table[table["parameter"] == FIDELITY]
        ends = load_scene("config/scenes/slope_on_rock.yaml").geometry
        height = ends.crest[1] - ends.toe[1]
        rows = {round(height / one["spacing"]): one["variant"] for one in fidelities.to_dict("records")}
        errors = {variant.variant: _errors(variant) for variant in summary(fidelities)}
        near, far = (errors[rows[number]] for number in (25, ROWS))
        lines.insert(
            1,
            "* **Resolution:** the error is known for [one slope](docs/evidence/cost-accuracy.md#ones-own-slopes), 60° steep, "
            f"{height:g} m high and above rock. With 25 rows of particles over its height, the displacement of the crest is within "
            f"{near[0]} of the finest runs, the run-out within {near[1]}. With {ROWS} rows, as `sph new` writes, the errors are {far[0]} "
            f"and {far[1]}. For a slope unlike that one (`sph info` says so) no error is known: run it at two spacings.",
        )
    return "\n".join(lines)


def commands_text() -> str:
    """The pages of ``--help``, as the library of the command line writes them in Markdown, a heading a command."""
    made = subprocess.run(
        [sys.executable, "-m", "typer", "sph.command.cli", "utils", "docs", "--name", "sph"], capture_output=True, text=True, check=True
    )
    return made.stdout[made.stdout.index("\n## ") :].strip()


def _keys(model: type[BaseModel]) -> Reference:
    """The keys of a configuration, without those of all variants, which have a table of their own."""
    shared = {*key_rows(Variants)} if model is not Variants and issubclass(model, Variants) else set()
    return Reference(("key", "unit", "default", "allowed", "source", "meaning"), [row for row in key_rows(model) if row not in shared])


def _variables(columns: Iterable[Variable]) -> Reference:
    rows = [(variable.name, ", ".join(variable.dims), variable.dtype, variable.units, variable.text) for variable in columns]
    return Reference(("variable", "dimensions", "type", "unit", "meaning"), rows)


def _schemes_table() -> Reference:
    """Keys that the schemes fill in differently, or that the scheme of one's own slopes wants written."""
    paper = validated(Scene, {"name": "paper", "scheme": "paper", "geometry": {"shape": "slope"}}, "paper").model_dump()
    rows = [(name, f"`{_short(value)}`", f"`{_short(_at(paper, name))}`", "") for name, value in flat(RESOLVED).items()]
    rows += [(name, "must be written", f"`{_short(_at(paper, name))}`", text) for name, text in NEEDED.items()]
    return Reference(("key", "`resolved`", "`paper`", "meaning"), rows)


def _searched() -> Searched:
    """The dimensions of the searches in the paper's study."""
    scene = validated(
        Scene, {"name": "paper", "scheme": "paper", "geometry": {"shape": "slope"}, "motion": {"kind": "tapered_sine"}}, "paper"
    )
    return Searched(tuple(dimension(name, ["1"], scene) for name in SHORT_NAMES), "amplitude")


def _at(data: Any, name: str) -> Any:
    for part in name.split("."):
        data = None if data is None else data[part]
    return data


def _short(value: Any) -> str:
    if isinstance(value, dict):
        return ", ".join(f"{name}: {_short(part)}" for name, part in value.items())
    return (
        "null" if value is None else f"{value:g}" if isinstance(value, float) else str(list(value) if isinstance(value, tuple) else value)
    )


SEARCHED = _searched()
VARIABLES_OF: dict[str, Iterable[Variable]] = {
    "cost-accuracy": COST_ACCURACY,
    "assumptions": ASSUMPTIONS,
    "robustness": ROBUSTNESS,
    "validation": VALIDATION,
    "sample": SAMPLE,
    "morris": MORRIS,
    "tornado": TORNADO,
    "sobol": SOBOL,
    "cross_validation": CROSS_VALIDATION,
    "confirmation": CONFIRMED,
    "back": BACK_ANALYSIS,
    "back_confirmed": (*PREDICTED, *MEASURED),
    "trigger": critical_columns(SEARCHED),
    "fragility": fit_columns("m s-2"),
    "curves": curve_columns("m s-2"),
    "measures": MEASURE_COLUMNS,
    "exceedance": exceedance_columns("m s-2"),
    "widths": width_columns("m s-2"),
    "spacing": spacing_columns(),
    "place": place_columns(["road"]),
    "annual": annual_columns("m s-2"),
    "points": point_columns(SEARCHED.all),
    "confirm": confirm_columns(SEARCHED),
    "cells": cell_columns(SEARCHED),
    "shares": share_columns(SEARCHED),
    "preflight": PREFLIGHT,
}
"""The columns of tables, by what they are of."""
KEYS_OF = {each.keys: name for name, each in reversed(EXPERIMENTS.items()) if each.keys}
"""The first experiment of each kind of configuration."""
TABLES |= {
    "scene": lambda: _keys(Scene),
    "study": lambda: _keys(AnyStudy),
    "variants_keys": lambda: _keys(Variants),
    **{f"{name}_keys": functools.partial(_keys, keys) for keys, name in KEYS_OF.items()},
    **{f"{name}_variables": functools.partial(_variables, columns) for name, columns in VARIABLES_OF.items()},
    "failure_rule": lambda: _keys(FailureRule),
    "trajectory": lambda: _variables((*VARIABLES, *OPTIONAL)),
    "metrics": lambda: _variables(VALUES),
    "convergence": lambda: _variables(CONVERGENCE),
    "assumptions": _assumptions,
    "trust": lambda: Reference((), [], trust_text()),
    "commands": lambda: Reference((), [], commands_text()),
    "schemes": _schemes_table,
    "cost-accuracy": _measured,
    "resolution": lambda: _measured("resolved"),
}
MARKED = re.compile(r"(<!-- sph reference ([\w-]+) -->\n).*?(<!-- end -->)", re.DOTALL)
"""A table that is kept, between its marks: the mark with its name, the name, the mark behind it."""
PRINTED = re.compile(r"^\*Table: `python -m tools\.reference ([\w-]+)`\*$", re.MULTILINE)
"""The line in place of a table that is not kept, and its name."""


def filled(text: str) -> str:
    """Text with the tables between its marks made again; ValueError for a mark of no table."""
    return MARKED.sub(lambda mark: f"{mark[1]}\n{table_text(mark[2])}\n\n{mark[3]}", text)


def with_tables(text: str) -> str:
    """Text with the tables that are not kept, as the site has it; ValueError for a name of no table."""
    return PRINTED.sub(lambda mark: table_text(mark[1]), text)


def table_text(name: str) -> str:
    """A table by its name, in Markdown; ValueError for a name of none."""
    if name not in TABLES:
        raise ValueError(f"{name}: is no table; must be one of {', '.join(TABLES)}")
    return markdown(TABLES[name]())


def _errors(variant: Summary) -> tuple[str, ...]:
    return tuple(percent(error) if variant.finished else "diverged" for error in variant.errors.values())


def _tag(section: type[BaseModel]) -> str:
    for field in section.model_fields.values():
        if typing.get_origin(field.annotation) is typing.Literal:
            return str(typing.get_args(field.annotation)[0])
    return section.__name__


def _default(field: FieldInfo) -> str:
    if field.is_required():
        return "required"
    default = field.default
    if isinstance(default, BaseModel):
        return "see below"
    return "null" if default is None else repr(default).replace("'", '"')


def _allowed(field: FieldInfo) -> str:
    bounds = []
    for item in field.metadata:
        for sign, attribute in ((">", "gt"), (">=", "ge"), ("<", "lt"), ("<=", "le")):
            if getattr(item, attribute, None) is not None:
                bounds.append(f"{sign} {getattr(item, attribute):g}")
        if getattr(item, "pattern", None):
            bounds.append("letters, digits, _ . -")
    if typing.get_origin(field.annotation) is typing.Literal:
        bounds.append(", ".join(map(str, typing.get_args(field.annotation))))
    if type(None) in typing.get_args(field.annotation):
        bounds.append("null")
    return ", ".join(bounds) or "-"


if __name__ == "__main__":
    for name in sys.argv[1:]:
        print(table_text(name))
    if not sys.argv[1:]:
        for name in MODELS:
            schema_file(name).write_text(schema_text(name), encoding="utf-8")
        readme = Path("README.md")
        readme.write_text(filled(readme.read_text(encoding="utf-8")), encoding="utf-8")
