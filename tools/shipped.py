"""What the tables of this release were measured with: ``python -m tools.shipped`` names those older than their code.

``measured/origins.csv`` keeps, for every table, digests of the table itself, of the solver that made its runs and of its configuration.
A table without a row there, or changed since, is *not recorded*; one whose solver or configuration has changed is *older*: its numbers
may still hold, but nobody has measured them again.  ``adopt`` copies a table from its results and reads the solver from the runs.  The
reference cases take hours, so that their table is adopted case by case, each with the code that made its runs; it is as old as the oldest.
``repeat`` spares measuring everything again after a change of the solver that changes no answer: a part of the runs and searches, made
again, have to be the same to the last bit.  Where the runs of the table are gone, some can be made anew in a clone at its commit: with
``--all`` each of those is repeated.
"""

from __future__ import annotations

import argparse
import hashlib
import re
import shutil
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import netCDF4
import pandas as pd
import yaml

import sph
from cases import CASES
from cases.suite import FOLDER, SHIPPED_VALIDATION, read_validation
from sph.checks.layers import own_spacings
from sph.scene.scheme import filled
from sph.solver.compiled.jit import solver_digest
from sph.solver.run import run
from sph.stability.record import run_search
from sph.storage.files import content_digest
from sph.storage.trajectory import Variable, read, scene_of
from sph.study.tables import read_csv, text_column, write_csv

ROOT = Path(__file__).parents[1]
REPEATED = 0.1
"""Part of a table's runs that ``repeat`` makes again at least."""
MEASURED = ROOT / "sph" / "experiments" / "measured"
CURRENT, OLDER, NOT_RECORDED = "current", "older", "not recorded"
ORIGINS: tuple[Variable, ...] = (
    text_column("table", "name of the table"),
    text_column("content", "digest of its file"),
    text_column("solver", "digest of the solver that made the runs"),
    text_column("configuration", "digest of the files that configure it"),
    text_column("version", "version that was measured"),
    text_column("repeated", "how many runs of an earlier solver, which made them all, this one has repeated to the last bit, or empty"),
)
"""Columns of ``origins.csv``."""


class Shipped(NamedTuple):
    """A table of the release."""

    folders: tuple[str, ...]
    """where its results lie, relative to the working folder; the table, if results have it, in the first"""
    configuration: tuple[str, ...]
    """files it is configured by, as patterns seen from the repository"""
    renewal: str
    """the commands that measure it again"""
    path: Path
    """the table in the package"""
    parts: str = ""
    """pattern of the tables of its parts in the first folder, where it is adopted part by part"""
    settings: Callable[[], Any] = lambda: None
    """what configures it beside these files"""

    @property
    def runs(self) -> list[Path]:
        """The runs below its folders."""
        return sorted(path for folder in self.folders for path in Path(folder).glob("**/runs/**/*.nc"))


def _experiment(name: str, *scenes: str) -> Shipped:
    return Shipped((f"results/{name}",), (f"config/{name}.yaml", *scenes), _renewed(name), MEASURED / f"{name}.csv")


def _renewed(target: str) -> str:
    return f"snakemake --cores 2 {target} && python -m tools.shipped adopt {target}"


def _cases() -> list[Any]:
    """What the reference cases run and ask."""
    return [[name, [filled(scene) for scene in case.scenes().values()], case.compared, case.quantities] for name, case in CASES.items()]


_PAPER = "snakemake --cores 2 && snakemake --cores 2 trigger"
_PAPER_FILES = ("config/config.yaml", "config/scenes/paper.yaml")
SHIPPED: dict[str, Shipped] = {
    "cost-accuracy": _experiment("cost-accuracy", "config/scenes/paper.yaml"),
    "resolution": _experiment("resolution", "config/scenes/slope_on_rock.yaml"),
    "assumptions": _experiment("assumptions", "config/scenes/paper.yaml"),
    "robustness": _experiment("robustness", "config/scenes/paper.yaml"),
    "validation": Shipped((FOLDER,), (), _renewed("validation"), SHIPPED_VALIDATION, "cases/*.csv", _cases),
    "claims": Shipped(("results/paper",), _PAPER_FILES, f"{_PAPER} && python -m tools.release", MEASURED / "claims.csv"),
    "resolved_claims": Shipped(
        ("results/paper_resolved", "results/long_box"),
        ("config/studies/paper_resolved.yaml", "config/studies/long_box.yaml", "config/scenes/paper.yaml", "config/scenes/long_box.yaml"),
        "snakemake --cores 2 --configfile config/studies/paper_resolved.yaml && "
        "snakemake --cores 2 --configfile config/studies/long_box.yaml && python -m tools.release resolved_claims",
        MEASURED / "resolved_claims.csv",
    ),
    "fidelities": Shipped(
        ("results/paper",),
        _PAPER_FILES,
        "snakemake --cores 2 && snakemake --cores 2 --config fidelity=draft && snakemake --cores 2 --config fidelity=standard && "
        "python -m tools.release",
        MEASURED / "fidelities.csv",
    ),
    "slip_levels": Shipped(
        ("results/slope_on_rock", "results/stiff_clay", "results/stiff_clay_choices"),
        (
            *(f"config/studies/{name}*.yaml" for name in ("slope_on_rock", "stiff_clay")),
            *(f"config/studies/{name}*/trigger.yaml" for name in ("slope_on_rock", "stiff_clay")),
            "config/scenes/slope_on_rock.yaml",
            "config/scenes/stiff_clay.yaml",
        ),
        "for study in slope_on_rock stiff_clay stiff_clay_choices; do "
        "snakemake --cores 2 --configfile config/studies/$study.yaml -- trigger; done; python -m tools.levels",
        MEASURED / "slip_levels.csv",
    ),
    "solid_states": Shipped(
        ("results/paper_solid_states",),
        ("config/studies/paper_solid_states.yaml", "config/scenes/paper.yaml"),
        "snakemake --cores 2 --configfile config/studies/paper_solid_states.yaml && python -m tools.release solid_states",
        MEASURED / "solid_states.csv",
    ),
    "slow_sine": Shipped(
        ("results/slow_sine",), ("config/scenes/validation/v24_slow_sine.yaml",), "python -m tools.slow_sine", MEASURED / "slow_sine.csv"
    ),
    "sliding_blocks": Shipped(
        ("results/sliding_blocks",),
        tuple(f"config/scenes/{name}.yaml" for name in ("stiff_clay", "slope_on_rock", "gentle_layered")),
        "python -m tools.sliding_blocks FOLDER",
        MEASURED / "sliding_blocks.csv",
    ),
    "times": Shipped(("results/paper",), _PAPER_FILES, "python -m tools.times", MEASURED / "times.csv"),
}
"""The tables by name."""


def settings_digest(patterns: Sequence[str], settings: Any = None, root: Path = ROOT) -> str:
    """Digest of what YAML files say, comments left out, of what its scheme fills into a scene, and of other settings."""
    paths = sorted({path for pattern in patterns for path in root.glob(pattern)})
    said = [[path.relative_to(root).as_posix(), yaml.safe_load(path.read_text(encoding="utf-8"))] for path in paths]
    said = [[name, filled(data) if "scenes" in Path(name).parts else data] for name, data in said]
    more = "" if settings is None else repr(settings)
    return hashlib.sha256((yaml.safe_dump(said, sort_keys=True) + more).encode()).hexdigest()[:16]


def solver_of(runs: Sequence[Path]) -> str:
    """Digest of the solver that made the runs; ValueError without runs, or where they do not have one and the same."""
    solvers: dict[str, Path] = {}
    for path in runs:
        with netCDF4.Dataset(path) as data:
            solvers.setdefault(str(getattr(data, "solver_digest", "")), path)
    if not solvers:
        raise ValueError("no runs to read the solver from; make them first")
    if len(solvers) > 1 or "" in solvers:
        told = ", ".join(f"{digest or 'not noted'} ({path})" for digest, path in solvers.items())
        raise ValueError(f"the runs were not made by one solver: {told}; make them again")
    return next(iter(solvers))


def note(name: str, solver: str, origins: Path = MEASURED / "origins.csv", repeated: str = "") -> None:
    """Keep what a table of the package, as it is now, was measured with, in the place of an earlier row."""
    table = SHIPPED[name]
    row = {"table": name, "content": content_digest(table.path), "solver": solver, "version": sph.__version__, "repeated": repeated}
    row["configuration"] = settings_digest(table.configuration, table.settings())
    kept = read_origins(origins)
    write_csv(pd.concat([kept[kept["table"] != name], pd.DataFrame([row])], ignore_index=True)[[each.name for each in ORIGINS]], origins)


def adopt(name: str, origins: Path = MEASURED / "origins.csv") -> None:
    """Copy a table from its results into the package with the solver of its runs; ValueError names what is missing."""
    table = SHIPPED[name]
    if table.parts:
        solver, repeated = _noted(name, origins)
        kept, measured = adopt_cases(sorted(Path(table.folders[0]).glob(table.parts)), table.path, table.renewal)
        kept = {solver} if solver == solver_digest() else kept  # by which what is kept was repeated
        return note(name, " and ".join(sorted(kept | measured)), origins, repeated if kept == {solver} else "")
    source = Path(table.folders[0]) / table.path.name
    if not source.is_file():
        raise ValueError(f"{source}: no such file; run '{table.renewal}'")
    solver = solver_of(table.runs)
    shutil.copyfile(source, table.path)
    note(name, solver, origins)


def _noted(name: str, origins: Path) -> tuple[str, str]:
    """Solver of a table, and what of it was repeated, if the table is as it was when they were noted; else nothing."""
    rows = read_origins(origins)
    noted = rows[(rows["table"] == name) & (rows["content"] == content_digest(SHIPPED[name].path))].to_dict("records")
    return (str(noted[0]["solver"]), str(noted[0]["repeated"])) if noted else ("", "")


def adopt_cases(parts: Sequence[Path], path: Path, renewal: str) -> tuple[set[str], set[str]]:
    """Put the measured cases in the place of their rows in the table; returns the digests of the solvers that made the runs of the others
    and of these."""
    if not parts:
        raise ValueError(f"no case has been measured; run '{renewal}'")
    measured = pd.concat(map(read_validation, parts), ignore_index=True)
    before = read_validation(path)
    kept = before[~before["case"].isin(measured["case"])]
    rows = pd.concat([kept, measured], ignore_index=True)
    order = rows["case"].str.removeprefix("V").astype(int)
    write_csv(rows.loc[order.sort_values(kind="stable").index], path)
    first, second = ({digest for code in of["code"] for digest in re.findall(r"solver (\w+)", code)} for of in (kept, measured))
    return first, second


def chosen_runs(runs: Sequence[Path]) -> list[Path]:
    """The cheapest run of every combination of terms and status and search of every kind, and the cheapest of all up to ``REPEATED``."""
    facts = pd.DataFrame(_facts(runs), columns=["path", "seconds", "kind"]).sort_values("seconds", ignore_index=True)
    return facts[~facts["kind"].duplicated() | (facts.index < REPEATED * len(facts))]["path"].tolist()


def _facts(runs: Sequence[Path]) -> Iterator[tuple[Path, float, str]]:
    for path in runs:
        with netCDF4.Dataset(path) as data:
            yield path, float(data.wall_time_s), data.by if "by" in data.ncattrs() else f"{data.active_terms} {data.status}"


def _comes_again(path: Path) -> bool:
    """Whether a run, or a search with all its trials, made again has the same numbers to the last bit."""
    before = read(path).dataset()
    scene = scene_of(before, str(path))
    if "by" in before.attrs:
        again = run_search(scene, before.attrs["by"], spacings=own_spacings if before.attrs.get("extrapolates", 0) else None).dataset()
        known = [name for name in before.data_vars if name != "wall_time"]  # searches of earlier versions have fewer
        return before.attrs["reason"] == again.attrs["reason"] and before[known].equals(again[known])
    return before.equals(run(scene, enforce_limit=False).trajectory)


def repeat(name: str, origins: Path = MEASURED / "origins.csv", every: bool = False) -> None:
    """Note a table whose runs were made by an earlier solver as of this one, once this one has repeated a part of them, or ``every`` one
    that lies in its folders, to the last bit.

    ValueError for a table that is older for another reason, for results that are not those of the table, and where a run differs.
    """
    table = SHIPPED[name]
    state, why = states(origins)[name]
    earlier = solver_of(table.runs)
    if state != OLDER or why != f"solver {earlier}, now {solver_digest()}":
        raise ValueError(f"{name} is {state}: {why}; repeat only what a new solver alone has made older, adopted from these runs")
    chosen = table.runs if every else chosen_runs(table.runs)
    for path in chosen:
        if not _comes_again(path):
            raise ValueError(f"{path}: made again, its numbers differ from those of solver {earlier}; run '{table.renewal}'")
        print(f"{path}: the same", flush=True)
    of_all = "" if every else f" of {len(table.runs)}"
    note(name, solver_digest(), origins, f"{len(chosen)}{of_all} runs of {earlier}")


def states(origins: Path = MEASURED / "origins.csv") -> dict[str, tuple[str, str]]:
    """For every table whether it is current, older or not recorded, and why."""
    rows = {row["table"]: row for row in read_origins(origins).to_dict("records")}
    by_table = {}
    for name, table in SHIPPED.items():
        row = rows.get(name)
        if row is None:
            by_table[name] = NOT_RECORDED, "it does not say which code it was measured with"
        elif row["content"] != content_digest(table.path):
            by_table[name] = NOT_RECORDED, "the table has changed since its origin was noted"
        else:
            now = settings_digest(table.configuration, table.settings())
            changed = [f"solver {row['solver']}, now {solver_digest()}"] * (row["solver"] != solver_digest())
            changed += [f"configuration {row['configuration']}, now {now}"] * (now != row["configuration"])
            by_table[name] = (OLDER, "; ".join(changed)) if changed else (CURRENT, f"solver {row['solver']}")
    return by_table


def read_origins(origins: Path = MEASURED / "origins.csv") -> pd.DataFrame:
    """Rows of the tables whose origin is known, with the columns ``ORIGINS``."""
    if not origins.is_file():
        return pd.DataFrame(columns=[each.name for each in ORIGINS], dtype=str)
    return read_csv(origins, ORIGINS, "the origins of a release")


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the state of every table with the command that renews it, or adopt one."""
    parser = argparse.ArgumentParser(prog="python -m tools.shipped", description=main.__doc__)
    commands = parser.add_subparsers(dest="command")
    copied = [name for name, table in SHIPPED.items() if "tools.shipped adopt" in table.renewal]
    copies = commands.add_parser("adopt", help="copy a table from its results into the package")
    copies.add_argument("table", choices=copied)
    copies.set_defaults(function=lambda given: adopt(given.table))
    repeats = commands.add_parser("repeat", help="make a part of a table's runs again after a change of the solver that changes no answer")
    repeats.add_argument("table", choices=list(SHIPPED))
    repeats.add_argument("--all", action="store_true", help="each run in its folders, which may be a part of the table's")
    repeats.set_defaults(function=lambda given: repeat(given.table, every=given.all))
    chosen = parser.parse_args(arguments)
    if chosen.command:
        try:
            chosen.function(chosen)
        except ValueError as error:
            parser.error(str(error))
    for name, (state, why) in states().items():
        print(f"{name:<15} {state}: {why}" + ("" if state == CURRENT else f"\n{'':<15} {SHIPPED[name].renewal}"))


if __name__ == "__main__":
    main()
