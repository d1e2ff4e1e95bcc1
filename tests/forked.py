"""Snakemake and the scripts of its jobs in processes of their own, forked from one that has imported what they need.

A start of Snakemake takes 0.4 s of processor time instead of 4, that of a job a third of its 2.5 s.  Scripts run as by
``python SCRIPT``, in a fork of Snakemake; ``tests/workflow/test_tutorial.py`` and the README's commands start them as users do.
"""

from __future__ import annotations

import multiprocessing
import os
import runpy
import subprocess
import sys
import tempfile
import traceback
from contextlib import nullcontext
from functools import cache
from multiprocessing import forkserver
from pathlib import Path
from typing import Any
from unittest.mock import patch

SERVER, FORK = multiprocessing.get_context("forkserver"), multiprocessing.get_context("fork")


def _main(arguments: list[str], folder: Path, environment: dict[str, str], said: tuple[str, str]) -> None:
    from snakemake.cli import main
    from snakemake.script import PythonScript

    for number, name in enumerate(said, 1):
        os.dup2(os.open(name, os.O_WRONLY | os.O_APPEND), number)
    os.environ.clear()
    os.environ.update(environment)
    os.chdir(folder)
    sys.argv = ["snakemake", *arguments]
    PythonScript._execute_cmd = _run_script
    main()


def _run_script(script: Any, command: str, *, fname: str, **_: Any) -> None:
    """What Snakemake calls in the place of a command that runs a script: with its benchmark, and the error of a command that fails."""
    from snakemake.benchmark import benchmarked

    process = FORK.Process(target=_as_command, args=(fname,))
    process.start()
    with benchmarked(process.pid, script.bench_record) if script.bench_record is not None else nullcontext():
        process.join()
    if process.exitcode:
        raise subprocess.CalledProcessError(process.exitcode, command)


def _as_command(name: str) -> None:
    """Run a script and end with its exit status, without taking down what the fork has of Snakemake's."""
    code = 1
    try:
        runpy.run_path(name, run_name="__main__")
        code = 0
    except SystemExit as asked:
        code = asked.code if isinstance(asked.code, int) else int(asked.code is not None)
    except BaseException:
        traceback.print_exc()
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)


@cache
def _start_server() -> None:
    SERVER.set_forkserver_preload(["preloaded", "forked"])
    # Python 3.11 does not hand sys.path on, and what the server does not find it leaves out without a word.
    with patch.dict(os.environ, PYTHONPATH=os.pathsep.join(sys.path)):
        forkserver.ensure_running()


def snakemake_in(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    """What ``subprocess.run`` gives of ``python -m snakemake`` in a folder."""
    _start_server()
    with tempfile.NamedTemporaryFile("r") as out, tempfile.NamedTemporaryFile("r") as err:
        process = SERVER.Process(target=_main, args=(arguments, folder, dict(os.environ), (out.name, err.name)))
        process.start()
        process.join()
        return subprocess.CompletedProcess(["snakemake", *arguments], process.exitcode, out.read(), err.read())
