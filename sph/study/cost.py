"""What a scene needs: computing time, memory and disk space, predicted before it is run.

Computing time is a sum of four parts, each with a constant of the reference machine (one core of the machine that measured
the cost-accuracy study, two runs side by side).  The constants were fitted to the 78 timed variants of
``measured/cost-accuracy.csv`` (least squares of the logarithms, outliers damped): half of them are met within 4 %, eight in ten between
-8 % and +7 %; the worst are 0.61 and 1.24 times the measured time.  The 0.61 is the finest run, 1/6 m: it was measured beside other work,
and the constants know nothing of memory, which is slower than the cache (0.83 at 0.25 m).  Steps that an adaptive step adds are counted
in whole parts of the scene's step: with h of 2.3 spacings on ten and fifteen rows of particles that was 40 and 27 % too many.

* a directed neighbour and a particle in a time step;
* the renewal of a directed neighbour's gradient, whenever the fastest debris has moved by ``numerics.gradient_tolerance``; it is taken
  to travel the height of the slope once;
* a sample of the series, and at every frame the measurement of the time step's limit.

Soil that can soften is taken to fail once the gravity stage is over, so that all is an upper estimate where nothing fails.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from sph.checks.layers import own_spacings
from sph.checks.step_limits import step_limits
from sph.scene.schema import Scene
from sph.solver.particles import place_particles
from sph.solver.simulation import POWER_ITERATIONS
from sph.stability.extrapolation import at_spacing
from sph.stability.record import SEARCHES
from sph.stability.standing import FailureRule, leaves_solid_state, static_scene
from sph.study.runs import SIMULATION, Kind, PlannedRun

RECONSTRUCTED = 1.95
"""Times that a step takes with linear reconstruction in the artificial viscosity (measured: 1.96 and 1.94 with 19 and 60 neighbours)."""
NEIGHBOUR, PARTICLE, RENEWAL, SAMPLE = 1.313e-9, 37.88e-9, 4.443e-9, 141.3e-6
"""Seconds of a directed neighbour, a particle, the renewal of a neighbour's gradient, and a sample."""
STIFFENING = 0.75
"""Frequency of debris over that of the lattice, times spacing over smoothing length: 1.7 at h = 2.3 spacings, the mean over a collapse."""
PROCESS, COMPILER = 250.0, 500.0
"""MiB of a process with its libraries, and of one that compiles the solver (measured)."""
BYTES_OF_NEIGHBOUR, BYTES_OF_STORED = 60, 145
"""Bytes of memory of a directed neighbour, with its particle's share, and of a particle at a frame (measured, whole process)."""
FILED, FILED_STATE, FILED_SAMPLE = 32, 200, 80
"""Bytes of a file, compressed: a particle at a frame of a moving slope, its restart state, a sample of the series (measured)."""
TRIALS = 13
"""Static tests of a search to 1 % (measured on the paper's slope)."""
TRIALS_NEAR, TRIALS_STRONGER = 6, 9
"""Static tests at the fine spacing, around what the coarse search found, and of the search for the sensitivity (measured, as above)."""
START, COMPILE = 5.0, 8.0
"""Seconds that a job takes beside its computing (libraries, compiled code, files), and that a variant takes to be compiled (measured)."""
CARD_STEP, CARD_RATE = 78e-6, 319e6
"""Seconds of a step on a card however few particles there are, and particle-steps a second of many: of 1 and 64 runs of the paper's slope,
200 steps a launch (measured on an H200)."""
CARD_START = 33.0
"""Seconds in which a process compiles the kernel of a card (measured there: 30 to 36)."""
TAKE_UP = 0.5
"""Seconds of a job that takes up the run that another one has made (measured)."""
MIB = 2.0**20
ON_REFERENCE = "on one core of the reference machine"
"""Whose times these are, in words."""


class Cost(NamedTuple):
    """What a run, or a part of one, asks for."""

    particles: int
    neighbours: float  # directed, of a particle inside the lattice
    steps: int  # made, those an adaptive step adds included
    seconds: float  # of computing on one core of the reference machine
    memory: float  # MiB of its process
    disk: float  # MiB of its file


def cost(scene: Scene, since: float = 0.0, until: float | None = None) -> Cost:
    """Cost of a scene from one simulated time to another, s; by default the whole run.  The file holds what came before, too."""
    until = scene.duration if until is None else until
    numerics, outputs, settled = scene.numerics, scene.outputs, scene.gravity.duration
    n = place_particles(scene).x.size
    neighbours = math.pi * (2 * numerics.smoothing_length / numerics.spacing) ** 2
    fails = any(leaves_solid_state(scene, material) for material in scene.materials)
    calm, debris = _substeps(scene, fails)
    before, after = max(min(until, settled) - since, 0.0), max(until - max(since, settled), 0.0)
    steps = scene.steps(before) * calm + scene.steps(after) * debris
    frames = (until - since) / outputs.frame_interval
    (_, toe), (_, crest) = scene.geometry.toe, scene.geometry.crest
    reach = numerics.gradient_tolerance * numerics.spacing
    renewed = min(steps, (crest - toe) / reach * fails * (after > 0)) if reach else steps
    viscosity = numerics.artificial_viscosity
    reconstructed = RECONSTRUCTED if viscosity is not None and viscosity.reconstruction == "linear" else 1.0
    a_step = n * (neighbours * NEIGHBOUR + PARTICLE) * reconstructed
    stored, sampled = n * (until / outputs.frame_interval + 1), until / outputs.series_interval + 1
    return Cost(
        particles=n,
        neighbours=neighbours,
        steps=steps,
        seconds=(steps + POWER_ITERATIONS * frames) * a_step
        + renewed * n * neighbours * RENEWAL
        + (until - since) / outputs.series_interval * SAMPLE,
        memory=PROCESS + (n * neighbours * BYTES_OF_NEIGHBOUR + stored * BYTES_OF_STORED) / MIB,
        disk=(stored * FILED + n * FILED_STATE + sampled * FILED_SAMPLE) / MIB,
    )


def job_cost(run: PlannedRun) -> Cost:
    """Cost of what the job of a run, stage or search computes itself: the shaking up to the first failure counts with the runs."""
    scene, settled = run.built, run.built.gravity.duration
    if run.kind == Kind.SEARCH or run.by != SIMULATION:
        return search_cost(scene)
    if run.kind == Kind.RUN:
        return cost(scene, since=settled if run.parent else 0.0)
    return cost(scene, *((0.0, settled) if run.kind == Kind.GRAVITY else (settled, settled + scene.outputs.series_interval)))


def search_cost(scene: Scene, extrapolates: bool = True) -> Cost:
    """Cost of the search for a yield acceleration of a scene, at two spacings if it ``extrapolates`` or at its own alone.

    Of a scene that has none it is that of the scene as it is.
    """
    key = scene.model_dump_json()
    if key not in _searches:
        _searches[key] = _search_costs(scene)
    return _searches[key][extrapolates]


_searches: dict[str, tuple[Cost, Cost]] = {}
"""At the own spacing and at two, by the scene: several jobs ask for the same."""


def _search_costs(scene: Scene) -> tuple[Cost, Cost]:
    rule, own = FailureRule(), scene.numerics.spacing
    try:
        coarse, fine = own_spacings(scene)
        tests = {spacing: cost(static_scene(at_spacing(scene, spacing), rule, acceleration=1.0)) for spacing in {own, coarse, fine}}
    except ValueError:
        return cost(scene), cost(scene)
    return _tests((TRIALS, tests[own])), _tests((TRIALS + TRIALS_STRONGER, tests[coarse]), (TRIALS_NEAR, tests[fine]))


def _tests(*tests: tuple[int, Cost]) -> Cost:
    """Cost of static tests, each so many times, the largest last."""
    # They stay in memory until Python gives them back: two at once have been seen.
    largest = tests[-1][1]
    return largest._replace(
        steps=sum(number * each.steps for number, each in tests),
        seconds=sum(number * each.seconds for number, each in tests),
        memory=2 * largest.memory,
        disk=0.1,
    )


def _substeps(scene: Scene, fails: bool) -> tuple[int, int]:
    """Steps made for a time step of the scene, in the gravity stage and after it: with debris where soil ``fails``."""
    numerics = scene.numerics
    if numerics.adaptive_step is None:
        return 1, 1
    limits = [limit.seconds for limit in step_limits(scene)]
    acoustic, smallest = limits[0], min(limits)
    stiffening = STIFFENING * numerics.smoothing_length / numerics.spacing if fails else 1.0
    debris = min(smallest, acoustic / max(stiffening, 1.0))
    calm, moving = (math.ceil(numerics.time_step / (numerics.adaptive_step.courant * limit) - 1e-9) for limit in (smallest, debris))
    return max(calm, 1), max(moving, 1)


class Needs(NamedTuple):
    """What a job of a workflow asks of a cluster, in the units of Snakemake's resources."""

    mem_mb: int
    runtime: int  # minutes


SLACK, MEMORY_SLACK = 3.0, 1.5
"""Times the estimate that a job asks for: a node may be slower than the reference machine, and its cores shared."""
GRACE = 300.0
"""Seconds that a job asks for on top: libraries from a shared disk, compiling, waiting for another job that compiles."""


def needs(scene: Scene, what: str = "end", attempt: int = 1) -> Needs:
    """What a job asks for that runs a scene to a stage (``sph.solver.run.Until``) or searches a limit of it (``record.SEARCHES``).

    More at every attempt.
    """
    if what in SEARCHES:
        needed = max((search_cost(scene, extrapolates) for extrapolates in (False, True)), key=lambda each: each.seconds)
    else:
        needed = cost(scene, until=scene.gravity.duration if what == "gravity" else None)
    seconds = SLACK * needed.seconds + GRACE
    return Needs(math.ceil(attempt * MEMORY_SLACK * max(needed.memory, COMPILER)), math.ceil(attempt * seconds / 60))
