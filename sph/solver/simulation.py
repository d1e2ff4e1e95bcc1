"""The particles of a scene under way: state, neighbour lists, and the steps that advance them."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from sph.scene.loading import Loading, make_loading
from sph.scene.schema import MAX_STEPS, Scene
from sph.solver.compiled.jit import cache_folder, compile_lock
from sph.solver.compiled.threads import make_team, together
from sph.solver.initial_state import initial_state
from sph.solver.initial_stress import NO_LOADING, impose_stress
from sph.solver.integration import advance
from sph.solver.neighbours import Candidates
from sph.solver.particles import Particles, place_particles
from sph.solver.physics.coupling import cauchy_stress, elastic_energy
from sph.solver.physics.cyclic_pore_pressure import soften_soil
from sph.solver.physics.interface import once_lost
from sph.solver.physics.prescribed_motion import stopped
from sph.solver.renewal import make_lists, renew_candidates
from sph.solver.state import FAILURES, INTERNAL
from sph.solver.terms import State, Terms, make_terms, of_pairs, only, wanted_terms
from sph.solver.time_step import PresentLimit, check_time_step, mode_of, stiffest_frequency

FIRST_POWER_ITERATIONS, POWER_ITERATIONS = 60, 6
"""Power iterations that measure the limit of the time step, at the start and at every frame."""


class Saved(NamedTuple):
    """A simulation at an earlier step."""

    state: State
    candidates: Candidates
    step: int


class Simulation:
    """State and lists of one scene, and its time steps."""

    backend = "cpu"

    def __init__(self, scene: Scene, threads: int = 1, enforce_limit: bool = True) -> None:
        self.scene = scene
        self.enforce_limit = enforce_limit
        self.particles: Particles = place_particles(scene)
        self.terms = make_terms(scene, self.particles)
        self.loading: Loading = make_loading(scene)
        self.state: State = initial_state(self.particles, scene)
        impose_stress(self.state, scene, self.particles, self.terms.n_stressed)
        self.wanted = wanted_terms(scene)
        self.team = make_team(threads, self.particles.x.size, FAILURES + 1)
        self.step = 0
        self.substeps = 1
        self.limit = math.inf
        self.steps_made = 0
        self.waited = 0.0
        """wall time that went to other runs, s"""

    @property
    def time(self) -> float:
        """Simulated time, s."""
        return self.step * self.scene.numerics.time_step

    def prepare(self) -> None:
        """Check the time step, compile or load the variant this scene needs, and make the neighbour lists."""
        with compile_lock():
            if self.enforce_limit:
                check_time_step(self.scene)
            self.present_limit = PresentLimit(self.scene)
            self.candidates, self.pairs = make_lists(self.state, self.list_terms)
            self.measure_limit(FIRST_POWER_ITERATIONS if self.step == 0 else 0)
            self.elastic_energy()
            self.cauchy_stress()
        self.load_variant()
        if self.enforce_limit and self.step == 0 and self.scene.numerics.adaptive_step is None and self.terms.dt >= self.limit:
            raise ValueError(
                f"numerics.time_step: {self.terms.dt:g} s exceeds the limit measured on the particles at the start, {self.limit:.3g} s; "
                "choose a smaller step"
            )

    def load_variant(self) -> None:
        """Compile or load ``advance`` for this scene."""
        with compile_lock(str(self.wanted)):
            self.advance_steps(0)

    def advance_steps(self, n_steps: int) -> tuple[int, int]:
        """Advance by a number of the scene's time steps; how many particles failed, and how many steps were made."""
        failed = 0
        first, last = self.step * self.substeps, (self.step + n_steps) * self.substeps
        step, kicked = first, False
        while True:
            new, done, spent, compiled = together(
                advance, self.team, self.state, self.candidates, self.pairs, self.terms, self.particles.mass,
                self.loading, step, last - step, kicked,
            )[0]  # fmt: skip
            if compiled != tuple(self.wanted.values()):
                raise RuntimeError(
                    f"the compiled solver holds the terms {dict(zip(self.wanted, compiled, strict=True))}, the scene wants "
                    f"{self.wanted}; delete the cache folder {cache_folder()} and run again"
                )
            failed, step = failed + new, step + done
            if not spent:
                break
            self.candidates, self.pairs = renew_candidates(self.state, self.list_terms, self.pairs)
            kicked = True
        self.steps_made += step - first
        made = (step - first) // self.substeps
        self.step += made
        return failed, made

    def measure_limit(self, iterations: int) -> None:
        """Measure the limit of the time step as the particles lie."""
        frequency = stiffest_frequency(
            mode_of(self.state),
            self.pairs,
            only(self.terms, "gradient_correction", "layers", "no_slip")._replace(interface=once_lost(self.terms.interface)),
            self.team[0].gradient,
            iterations,
        )
        if iterations:
            self.limit = self.present_limit.seconds(frequency)

    def mean_neighbours(self) -> float:
        """Mean number of neighbours."""
        return float((self.pairs.end - self.pairs.start).mean())

    def adapt(self) -> str:
        """Divide the time step so that it keeps to the limit, if the scene wants that; why the run cannot go on, or empty."""
        adaptive = self.scene.numerics.adaptive_step
        if adaptive is None:
            return ""
        longest = adaptive.courant * self.limit
        if self.most_substeps * longest < self.scene.numerics.time_step:
            return f"the limit of the time step fell to {self.limit:.3g} s at {self.time:.4f} s"
        self.divide(max(1, math.ceil(self.scene.numerics.time_step / longest)))
        return ""

    @property
    def most_substeps(self) -> int:
        """Parts into which a time step may be divided."""
        return 1 if self.scene.numerics.adaptive_step is None else MAX_STEPS // self.scene.steps(self.scene.duration)

    def divide(self, substeps: int) -> None:
        """Divide the scene's time step into so many."""
        if substeps != self.substeps:
            self.substeps = substeps
            self.terms = make_terms(self.scene, self.particles, substeps)
            self.loading = make_loading(self.scene, substeps)

    def balance(self) -> None:
        """Make the initial stress act from the first kick on: a step without loads, before the first, in which nothing moves.

        It returns the stress to the yield surface and computes the accelerations.  The energy stored so far counts as work done.
        """
        loading, terms, velocity = self.loading, self.terms, (self.state.vx.copy(), self.state.vy.copy())
        self.loading, self.terms = NO_LOADING, terms._replace(prescribed_motion=stopped(terms.prescribed_motion))
        self.state.vx[:] = self.state.vy[:] = 0.0
        self.step = -1
        self.advance_steps(1)
        self.step, self.loading, self.terms = 0, loading, terms
        self.state.vx[:], self.state.vy[:] = velocity
        self.state.work[INTERNAL] = self.elastic_energy()

    @property
    def list_terms(self) -> Terms:
        """The terms that the lists of neighbours depend on."""
        return of_pairs(self.terms)

    def elastic_energy(self) -> float:
        """Energy stored in the blended stress, J/m."""
        if self.terms.cyclic_pore_pressure is not None:  # its table is new where the step or the run is
            soften_soil(self.terms.cyclic_pore_pressure, self.terms.layers, self.state, 0, self.state.x.size)
        return float(elastic_energy(self.state, only(self.terms, "layers")))

    def cauchy_stress(self) -> np.ndarray:
        """Stress (n, 4) xx, yy, zz, xy of Eq. 8, Pa, tension positive."""
        stress = np.empty((self.state.x.size, 4))
        cauchy_stress(self.state, only(self.terms, "layers"), stress)
        return stress

    def saved(self) -> Saved:
        """A copy of what a step changes."""
        return Saved(State(*(a.copy() for a in self.state)), self.candidates, self.step)

    def go_back(self, saved: Saved) -> None:
        """Go back to an earlier step."""
        self.state, self.candidates, self.step = saved
