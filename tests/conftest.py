"""Small scenes shared by the solver's tests, built through ``make_scene`` like any other."""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # before NumPy: beside other workers its threads wait for each other, and spin

import sys
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace

import pytest
from hypothesis import settings
from numba.core.dispatcher import Dispatcher
from small_scenes import FREE_BLOCK, SLOPE, SceneBuilder
from synthetic import synthetic, translation

from sph.output.run import Run
from sph.scene.configuration import dotted, merge
from sph.scene.schema import make_scene
from sph.solver.compiled import slots
from sph.solver.simulation import Simulation

# On CI the same examples every time, so that a red run is the change's fault; elsewhere hypothesis explores.  A busy machine fails none.
settings.register_profile("ci", derandomize=True, deadline=None)
settings.register_profile("anywhere else", deadline=None)
settings.load_profile("ci" if os.environ.get("CI") else "anywhere else")


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--scenes", type=int, default=500, help="scenes that the relations between answers are tried on, in the long tests")


def pytest_ignore_collect(collection_path: Path, config: pytest.Config) -> bool | None:
    """Where only the long tests are asked for, files without any are not imported: each worker imports all the others."""
    only_long = config.getoption("markexpr") == "long" and collection_path.name.startswith("test_") and collection_path.suffix == ".py"
    return True if only_long and "mark.long" not in collection_path.read_text(encoding="utf-8") else None


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """The reference cases, which take longest, then files that run whole studies, so that no worker waits for them at the end."""
    items.sort(key=lambda item: (item.path.name != "test_cases.py", not {"workflow", "study"} & set(item.path.parts)))


@pytest.fixture(scope="session")
def small_slope() -> SceneBuilder:
    """Builder of ``SLOPE`` with dotted overrides."""
    return lambda overrides: make_scene(merge(SLOPE, dotted(overrides)))


@pytest.fixture(scope="session")
def free_block() -> SceneBuilder:
    """Builder of ``FREE_BLOCK`` with dotted overrides."""
    return lambda overrides: make_scene(merge(FREE_BLOCK, dotted(overrides)))


@pytest.fixture
def without_steps(monkeypatch: pytest.MonkeyPatch) -> None:
    """Simulations are prepared and make no step, so that none is compiled."""
    monkeypatch.setattr(Simulation, "advance_steps", lambda self, n_steps: {0: (0, 0)}[n_steps])


@pytest.fixture(autouse=True)
def _uncompiled(request: pytest.FixtureRequest) -> Iterator[None]:
    """In tests so marked the solver's functions are the Python that is written."""
    with pytest.MonkeyPatch.context() as patch:
        if request.node.get_closest_marker("uncompiled"):
            patch.setattr(slots, "numba", SimpleNamespace(config=SimpleNamespace(DISABLE_JIT=True)))
            solver = [module for name, module in sys.modules.items() if name.startswith("sph.solver")]
            for module in (*solver, request.module):
                compiled = {name: value for name, value in vars(module).items() if isinstance(value, Dispatcher)}
                for name, value in compiled.items():
                    patch.setattr(module, name, value.py_func)
        yield


@pytest.fixture
def standing() -> Run:
    """The paper's slope, shaken without any effect."""
    return synthetic()


@pytest.fixture
def slid() -> Run:
    """The paper's slope with all material above the toe moved by 3 m to the left between 4 and 8 s."""
    return synthetic(translation(-3.0))
