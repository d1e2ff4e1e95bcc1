"""The public interface: what it is, that it is documented and annotated, and that naming it costs nothing."""

from __future__ import annotations

import ast
import doctest
import functools
import inspect
import subprocess
import sys
import typing
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
import xarray as xr
from pydantic import BaseModel

import sph
from sph.output.run import Run
from sph.solver.run import Result
from sph.storage.netcdf import Group
from sph.storage.trajectory import read_run, write

HEAVY = {"numba", "numpy", "pandas", "pydantic", "xarray"}
FOR_TYPE_CHECKERS = {"xr": xr}
"""The one name in annotations that modules import for type checkers only, since a job does without it; all others must be there."""


def functions(name: str) -> Iterator[Callable[..., Any]]:
    """A public function, or the public methods that a public class defines."""
    value = getattr(sph, name)
    if not isinstance(value, type):
        yield value
        return
    for part, member in vars(value).items():
        if isinstance(member, property):
            found = member.fget
        else:
            found = member.func if isinstance(member, functools.cached_property) else getattr(member, "__func__", member)
        if inspect.isfunction(found) and found.__module__ == value.__module__ and not part.startswith("_"):
            yield found


def lacking(function: Callable[..., Any]) -> set[str]:
    """What a reader misses: the docstring, types of arguments or result."""
    missing = set() if inspect.getdoc(function) else {"docstring"}
    parameters = set(inspect.signature(function).parameters) - {"self"}
    return missing | ((parameters | {"return"}) - set(typing.get_type_hints(function, localns=FOR_TYPE_CHECKERS)))


def test_the_example_of_the_package_runs() -> None:
    found = doctest.testmod(sph)
    assert found.attempted >= 6 and not found.failed


def test_type_checkers_are_told_the_same_names() -> None:
    tree = ast.parse(Path(sph.__file__).read_text(encoding="utf-8"))
    told = {name.asname: node.module for node in ast.walk(tree) if isinstance(node, ast.ImportFrom) for name in node.names if name.asname}
    assert told == sph._HOMES and sph.__all__ == [*sph._HOMES]
    assert Path(sph.__file__).with_name("py.typed").exists()


@pytest.mark.parametrize("name", sph.__all__)
def test_public_names_are_documented_and_annotated(name: str) -> None:
    assert f"`{name}`" in (sph.__doc__ or "") or isinstance(getattr(sph, name), type), "the docstring of the package leaves it out"
    text = inspect.getdoc(getattr(sph, name)) or ""
    assert text and text != inspect.getdoc(BaseModel) and not text.startswith(f"{name}("), "a generated docstring says nothing"
    assert {function.__qualname__: lacking(function) for function in functions(name) if lacking(function)} == {}


def test_a_name_that_is_not_public_is_refused() -> None:
    with pytest.raises(AttributeError, match="simulate"):
        _ = sph.simulate  # type: ignore[attr-defined]


@pytest.mark.parametrize("module", ["sph", "sph.command.cli"])
def test_nothing_heavy_is_imported_before_it_is_needed(module: str) -> None:
    code = f"import sys, {module}; print(*sys.modules)"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    assert module in loaded and not HEAVY & set(loaded)


def test_dir_shows_what_is_public_only() -> None:
    code = "import sph, sph.command.cli, sph.scene.schema; print(*dir(sph))"
    shown = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    assert {name for name in shown if not name.startswith("__")} == set(sph.__all__)


def test_a_run_is_drawn_from_memory_and_from_its_file(tmp_path: Path, slid: Run) -> None:
    path, picture = tmp_path / "run.nc", tmp_path / "run.png"
    write(path, slid.stored.assign_attrs(particle_steps=1))
    drawn = [sph.plot(run, picture) for run in (slid.trajectory, path, str(path), Result(read_run(path), Group({}), "complete"))]
    assert picture.read_bytes().startswith(b"\x89PNG") and all(len(figure.axes) == 3 for figure in drawn)
    with pytest.raises(ValueError, match="colour"):
        sph.plot(slid.trajectory, field="colour")
