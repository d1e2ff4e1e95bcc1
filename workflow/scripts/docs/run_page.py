"""Run a page of the gallery: its blocks of commands and of Python, in order and in a folder of their own."""

import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import IO, NamedTuple

from sph.jobs.log import Job, job_log
from sph.study.machine import duration, machine_class

FENCE = re.compile(r"^```(sh|python)\n(.*?)^```$\n?", re.MULTILINE | re.DOTALL)
LINK = re.compile(r"(\]\()([^)\s:#]+)(\))")
MAX_LINES = 60
"""Of the output of a block; what is longer is cut."""
PROGRAMS = {"sh": ["bash", "-eu", "-o", "pipefail"], "python": [sys.executable]}


class Block(NamedTuple):
    """What is run and shown."""

    line: int
    """of the page, at which it begins"""
    language: str
    code: str


def read_page(path: Path) -> list[str | Block]:
    """Text and blocks of a page, in order."""
    text = path.read_text(encoding="utf-8")
    parts: list[str | Block] = []
    end = 0
    for fence in FENCE.finditer(text):
        parts += [text[end : fence.start()], Block(text.count("\n", 0, fence.start()) + 1, fence[1], fence[2])]
        end = fence.end()
    return [*parts, text[end:]]


def run_program(language: str, code: str, folder: Path, log: IO[str]) -> tuple[str, str]:
    """What a program prints, run in a folder, and what is wrong, empty if it ends well."""
    file = folder / "block"
    file.write_text(code, encoding="utf-8")
    setting = os.environ | {"COLUMNS": "120", "NO_COLOR": "1", "MPLBACKEND": "agg"}
    done = subprocess.run([*PROGRAMS[language], file.name], cwd=folder, env=setting, capture_output=True, text=True, check=False)
    print(done.stdout, done.stderr, file=log, flush=True)
    return done.stdout, (done.stderr or "it says nothing") if done.returncode else ""


def run_blocks(path: Path, blocks: list[Block], folder: Path, log: IO[str]) -> list[str]:
    """What each block prints; ValueError names page and line of the one that fails."""
    outputs = []
    for block in blocks:
        printed, wrong = run_program(block.language, block.code, folder, log)
        if wrong:
            raise ValueError(f"{path}: the block at line {block.line} fails:\n{wrong}")
        outputs.append(printed)
    return outputs


def shown(block: Block, output: str) -> str:
    """A block and its output: a Markdown table where it prints one, else as it is printed, cut where it is long."""
    code = f"```{block.language}\n{block.code}```\n\n"
    lines = [line.rstrip() for line in output.strip("\n").splitlines()]
    if len(lines) > MAX_LINES:
        lines = [*lines[:MAX_LINES], f"... and {len(lines) - MAX_LINES} lines more"]
    text = "\n".join(lines)
    if not text:
        return code
    return f"{code}{text}\n\n" if text.startswith("|") else f"{code}```text\n{text}\n```\n\n"


def run_page(path_to_page: str, root: Path, folder: Path, log: IO[str]) -> None:
    """Write ``page.md``, with what its blocks print and how long they took, and the files that they make and it links to, into a folder.

    The blocks find the repository as in its root: configuration, documentation, tests and workflow, and ``.venv`` with this Python.
    """
    path = Path(path_to_page)
    parts = read_page(path)
    blocks = [part for part in parts if isinstance(part, Block)]
    with tempfile.TemporaryDirectory() as name:
        work = Path(name)
        for entry in ("config", "docs", "tests", "workflow", "Snakefile"):
            (work / entry).symlink_to(root / entry)
        (work / ".venv").symlink_to(sys.prefix)
        start = time.perf_counter()
        outputs = iter(run_blocks(path, blocks, work, log))
        took = f"*All commands of this page took {duration(time.perf_counter() - start)} on {machine_class()}.*"
        page = "".join(shown(part, next(outputs)) if isinstance(part, Block) else part for part in parts) + f"\n{took}\n"
        made = {target for _, target, _ in LINK.findall(page) if not target.startswith("..") and (work / target).is_file()}
        for target in made:
            (folder / target).parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(work / target, folder / target)
    page = LINK.sub(lambda link: f"{link[1]}{folder.name}/{link[2]}{link[3]}" if link[2] in made else link[0], page)
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "page.md").write_text(page, encoding="utf-8")


if __name__ == "__main__":
    snakemake: Job
    with job_log(snakemake.log[0]) as log:
        run_page(snakemake.input.page, Path(snakemake.params.root), Path(snakemake.output[0]), log)
