"""Snakemake in a process of its own, forked from one that has imported it: a start of 4 s of processor time takes half of it."""

from __future__ import annotations

import multiprocessing
import os
import subprocess
import sys
import tempfile
from pathlib import Path

SERVER = multiprocessing.get_context("forkserver")
SERVER.set_forkserver_preload(["snakemake.cli", "sph.jobs.catalogue", "sph.figures", "sph.page.sections"])
"""What the Snakefile imports; a module that is not there any more costs time and nothing else."""


def _main(arguments: list[str], folder: Path, environment: dict[str, str], said: tuple[str, str]) -> None:
    from snakemake.cli import main

    for number, name in enumerate(said, 1):
        os.dup2(os.open(name, os.O_WRONLY), number)
    os.environ.clear()
    os.environ.update(environment)
    os.chdir(folder)
    sys.argv = ["snakemake", *arguments]
    main()


def snakemake_in(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    """What ``subprocess.run`` gives of ``python -m snakemake`` in a folder."""
    with tempfile.NamedTemporaryFile("r") as out, tempfile.NamedTemporaryFile("r") as err:
        process = SERVER.Process(target=_main, args=(arguments, folder, dict(os.environ), (out.name, err.name)))
        process.start()
        process.join()
        return subprocess.CompletedProcess(["snakemake", *arguments], process.exitcode, out.read(), err.read())
