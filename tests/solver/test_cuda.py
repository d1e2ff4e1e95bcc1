"""The backend ``cuda``: in numba's simulator of a card the same as the processor's solver; compiled for a card; refused without one.

None of this needs a card; ``test_on_a_card.py`` does.
"""

from __future__ import annotations

import json
import math
import os
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from calling import call
from card_and_processor import CASES, scene_of
from small_scenes import PAPER

from sph.solver.backends import backend_of, run_many
from sph.solver.cuda import ensemble
from sph.solver.cuda.memory import Pack
from sph.solver.simulation import Simulation
from sph.solver.terms import KEYS, wanted_terms
from sph.storage import trajectory

HERE = Path(__file__).parent
NEEDED = pytest.mark.skipif(ensemble.find_spec("numba_cuda") is None, reason=f"numba-cuda is missing ({ensemble.INSTALL})")
LONG = pytest.mark.long


def simulated(script: str, *arguments: object) -> str:
    """What a script prints whose card is numba's simulator."""
    paths = os.pathsep.join(map(str, (HERE, HERE.parent, HERE.parents[1])))
    settings = {"NUMBA_ENABLE_CUDASIM": "1", "NUMBA_DISABLE_JIT": "1", "PYTHONPATH": paths}
    done = subprocess.run(
        [sys.executable, str(HERE / script), *map(str, arguments)], env=os.environ | settings, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


@NEEDED
@pytest.mark.parametrize("case", ["paper", *(pytest.param(case, marks=LONG) for case in CASES if case != "paper")])
def test_the_simulated_card_does_what_the_processor_does(case: str) -> None:
    found = json.loads(simulated("card_and_processor.py", case))[case]
    assert max(found["differences"].values()) < 1e-12
    assert found["failed"] > 10, "soil that fails, for the test to mean something"
    assert all(pairs > 5 and candidates > 3 for pairs, candidates in found["renewed"])
    assert len(found["rooms"]) > 1, "rows that had no room for all neighbours"


@NEEDED
@LONG
def test_runs_of_a_batch_are_written_go_on_and_know_what_made_them(tmp_path: Path) -> None:
    simulated("batch_on_card.py", tmp_path)
    for name in ("short", "long"):
        whole, again = (trajectory.read(tmp_path / folder / f"{name}.nc") for folder in ("whole", "again"))
        assert whole.attrs["backend"] == again.attrs["backend"] == "cuda"
        assert whole.attrs["status"] == again.attrs["status"] == "unfailed"
        for variable in ("x", "velocity_y", "stress_yy", "kinetic_energy", "dissipated_energy"):
            assert whole[variable].values.tobytes() == again[variable].values.tobytes(), variable
        by_processor = trajectory.read(tmp_path / f"{name}.nc")
        assert "backend" not in by_processor.attrs
        for variable in ("x", "velocity_y", "stress_yy", "kinetic_energy", "elastic_energy", "time_step_limit"):
            there = by_processor[variable].values
            assert np.abs(whole[variable].values - there).max() <= 1e-12 * max(np.abs(there).max(), 1e-30), variable


def test_every_term_stands_in_a_case() -> None:
    wanted = [wanted_terms(scene_of(case)) for case in CASES]
    assert all(any(case[term] for case in wanted) for term in KEYS)


@NEEDED
@LONG
@pytest.mark.parametrize(("case", "precision"), [(case, "double" if case == "paper" else "mixed") for case in CASES])
def test_the_kernel_compiles_without_a_card(case: str, precision: str, monkeypatch: pytest.MonkeyPatch) -> None:
    if ensemble.find_spec("nvidia") is None:
        pytest.skip(f"NVIDIA's compiler is missing ({ensemble.INSTALL})")
    import numba
    from numba import cuda

    from sph.solver.cuda import kernel

    # numba-cuda asks the present card for what to compile functions of functions; here there is none.
    card = SimpleNamespace(compute_capability=(9, 0))
    monkeypatch.setattr("numba.cuda.dispatcher.get_current_device", lambda: card)
    scene = scene_of(case)
    simulation = Simulation(scene.model_copy(update={"numerics": scene.numerics.model_copy(update={"precision": precision})}))
    packs = ensemble.packs(kernel, simulation, 2, 40, 256)

    def array(kind: Any, dimensions: int) -> Any:
        return numba.types.Array(numba.from_dtype(np.dtype(kind)), dimensions, "C")

    own = [array("i8", 2), array("u4", 2), array("f8", 3)]
    held = [array(kind, len(shape)) for pack in packs for (kind, _), shape in zip(pack.keys, pack.shapes, strict=True)]
    ptx, _ = cuda.compile_ptx(kernel.make_kernel(*packs), numba.types.void(*own, *held), cc=(9, 0))
    assert ".entry" in ptx and ".extern .func" not in ptx, "nothing is called that is not there"


def test_runs_wait_for_each_other_and_not_for_those_that_are_over(monkeypatch: pytest.MonkeyPatch) -> None:
    on, launches = ensemble.Ensemble(3, cuda=object()), []

    def launch() -> np.ndarray:
        launches.append(len(on.asked))
        return np.array([on.asked.get(place, (0, 0))[1] for place in range(3)])

    def asks(steps: int) -> list[int]:
        member: Any = object()
        return [on.advance(member, 5 * step, 5) for step in range(steps)]

    def fail() -> None:
        raise ValueError("a time step above its limit")

    monkeypatch.setattr(on, "_advance", launch)
    short, long, failed = on.carry([lambda: asks(2), lambda: asks(4), fail])
    assert short == [5] * 2 and long == [5] * 4 and isinstance(failed, ValueError)
    assert launches == [2, 2, 1, 1]


# ---------------------------------------------------------------- memory


class Memory:
    """An array of a card, without a card."""

    def __init__(self, shape: tuple[int, ...], kind: Any) -> None:
        self.held = np.zeros(shape, kind)

    def copy_to_device(self, array: np.ndarray) -> None:
        self.held[...] = array

    def copy_to_host(self, array: np.ndarray) -> None:
        array[...] = self.held


def test_a_record_comes_back_from_a_pack_as_it_was_put() -> None:
    simulations = [Simulation(scene_of("states", number), enforce_limit=False) for number in range(2)]
    pack = Pack("run", simulations[0].state, 2)
    pack.allocate(SimpleNamespace(device_array=Memory, pinned_array=np.empty))
    for number, simulation in enumerate(simulations):
        for array in simulation.state:
            array[...] = np.random.default_rng(number).integers(0, 2, array.shape)
    records = [pack.views(number, simulation.state) for number, simulation in enumerate(simulations)]
    pack.up()
    for array in pack.host:
        array[...] = 0
    pack.down()
    for simulation, record in zip(simulations, records, strict=True):
        assert type(record) is type(simulation.state)
        assert all(map(np.array_equal, record, simulation.state))
    assert pack.size == sum(array.nbytes for array in pack.host)
    assert len(pack.arguments) < 8, "few arguments of the kernel, however many terms a scene has"


def test_runs_that_do_not_fit_are_refused_with_numbers() -> None:
    def card(free: float) -> Any:
        return SimpleNamespace(current_context=lambda: SimpleNamespace(get_memory_info=lambda: (free, math.inf)))

    wanted: Any = [SimpleNamespace(size=300 * 2**20)]
    ensemble.check_memory(card(math.inf), wanted, 3)
    with pytest.raises(ValueError, match=r"300 MiB .* for 3 runs, 100 MiB each, .* 250 MiB .* 90% .* at most 2 such scenes"):
        ensemble.check_memory(card(250 * 2**20), wanted, 3)
    with pytest.raises(ValueError, match="larger numerics.spacing, or backend: cpu"):
        ensemble.check_memory(card(50 * 2**20), wanted, 3)


# ---------------------------------------------------------------- refusals


def test_a_backend_that_is_not_there_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    assert backend_of("cpu") is None
    with pytest.raises(ValueError, match="backend: 'opencl'.*cpu.*cuda"):
        backend_of("opencl")
    monkeypatch.setattr(ensemble, "find_spec", lambda name: None)
    for use in (lambda: backend_of("cuda"), lambda: run_many([scene_of("paper")])):
        with pytest.raises(ValueError, match=r"numba-cuda, which is not installed; pip install .*\[cuda\]"):
            use()
    assert "not installed" in ensemble.describe_card()
    refused = call("run", PAPER, "--backend", "cuda")
    assert refused.exit_code == 2 and "numba-cuda, which is not installed" in refused.stderr
    monkeypatch.setattr(ensemble, "find_spec", lambda name: object())
    absent = SimpleNamespace(is_available=lambda: False, cuda_error=lambda: "no driver")
    monkeypatch.setattr(ensemble, "import_module", lambda name: absent)
    with pytest.raises(ValueError, match=r"finds no card of NVIDIA with its driver \(no driver\)"):
        backend_of("cuda")


def test_files_of_a_batch_are_different_ones(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="paths: 1 different ones for 2 scenes"):
        run_many([scene_of("paper")] * 2, paths=[tmp_path / "one.nc"] * 2)
