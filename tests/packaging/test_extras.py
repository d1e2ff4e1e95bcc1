"""The library works without packages of one use, and says which extra is missing where one is needed; and without what POSIX alone has."""

from __future__ import annotations

import subprocess
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest

from sph.scene.extras import of_extra

ROOT = Path(__file__).resolve().parents[2]
EXTRAS = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["optional-dependencies"]
ABSENT = {"SALib": "sensitivity", "sklearn": "sensitivity", "gstools": "uncertainty", "pystrata": "site", "snakemake": "workflow"}
POSIX = ("fcntl", "grp", "posix", "pty", "pwd", "resource", "syslog", "termios", "tty")
WITHOUT = f"""
import builtins, importlib, pkgutil, sys

taken = builtins.__import__


def without_posix(name, globals=None, *others, **named):
    if name in {POSIX} and (globals or {{}}).get("__name__", "").startswith("sph"):
        raise ImportError(f"{{globals['__name__']}} imports {{name}}")
    return taken(name, globals, *others, **named)


builtins.__import__ = without_posix
sys.modules |= dict.fromkeys({list(ABSENT)})
import numpy as np
import sph

for module in pkgutil.walk_packages(sph.__path__, "sph."):
    importlib.import_module(module.name)
from sph.experiments.sensitivity.surrogate import fit_surrogate
from sph.command.site import darendeli
from sph.scene.uncertain import RandomField

field = RandomField(horizontal_length=20.0, vertical_length=2.0)
calls = (
    lambda: fit_surrogate(np.zeros((3, 1)), np.zeros(3)),
    lambda: field.scores(1, np.zeros(1), np.zeros(1)),
    lambda: darendeli(0.0, 1.0),
)
for call in calls:
    try:
        call()
    except ValueError as error:
        print(error)
"""


def test_every_module_can_be_imported_without_them_and_their_use_names_the_extra() -> None:
    done = subprocess.run([sys.executable, "-c", WITHOUT], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    first, second, third = done.stdout.splitlines()
    assert 'sklearn is not installed; pip install -c constraints.txt -e ".[sensitivity]"' in first
    assert 'gstools is not installed; pip install -c constraints.txt -e ".[uncertainty]"' in second
    assert 'pystrata is not installed; pip install -c constraints.txt -e ".[site]"' in third


def test_the_extras_hold_what_they_are_named_for() -> None:
    assert {name.split(">")[0] for name in EXTRAS["sensitivity"]} == {"SALib", "scikit-learn"}
    assert [name.split(">")[0] for name in EXTRAS["uncertainty"]] == ["gstools"]
    assert [name.split(">")[0] for name in EXTRAS["site"]] == ["pystrata"]
    assert EXTRAS["workflow"][1:] == ["sph-slope[sensitivity,uncertainty]"] and EXTRAS["workflow"][0].startswith("snakemake>")
    assert any("workflow" in needed for needed in EXTRAS["test"])


def test_a_module_that_is_there_is_given() -> None:
    assert of_extra("math", "none").pi == np.pi
    with pytest.raises(ValueError, match="absent.*pip install"):
        of_extra("absent.part", "none")
