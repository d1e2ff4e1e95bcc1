"""What the tables of this release were measured with: ``python -m sph.experiments.shipped`` names those older than their code.

``measured/origins.csv`` keeps, for every table, digests of the table itself, of the solver that made its runs and of its configuration.
A table without a row there, or changed since, is *not recorded*; one whose solver or configuration has changed is *older*: its numbers
may still hold, but nobody has measured them again.  ``adopt`` copies a table from its results and reads the solver from the runs.
"""

from __future__ import annotations

import argparse
import hashlib
import shutil
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import netCDF4
import pandas as pd
import yaml

import sph
from sph.solver.compiled.jit import solver_digest
from sph.storage.files import content_digest
from sph.storage.trajectory import Variable
from sph.study.tables import read_csv, text_column, write_csv

PACKAGE = Path(__file__).parents[1]
MEASURED = Path(__file__).with_name("measured")
CURRENT, OLDER, NOT_RECORDED = "current", "older", "not recorded"
ORIGINS: tuple[Variable, ...] = (
    text_column("table", "name of the table"),
    text_column("content", "digest of its file"),
    text_column("solver", "digest of the solver that made the runs"),
    text_column("configuration", "digest of the files that configure it"),
    text_column("version", "version that was measured"),
)
"""Columns of ``origins.csv``."""


class Shipped(NamedTuple):
    """A table of the release."""

    folder: str
    """where its results lie, relative to the working folder"""
    configuration: tuple[str, ...]
    """files it is configured by, as patterns seen from the repository"""
    renewal: str
    """the commands that measure it again"""
    path: Path
    """the table in the package"""

    @property
    def runs(self) -> list[Path]:
        """The runs below its folder."""
        return sorted(Path(self.folder).glob("**/runs/**/*.nc"))


def _experiment(name: str, path: Path, *scenes: str) -> Shipped:
    renewal = f"snakemake --cores 2 {name} && python -m sph.experiments.shipped adopt {name}"
    return Shipped(f"results/{name}", (f"config/{name}.yaml", *scenes), renewal, path)


_PAPER = "snakemake --cores 2 && snakemake --cores 2 trigger"
_PAPER_FILES = ("config/config.yaml", "config/scenes/paper.yaml")
SHIPPED: dict[str, Shipped] = {
    "trade": _experiment("trade", MEASURED / "trade.csv", "config/scenes/paper.yaml"),
    "resolution": _experiment("resolution", MEASURED / "resolution.csv", "config/scenes/long_box.yaml"),
    "limits": _experiment("limits", MEASURED / "limits.csv", "config/scenes/paper.yaml"),
    "extremes": _experiment("extremes", MEASURED / "extremes.csv", "config/scenes/*.yaml"),
    "validation": _experiment("validation", PACKAGE / "validation" / "measured" / "validation.csv", "config/scenes/validation/*.yaml"),
    "claims": Shipped("results/paper", _PAPER_FILES, f"{_PAPER} && python -m sph.paper.release", MEASURED / "claims.csv"),
    "resolved_claims": Shipped(
        "results/paper_resolved",
        ("config/studies/paper_resolved.yaml", "config/studies/long_box.yaml", "config/scenes/paper.yaml", "config/scenes/long_box.yaml"),
        "snakemake --cores 2 --configfile config/studies/paper_resolved.yaml && "
        "snakemake --cores 2 --configfile config/studies/long_box.yaml && python -m sph.paper.release resolved_claims",
        MEASURED / "resolved_claims.csv",
    ),
    "fidelities": Shipped(
        "results/paper",
        _PAPER_FILES,
        "snakemake --cores 2 && snakemake --cores 2 --config fidelity=draft && snakemake --cores 2 --config fidelity=standard && "
        "python -m sph.paper.release",
        MEASURED / "fidelities.csv",
    ),
    "times": Shipped("results/paper", _PAPER_FILES, "python tests/benchmarks/commands.py", MEASURED / "times.csv"),
}
"""The tables by name."""


def settings_digest(patterns: Sequence[str], root: Path = PACKAGE.parent) -> str:
    """Digest of what YAML files say, comments left out; empty where none of them lies below ``root``, as beside an installed package."""
    paths = sorted({path for pattern in patterns for path in root.glob(pattern)})
    if not paths:
        return ""
    said = [[path.relative_to(root).as_posix(), yaml.safe_load(path.read_text(encoding="utf-8"))] for path in paths]
    return hashlib.sha256(yaml.safe_dump(said, sort_keys=True).encode()).hexdigest()[:16]


def solver_of(runs: Sequence[Path]) -> str:
    """Digest of the solver that made the runs; ValueError without runs, or where they do not have one and the same."""
    found: dict[str, Path] = {}
    for path in runs:
        with netCDF4.Dataset(path) as data:
            found.setdefault(str(getattr(data, "solver_digest", "")), path)
    if not found:
        raise ValueError("no runs to read the solver from; make them first")
    if len(found) > 1 or "" in found:
        told = ", ".join(f"{digest or 'not noted'} ({path})" for digest, path in found.items())
        raise ValueError(f"the runs were not made by one solver: {told}; make them again")
    return next(iter(found))


def note(name: str, solver: str, origins: Path = MEASURED / "origins.csv") -> None:
    """Keep what a table of the package, as it is now, was measured with, in the place of an earlier row."""
    table = SHIPPED[name]
    row = {"table": name, "content": content_digest(table.path), "solver": solver, "version": sph.__version__}
    row["configuration"] = settings_digest(table.configuration)
    kept = read_origins(origins)
    write_csv(pd.concat([kept[kept["table"] != name], pd.DataFrame([row])], ignore_index=True)[[each.name for each in ORIGINS]], origins)


def adopt(name: str, origins: Path = MEASURED / "origins.csv") -> None:
    """Copy a table from its results into the package with the solver of its runs; ValueError names what is missing."""
    table = SHIPPED[name]
    source = Path(table.folder) / table.path.name
    if not source.is_file():
        raise ValueError(f"{source}: no such file; run '{table.renewal}'")
    solver = solver_of(table.runs)
    shutil.copyfile(source, table.path)
    note(name, solver, origins)


def states(origins: Path = MEASURED / "origins.csv") -> dict[str, tuple[str, str]]:
    """For every table whether it is current, older or not recorded, and why."""
    rows = {row["table"]: row for row in read_origins(origins).to_dict("records")}
    found = {}
    for name, table in SHIPPED.items():
        row = rows.get(name)
        if row is None:
            found[name] = NOT_RECORDED, "it does not say which code it was measured with"
        elif row["content"] != content_digest(table.path):
            found[name] = NOT_RECORDED, "the table has changed since its origin was noted"
        else:
            now = settings_digest(table.configuration)
            changed = [f"solver {row['solver']}, now {solver_digest()}"] * (row["solver"] != solver_digest())
            changed += [f"configuration {row['configuration']}, now {now}"] * (now not in ("", row["configuration"]))
            found[name] = (OLDER, "; ".join(changed)) if changed else (CURRENT, f"solver {row['solver']}")
    return found


def read_origins(origins: Path = MEASURED / "origins.csv") -> pd.DataFrame:
    """Rows of the tables whose origin is known, with the columns ``ORIGINS``."""
    if not origins.is_file():
        return pd.DataFrame(columns=[each.name for each in ORIGINS], dtype=str)
    return read_csv(origins, ORIGINS, "the origins of a release")


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the state of every table with the command that renews it, or adopt one."""
    parser = argparse.ArgumentParser(prog="python -m sph.experiments.shipped", description=main.__doc__)
    adopting = parser.add_subparsers(dest="command").add_parser("adopt", help="copy a table from its results into the package")
    adopting.add_argument("table", choices=[name for name, table in SHIPPED.items() if "shipped adopt" in table.renewal])
    chosen = parser.parse_args(arguments)
    if chosen.command == "adopt":
        try:
            adopt(chosen.table)
        except ValueError as error:
            parser.error(str(error))
    for name, (state, why) in states().items():
        print(f"{name:<11} {state}: {why}" + ("" if state == CURRENT else f"\n{'':<11} {SHIPPED[name].renewal}"))


if __name__ == "__main__":
    main()
