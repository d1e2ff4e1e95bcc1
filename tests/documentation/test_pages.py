"""What the pages show can be done: their links lead somewhere, and their commands are understood."""

from __future__ import annotations

import re
import shlex
import sys
import tomllib
from collections import Counter
from collections.abc import Sequence
from importlib.util import find_spec
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
import typer
from snakemake.cli import get_argument_parser

from sph.command.cli import app

ROOT = Path(__file__).resolve().parents[2]
PAGES = [
    *(ROOT / name for name in ("README.md", "CONTRIBUTING.md", "CHANGELOG.md", "config/README.md", "results/README.md")),
    ROOT / "workflow" / "profiles" / "README.md",
    *sorted((ROOT / "docs").rglob("*.md")),
]
EXTRAS = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["optional-dependencies"]
NAMED = re.compile(r"""^rule (\w+):|^    name:\n        "([\w-]+)"$""", re.MULTILINE)
RULES = {"all"} | {"".join(names) for path in ROOT.glob("workflow/rules/*.smk") for names in NAMED.findall(path.read_text())}
FENCE = re.compile(r"^ *```(\w*)\n(.*?)^ *```$", re.MULTILINE | re.DOTALL)


def name_of(page: Path) -> str:
    return page.relative_to(ROOT).as_posix()


pages = pytest.mark.parametrize("page", PAGES, ids=name_of)


def test_the_readme_is_read_in_two_minutes() -> None:
    assert len((ROOT / "README.md").read_text(encoding="utf-8").splitlines()) <= 100


# ---------------------------------------------------------------- links


def prose(page: Path) -> str:
    """Text without code."""
    return re.sub(r"`[^`\n]*`", "", FENCE.sub("", page.read_text(encoding="utf-8")))


def code_of(page: Path) -> str:
    """Text of the blocks of code."""
    return "\n".join(code for _, code in FENCE.findall(page.read_text(encoding="utf-8")))


def anchors(page: Path) -> set[str]:
    """Anchors of a page's headings, as forges make them."""
    made: Counter[str] = Counter()
    found = set()
    for heading in re.findall(r"^#+ (.+)$", FENCE.sub("", page.read_text(encoding="utf-8")), re.MULTILINE):
        slug = re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")
        found.add(f"{slug}-{made[slug]}" if made[slug] else slug)
        made[slug] += 1
    return found


def broken(page: Path, site: Path = ROOT / "docs") -> list[str]:
    """Relative links of a page that lead nowhere, or from the site to what is not in it."""
    faults = []
    for target in re.findall(r"\]\(([^)\s]+)\)", prose(page)):
        if re.match(r"\w+:", target):
            continue
        path, _, anchor = target.partition("#")
        file = page.parent / path if path else page
        if "/api/" in path:  # a page of the library, which the site makes of a module
            module = ROOT / path.partition("/api/")[2].removesuffix(".html")
            fine = module.with_suffix(".py").is_file() or (module / "__init__.py").is_file()
        elif page.parent.name == "gallery" and (path.startswith("results/") or path in code_of(page)):
            continue  # a file that the page makes; building the site asks whether it did
        else:
            fine = file.is_file() and (not anchor or anchor in anchors(file))
        leaves_the_site = page.is_relative_to(site) and not file.resolve().is_relative_to(site)
        faults += [] if fine and not leaves_the_site else [target]
    return faults


@pages
def test_links_lead_somewhere(page: Path) -> None:
    assert not broken(page)


def test_every_page_is_linked() -> None:
    linked = {
        (page.parent / target.partition("#")[0]).resolve() for page in PAGES for target in re.findall(r"\]\(([^)\s]+)\)", prose(page))
    }
    assert not {name_of(page) for page in (ROOT / "docs").rglob("*.*") if page.suffix != ".css" and page.name != "index.md"} - {
        name_of(path) for path in linked if path.is_relative_to(ROOT)
    }


# ---------------------------------------------------------------- commands


def commands(page: Path) -> list[list[str]]:
    """Words of every command in the sh blocks of a page, without comments; continued lines and commands joined by && are told apart."""
    blocks = "\n".join(block for kind, block in FENCE.findall(page.read_text(encoding="utf-8")) if kind == "sh")
    lines = [line for line in blocks.replace("\\\n", " ").splitlines() if line.strip()]
    return [words for line in lines for part in line.split(" && ") if (words := shlex.split(part, comments=True))]


def mentioned(page: Path) -> list[list[str]]:
    """Words of the commands of sph and Snakemake within sentences; some leave out what has to be given."""
    spans = re.findall(r"`((?:\.venv/bin/)?(?:sph|snakemake) [^`\n]+)`", FENCE.sub("", page.read_text(encoding="utf-8")))
    return [shlex.split(span) for span in spans if "COMMAND" not in span]


def fault(words: list[str], written: Sequence[str] = ()) -> str:
    """What is wrong with a command; empty if it is understood.  Files in folders that a page has ``written`` are there."""
    program, arguments = Path(words[0]).name, words[1:]
    if program == "sph":
        return sph_fault(arguments)
    if program == "snakemake":
        return snakemake_fault(arguments, written)
    if program == "pip" and arguments[0] == "install":
        extras = {extra for word in arguments for extra in re.findall(r"\[(.+)\]", word)}
        return "" if extras <= set(EXTRAS) and ("-c" not in arguments or (ROOT / "constraints.txt").exists()) else f"no extras {extras}"
    if program in ("python", "python3") and arguments[0] == "-m":
        return "" if find_spec(arguments[1]) else f"no module {arguments[1]}"
    if program == "python":
        return "" if (ROOT / arguments[0]).is_file() else f"no script {arguments[0]}"
    if program == "pytest":
        return "".join(f"no file {word}" for word in arguments if "/" in word and not (ROOT / word.rpartition("=")[2]).exists())
    if words[0].startswith(".ci/"):
        return "" if (ROOT / words[0]).is_file() else f"no script {words[0]}"
    known = (
        program in ("cat", "cp", "conda", "podman", "apptainer", "pre-commit", "pytest-benchmark")
        or (Path(sys.executable).parent / program).exists()
    )
    return "" if known else f"no program {program}"


def sph_fault(arguments: list[str]) -> str:
    """What the command line does not understand; a command without what has to be given is understood."""
    group: Any = typer.main.get_command(app)
    if arguments[0].startswith("-"):
        return "" if arguments[0] in ("--help", "--install-completion") else f"no option {arguments[0]}"
    if arguments[0] not in group.commands:
        return f"no command {arguments[0]}"
    try:
        group.commands[arguments[0]].make_context(arguments[0], arguments[1:])
    except SystemExit:
        return ""
    except Exception as error:
        named = type(error).__name__
        return "" if named in ("MissingParameter", "Exit") else f"{named}: {error}"
    return ""


def snakemake_fault(arguments: list[str], written: Sequence[str] = ()) -> str:
    """Options that Snakemake does not have, and targets that are no rule of this workflow; a path is one."""
    logger = next((after for word, after in pairwise(arguments) if word == "--logger"), "")
    if logger:  # a plugin of an extra, which need not be installed
        if not any(needed.startswith(f"snakemake-logger-plugin-{logger}>") for extra in EXTRAS.values() for needed in extra):
            return f"no extra with the logger {logger}"
        arguments = [word for word in arguments if word not in ("--logger", logger)]
    try:
        asked = get_argument_parser().parse_args(arguments)
    except SystemExit:
        return f"not understood: {arguments}"
    unknown = [target for target in asked.targets or [] if "/" not in target and target not in RULES]
    named = map(Path, [*(asked.profile or []), *(asked.configfile or [])])
    files = [str(path) for path in named if not (ROOT / path).exists() and path.parts[0] not in written]
    return " ".join(unknown + files)


@pytest.mark.parametrize("page", [page for page in PAGES if page.name != "CHANGELOG.md"], ids=name_of)
def test_commands_are_understood(page: Path) -> None:
    written = re.findall(r" --out (\w+)$", code_of(page), re.MULTILINE)  # folders, by sph new
    faults = {" ".join(words): found for words in commands(page) + mentioned(page) if (found := fault(words, written))}
    assert not faults


def test_the_table_of_cross_checks_names_the_tests_that_are_marked() -> None:
    page = (ROOT / "docs" / "evidence" / "validation.md").read_text(encoding="utf-8")
    told = set(re.findall(r"`(tests/[\w/.]+)`", page.partition("## Beside other programs")[2]))
    marked = {str(path.relative_to(ROOT)) for path in ROOT.glob("tests/**/test_*.py") if "pytest.mark." + "crosscheck" in path.read_text()}
    assert told == marked


def test_the_page_on_the_solver_names_what_there_is() -> None:
    text = (ROOT / "docs" / "development" / "solver.md").read_text(encoding="utf-8")
    sources = list((ROOT / "sph").rglob("*.py"))
    there = {word for path in sources for word in re.findall(r"\w+", path.read_text(encoding="utf-8"))}
    files, words = set(re.findall(r"`(?:[.\w]+/)*(\w+\.py)`", text)), set(re.findall(r"`(\w+)`", text))
    assert len(files) > 20 and not files - {path.name for path in sources}
    assert len(words) > 20 and not words - there
