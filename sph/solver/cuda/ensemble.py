"""Runs that advance together on a card, each of them a ``Simulation`` like any other.

A run's own code (stages, recording, guard, checkpoints) is that of ``sph.solver.run``.  Only ``advance_steps`` is another: it hands the
request in and waits until every run of the ensemble has done so or is over; then one launch serves all.  State goes to the card before
a launch and comes back after it, into memory that the card reads and writes itself, so that what records, restarts or goes back need not
know where it was made.  Lists of neighbours stay on the card.  What is seldom asked of them (the limit of the time step at frames) is
made on the processor from the state, as by a restart.

Only one of the threads that carry the runs is awake at a time: it wakes the next when it waits in ``advance`` or is over, and the last
one launches.
"""

from __future__ import annotations

import functools
import math
import os
import threading
import time as clock
from collections import deque
from collections.abc import Callable, Sequence
from importlib import import_module
from importlib.util import find_spec
from typing import Any

import numpy as np

from sph.scene.loading import Loading
from sph.scene.schema import Scene
from sph.solver.compiled.threads import make_team
from sph.solver.cuda.memory import Pack, structure
from sph.solver.neighbours import Candidates, allocate_pairs, find_candidates
from sph.solver.renewal import LOST, make_lists
from sph.solver.simulation import Saved, Simulation
from sph.solver.state import FAILED, REPULSION
from sph.solver.terms import of_pairs

THREADS = 256
"""Threads of a block."""
REGISTERS = 128
"""Registers of a thread: two blocks fit a multiprocessor."""
PLACES = ("start", "end", "close_end", "alike_end")
"""What of pairs are places among them."""
SPARE = 1.25
"""Room of a row over the longest one there is."""
SHARE = 0.9
"""Share of the card's free memory that is used."""
MIB = 2**20
INSTALL = 'pip install -c constraints.txt -e ".[cuda]"'


def card() -> Any:
    """The module ``numba.cuda``; ValueError with the remedy where there is no card or what drives it is not installed."""
    if find_spec("numba_cuda") is None:
        raise ValueError(f"backend: cuda needs numba-cuda, which is not installed; {INSTALL}, or use backend: cpu")
    cuda: Any = import_module("numba.cuda")
    if not cuda.is_available():
        why = cuda.cuda_error()
        raise ValueError(f"backend: cuda finds no card of NVIDIA with its driver ({why or 'none is there'}); use backend: cpu")
    return cuda


def simulated() -> bool:
    """Whether the card is numba's simulator, which runs one block after the other and knows no registers."""
    return os.environ.get("NUMBA_ENABLE_CUDASIM") == "1"


def describe_card() -> str:
    """The card in words, or why there is none."""
    try:
        cuda = card()
    except ValueError as error:
        return str(error)
    if simulated():
        return "numba's simulator"
    free, total = cuda.current_context().get_memory_info()
    name = cuda.get_current_device().name
    return f"{name.decode() if isinstance(name, bytes) else name}, {free / 2**30:.1f} of {total / 2**30:.1f} GiB free"


class CardSimulation(Simulation):
    """A run of an ensemble."""

    backend = "cuda"

    def __init__(self, scene: Scene, ensemble: Ensemble, enforce_limit: bool = True) -> None:
        super().__init__(scene, 1, enforce_limit)
        self.ensemble = ensemble
        self.listed = -1
        """step at which the processor's lists were made, in steps of the launch"""
        self.on_card = False
        """whether the card has its lists of neighbours"""

    def load_variant(self) -> None:
        """Nothing: the kernel is compiled at the first launch."""

    def advance_steps(self, n_steps: int) -> tuple[int, int]:
        """Advance by a number of the scene's time steps; how many particles failed, and how many steps were made."""
        failed, asked = np.count_nonzero(self.state.phase == FAILED), clock.perf_counter()
        done = self.ensemble.advance(self, self.step * self.substeps, n_steps * self.substeps)
        self.waited += clock.perf_counter() - asked - self.ensemble.share
        self.steps_made += done
        made = done // self.substeps
        self.step += made
        return int(np.count_nonzero(self.state.phase == FAILED) - failed), made

    def measure_limit(self, iterations: int) -> None:
        """Measure the limit of the time step as the particles lie."""
        self.renew_lists()
        super().measure_limit(iterations)

    def mean_neighbours(self) -> float:
        """Mean number of neighbours."""
        self.renew_lists()
        return super().mean_neighbours()

    def renew_lists(self) -> None:
        """Bring the processor's lists up to the state."""
        if self.listed != self.steps_made:
            self.candidates, self.pairs = make_lists(self.state, self.list_terms)
            self.listed = self.steps_made

    def go_back(self, saved: Saved) -> None:
        """Go back to an earlier step."""
        super().go_back(saved)
        self.on_card, self.listed = False, -1


class Ensemble:
    """``size`` runs of one variant of the solver and one number of particles.  Each has a thread of its own, or one that of the caller."""

    name = "cuda"

    def __init__(self, size: int, threads: int | None = None, cuda: Any = None) -> None:
        self.cuda = card() if cuda is None else cuda
        self.threads = threads or THREADS
        self.members: list[Any] = [None] * size
        self.batons = [threading.Semaphore(0) for _ in range(size)]
        """what the thread of each run waits for"""
        self.turn = 0
        """the run whose thread is awake"""
        self.ready: deque[int] = deque()
        """runs that can go on, in turn"""
        self.asked: dict[int, tuple[int, int]] = {}
        self.share = 0.0
        """wall time of the last launch, for each run that it served, s"""
        self.failure: BaseException | None = None
        self.kernel: Any = None
        self.run_pack: Any = None
        self.fixed_pack: Any = None
        self.list_pack: Any = None
        self.room = self.blocks = self.launched = 0
        self.rooms: list[int] = []
        """neighbours for whom a row has had room, in turn"""
        self.fixed_of: list[Any] = [None] * size
        self.records: list[Any] = [None] * size
        """what the card changes of each run: state and works, in the memory from which it is copied to the card"""
        self.told: list[tuple[np.ndarray, Any]] = []
        """what goes to and fro at each launch, here and on the card"""
        self.renewed = np.zeros((size, 2), np.int64)
        """how often pairs and candidates of each run have been renewed"""

    def simulation(self, scene: Scene, enforce_limit: bool = True) -> CardSimulation:
        """A scene's simulation that advances with the others."""
        return CardSimulation(scene, self, enforce_limit)

    def carry(self, calls: Sequence[Callable[[], Any]]) -> list[Any]:
        """Results of functions that run the members, one a member, in order; an exception of one is in its place."""
        found: list[Any] = [None] * len(calls)

        def run(number: int) -> None:
            self._wait(number)
            try:
                found[number] = calls[number]()
            except BaseException as error:
                found[number] = error
            finally:
                self._wake()

        carriers = [threading.Thread(target=run, args=(number,), daemon=True) for number in range(len(calls))]
        for carrier in carriers:
            carrier.start()
        self.ready.extend(range(len(calls)))
        self._wake()
        try:
            for carrier in carriers:
                while carrier.is_alive():
                    carrier.join(0.1)
        except BaseException as error:
            self.failure = error
            raise
        self._release()
        return found

    def advance(self, member: CardSimulation, first: int, count: int) -> int:
        """Steps that the run whose turn it is has made of ``count`` from step ``first`` on, once all have asked."""
        place = self.turn
        self.members[place], self.asked[place] = member, (first, count)
        self._wake()
        self._wait(place)
        if self.failure is not None:
            raise RuntimeError(f"the runs on the card ended: {self.failure}") from self.failure
        return int(self.done[place])

    def _wait(self, place: int) -> None:
        """Sleep until it is the turn of the run in a place."""
        self.batons[place].acquire()
        self.turn = place

    def _wake(self) -> None:
        """Wake the next run that can go on; where all have asked, launch, so that they can."""
        if not self.ready and self.asked:
            began = clock.perf_counter()
            try:
                self.done = self._advance()
            except BaseException as error:
                self.failure = error
            self.share = (clock.perf_counter() - began) / len(self.asked)
            self.ready.extend(self.asked)
            self.asked = {}
        if self.ready:
            self.batons[self.ready.popleft()].release()

    # ------------------------------------------------------------ the card

    def _advance(self) -> np.ndarray:
        """Make the steps that are asked for; how many each run has made."""
        from sph.solver.cuda import kernel as card_code

        done, kicked = np.zeros(len(self.members), np.int64), np.zeros(len(self.members), np.int64)
        left = {place: asked for place, asked in self.asked.items() if asked[1] > 0}
        while left:
            self._make_room(card_code)
            asked = np.zeros((len(self.members), 4), np.int64)
            for place, (first, count) in left.items():
                member = self.members[place]
                asked[place] = first + done[place], count - done[place], kicked[place], not member.on_card
            told = self._launch(card_code, asked, left)
            kicked[:] = 0
            self.renewed += told[:, [card_code.RENEWED, card_code.FOUND]]
            for place in list(left):
                done[place] += told[place, card_code.DONE]
                ended = told[place, card_code.ENDED]
                if ended == card_code.FULL:
                    # Its step was kicked unless its lists had no room from the start.
                    kicked[place] = told[place, card_code.FOUND] > 0 or asked[place, card_code.KICKED]
                    self.room = 0
                else:
                    del left[place]
                    assert ended == LOST or done[place] == self.asked[place][1]
        return done

    def _make_room(self, card_code: Any) -> None:
        """Allocate the memory of the card, for rows longer than any there is, unless there is enough."""
        if self.room:
            return
        members = [self.members[place] for place in self.asked]
        self._release()
        self.room = max(map(room_of, members))
        self.rooms.append(self.room)
        self.blocks, self.launched = blocks_of(members[0], self.threads), 0
        wanted = packs(card_code, members[0], len(self.members), self.room, self.blocks * self.threads)
        check_memory(self.cuda, wanted, len(self.members))
        self.run_pack, self.fixed_pack, self.list_pack = wanted
        for pack in wanted:
            pack.allocate(self.cuda, on_host=pack is not self.list_pack)
        self.fixed_of, self.records = [None] * len(self.members), [None] * len(self.members)
        for member in members:
            member.on_card = False

    def _launch(self, card_code: Any, asked: np.ndarray, left: Any) -> np.ndarray:
        runs, cuda = len(self.members), self.cuda
        longest = int(asked[:, card_code.COUNT].max())
        changed = False
        self._make_told(card_code, longest)
        (here, _), (waits, _), (loads, _) = self.told
        here[:], waits[:] = np.hstack((asked, np.zeros_like(asked))), 0
        for place in left:
            member = self.members[place]
            at = asked[place, card_code.FIRST] + np.arange(asked[place, card_code.COUNT] + 1)
            for row, history in enumerate(member.loading):
                history.take(at, out=loads[place, row, : at.size], mode="wrap")  # before the first step stand the loads of NO_LOADING
            if self.records[place] is None or member.state is not self.records[place].state:
                self.records[place] = self.run_pack.views(place, run_record(card_code, member))
                member.state = self.records[place].state
            if self.fixed_of[place] is not member.terms:
                self.fixed_pack.put(place, fixed_record(card_code, member))
                self.fixed_of[place], changed = member.terms, True
        if changed:
            self.fixed_pack.up()
        self.run_pack.up()
        for array, there in self.told:
            there.copy_to_device(array)
        arguments = [*(there for _, there in self.told), *self.run_pack.card, *self.fixed_pack.card, *self.list_pack.card]
        if self.kernel is None:
            kernel = jitted(cuda, card_code.make_kernel(self.run_pack, self.fixed_pack, self.list_pack))
            self.kernel = kernel if simulated() else kernel.specialize(*arguments)
        self.launched = self.launched or self._blocks_a_run()
        self.kernel[(self.launched, runs), self.threads](*arguments)
        self.run_pack.down()
        self.told[0][1].copy_to_host(here)
        for place in left:
            member, work = self.members[place], self.records[place].work
            member.on_card = True
            member.state.work[:REPULSION] += work[:REPULSION].sum(axis=1)
            member.state.work[REPULSION] = work[REPULSION].sum()
        return here

    def _make_told(self, card_code: Any, steps: int) -> None:
        """Room for what is asked and told of each run, for what its threads wait by, and for its loads."""
        runs, cuda = len(self.members), self.cuda
        if not self.told or self.told[-1][0].shape[-1] <= steps:
            shapes = [((runs, 8), np.int64), ((runs, card_code.FLAGS), np.uint32), ((runs, len(Loading._fields), steps + 1), np.float64)]
            self.told = [(cuda.pinned_array(shape, kind), cuda.device_array(shape, kind)) for shape, kind in shapes]

    def _blocks_a_run(self) -> int:
        """Blocks of a run: as many as its particles fill, and as many as fit on the card at once, since they wait for each other."""
        if self.blocks == 1 or simulated():
            return 1
        (compiled,) = self.kernel.overloads.values()
        return max(1, min(self.blocks, compiled.max_cooperative_grid_blocks(self.threads) // len(self.members)))

    def _release(self) -> None:
        """Give the memory of the card back."""
        held, self.run_pack = self.run_pack is not None, None
        self.fixed_pack = self.list_pack = None
        self.room = 0
        if held and not simulated():
            self.cuda.current_context().deallocations.clear()


@functools.cache
def jitted(cuda: Any, function: Any) -> Any:
    """A kernel, which keeps what it has been compiled for."""
    return cuda.jit(function) if simulated() else cuda.jit(max_registers=REGISTERS)(function)


def run_record(card_code: Any, member: Simulation) -> Any:
    """What of a run the card changes."""
    return card_code.Run(member.state, np.zeros((REPULSION + 1, member.state.x.size)))


def fixed_record(card_code: Any, member: Simulation) -> Any:
    """What of a run the card reads."""
    terms = member.terms
    walls = terms.absorbing_walls
    meets = card_code.Meets(
        free_field=terms.free_field is not None,
        columns=walls is not None and walls.in_base > 0,
        mirror=terms.free_slip is not None,
        interface=terms.interface is not None,
        averages=terms.slip is not None or terms.seams is not None,
    )
    x, y, reach = member.particles.x, member.particles.y, terms.reach
    columns = int((x.max() - x.min()) / reach) + 1 if terms.periodic is None else int(terms.periodic.length / reach)
    grid = card_code.Grid(float(x.min()), float(y.min()), columns, int((y.max() - y.min()) / reach) + 1)
    return card_code.Fixed(terms, member.particles.mass, meets, grid)


def packs(card_code: Any, member: Simulation, runs: int, room: int, threads: int) -> tuple[Pack, Pack, Pack]:
    """Memory for runs like one: what changes, what does not, and lists with ``room`` neighbours a particle."""
    n, size = member.state.x.size, member.state.x.size * room
    rows = np.empty(n, np.uint32)
    candidates = Candidates(rows, rows, np.empty(size, np.uint32))
    (team,) = make_team(1, n, 1)
    fixed = fixed_record(card_code, member)
    pairs = allocate_pairs(candidates, member.terms.zero, of_pairs(member.terms))
    by_pair = tuple(name for name, array in pairs._asdict().items() if array.shape == (size,))
    # Rows side by side are laid for whole warps.
    rounded = -(-n // card_code.LANES) * card_code.LANES * room
    laid = [np.empty(rounded, getattr(pairs, name).dtype) for name in by_pair]
    places = tuple(name for name in PLACES if getattr(pairs, name, rows[:0]).size)
    lists = card_code.Lists(
        pairs,
        card_code.class_of_own(by_pair, places)(*laid, *(rows for _ in places)),
        candidates,
        np.empty(fixed.grid.columns * fixed.grid.rows, np.int32),
        np.empty(n, np.int32),
        team.gradient,
        team.strain_rate,
        team.reached,
        np.empty((threads, 3, room)),
    )
    return Pack("run", run_record(card_code, member), runs), Pack("fixed", fixed, runs), Pack("lists", lists, runs)


def room_of(member: Simulation) -> int:
    """Neighbours for whom a row has room: more than the candidates of any particle now."""
    state, terms = member.state, member.terms
    found = find_candidates(state.x_candidates, state.y_candidates, terms.reach, terms.periodic)
    return math.ceil(SPARE * int((found.end.astype(np.int64) - found.start).max()))


def blocks_of(member: Simulation, threads: int) -> int:
    """Blocks that give each particle a thread."""
    return -(-member.state.x.size // threads)


def free_memory(cuda: Any) -> int:
    """Free memory of the card, bytes."""
    return int(min(cuda.current_context().get_memory_info()[0], 2**62))


def check_memory(cuda: Any, wanted: Sequence[Pack], runs: int) -> None:
    """ValueError with numbers where the runs do not fit into the free memory of the card."""
    free, size = free_memory(cuda), sum(pack.size for pack in wanted)
    if size > SHARE * free:
        fit = int(SHARE * free / (size / runs))
        raise ValueError(
            f"backend: cuda needs {size / MIB:,.0f} MiB of the card's memory for {runs} runs, {size / runs / MIB:,.0f} MiB each, and of "
            f"{free / MIB:,.0f} MiB that are free {SHARE:.0%} are used; "
            + (f"run at most {fit} such scenes at a time" if fit else "choose a larger numerics.spacing, or backend: cpu")
        )


def memory_of(simulation: Simulation) -> tuple[Pack, Pack, Pack]:
    """Memory of the card for a run."""
    from sph.solver.cuda import kernel as card_code

    return packs(card_code, simulation, 1, room_of(simulation), blocks_of(simulation, THREADS) * THREADS)


def most_runs(simulation: Simulation) -> int:
    """How many runs like one the free memory of the card holds; ValueError with numbers where that is none."""
    cuda, wanted = card(), memory_of(simulation)
    check_memory(cuda, wanted, 1)
    return int(SHARE * free_memory(cuda) / sum(pack.size for pack in wanted))


def variant(simulation: Simulation) -> Any:
    """What runs that advance together have in common."""
    return structure(simulation.state), structure(simulation.terms)
