"""The page of a study whose runs are not all done (``sph page``): what there is so far, and again whenever more is there."""

from __future__ import annotations

import math
import os
import time as clock
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path

from sph.command.status import REFRESH, Stand, State, look_at, look_beside
from sph.command.study import find_study
from sph.experiments.study_row import run_values
from sph.jobs.ahead import finished
from sph.jobs.log import read_log
from sph.measures.metrics import Value
from sph.output.run import Run
from sph.page.answer import CHECKED, FINDINGS, STANDS
from sph.page.build import Missing, StudyFiles, write_page
from sph.stability.record import SEARCHES, YIELD
from sph.storage import trajectory
from sph.study.cost import job_cost
from sph.study.dimensions import CASE
from sph.study.plan import Plan
from sph.study.planned import digest, planned
from sph.study.preflight import looked_at, preflight_searches
from sph.study.schema import MAX_SHOWN
from sph.study.tables import study_rows, write_csv

SO_FAR = PAGE, TABLE = "so_far.html", "so_far.csv"
"""Beside the files of the workflow, which are made of all runs."""
RENEWED = 20
"""Seconds after which a browser reads a page that grows again."""
REST = 4.0
"""Least time between two pages, as a multiple of what one takes: the cores are for the runs."""
WAITED = 60.0
"""Computing time of the searches on the reference machine from which the workflow writes the page of the runs before them, s."""


class SoFar:
    """The page of the runs of a study that are done; each run is measured once."""

    def __init__(self, plan: Plan, base: Path) -> None:
        self.plan, self._base = plan, base
        self.folder = os.path.relpath(base / plan.folder)
        self.missing: dict[str, Missing] = {name: Missing(point, Stand.WAITING) for name, point in plan.study.runs.items()}
        self._measured: dict[Path, tuple[str, dict[str, Value]]] = {}
        self._slopes = digest({name: planned(run.scene) for name, run in looked_at(plan).items()})
        self._searches = {search.file: search for search in plan.searches.values()}
        self._written: object = None

    @property
    def said(self) -> str:
        """How far it is, in words."""
        size = len(self.plan.study.runs)
        return f"{self.folder}/{PAGE}: {size - len(self.missing)} of {size} runs"

    def renew(self, growing: bool) -> bool:
        """Write the page, which a browser reads again if it is ``growing``, where anything is there that the last one had not."""
        study, base = self.plan.study, self._base
        states = {state.job.run.id: state for state in look_at(list(self.plan.shared.runs.values()), base)}
        done = {name: _path(state, base) for name, state in states.items() if state.state == Stand.DONE and _path(state, base).exists()}
        self.missing = {name: Missing(study.runs[name], _stand(state)) for name, state in states.items() if name not in done}
        searches = [state for state in look_at(list(self._searches.values()), base) if state.state == Stand.DONE]
        found = self._found()
        files = [os.path.relpath(path) for path in (*found, *(_path(state, base) for state in searches)) if path.is_file()]
        new = (list(done), files)
        if not done:
            Path(self.folder, PAGE).unlink(missing_ok=True)  # of runs that are not those planned now
        if not done or new == self._written:
            return False
        yields = {state.job.run.file: float(trajectory.read(_path(state, base)).attrs["value"]) for state in searches}
        table, layout = f"{self.folder}/{TABLE}", self.plan.layout
        rows = []
        for name, path in done.items():
            search = self.plan.searches.get(name)
            row = study.runs[name] | self._values(path, yields.get(search.file, math.nan) if search else math.nan)
            rows.append({CASE: name, **row} if layout.named else row)
        write_csv(study_rows(rows, layout), table)
        shown = {name: os.path.relpath(path) for name, path in done.items() if name in study.page_runs}
        scenes = {path: states[name].job.scene for name, path in shown.items()}
        write_page(
            f"{self.folder}/{PAGE}",
            StudyFiles(
                study.study, study.fidelity, self.folder, table, layout, self.plan.dimensions, len(study.runs), shown, scenes, [], files,
                sections=[], metrics=study.metrics, client=study.page == "client", project=study.project,
                author=study.author, assumed=study.assumed, alternatives=study.alternatives, design=study.design, missing=self.missing,
                to_come=self._to_come(found, len(searches)), renewed=RENEWED if growing and self.missing else 0,
            ),
        )  # fmt: skip
        self._written = new
        return True

    def _found(self) -> list[Path]:
        """The tables of what was found in the scenes that are planned now; one of other scenes is left out."""
        study, found = self.plan.study, list[Path]()
        for pattern, job in ((FINDINGS, "preflight"), (CHECKED, "check")):
            log = read_log(self._base / self.plan.folder / "logs" / f"{job}.log")
            if log and log.of == self._slopes:
                found.append(self._base / "results" / study.study / pattern.format(fidelity=study.fidelity))
        return found

    def _to_come(self, found: Sequence[Path], searched: int) -> list[str]:
        """The codes of the findings that the study still searches, where these tables and so many searches are there."""
        asked = preflight_searches(self.plan)
        tests = [] if asked is None or any(path.name == Path(FINDINGS).name and path.is_file() for path in found) else [STANDS, *asked]
        return tests + [SEARCHES[YIELD].code] * (searched < len(self._searches))

    def _values(self, path: Path, yield_acceleration: float) -> dict[str, Value]:
        """The columns of a run; measured again where its file or its yield acceleration is another one."""
        now = f"{path.stat().st_mtime_ns} {yield_acceleration}"
        if self._measured.get(path, ("",))[0] != now:
            self._measured[path] = now, run_values(Run.read(path), self.plan.study.metrics, yield_acceleration)
        return self._measured[path][1]


def _path(state: State, base: Path) -> Path:
    """The file of a run, which may have been made ahead and lie beside its place."""
    return finished(base / state.job.run.file)


def _stand(state: State) -> str:
    """How a run that is missing stands, with the reason."""
    return f"{state.state}: {state.note}" if state.note else str(state.state)


def _of_others(plan: Plan, base: Path) -> dict[str, str]:
    """Pages of fidelities of a study besides its own and that of its draft, the whole one where there is one, by fidelity."""
    others = [name for name in plan.study.fidelities if name not in [each.study.fidelity for each in (plan, plan.draft) if each]]
    pages = {name: [base / plan.at(name).folder / page for page in ("report.html", PAGE)] for name in others}
    return {name: os.path.relpath(there[0]) for name, paths in pages.items() if (there := [path for path in paths if path.exists()])}


def ahead_of_page(plan: Plan) -> list[str]:
    """Folders in which the workflow writes the page of the runs before the whole one: that of the draft, and the study's own where its
    searches take long; none of a study of more runs than a page shows."""
    searches = {search.file: search for search in plan.searches.values()}.values()
    waits = sum(job_cost(search).seconds for search in searches) > WAITED
    few = len(plan.study.runs) <= MAX_SHOWN
    return [each.folder for each in (plan.draft, plan if waits else None) if each and few]


def page(given: Path | None, configfile: Path | None, watching: bool, say: Callable[[str], None]) -> str:
    """Write the page of the runs that are done, and that of the coarser fidelity at which the study has its draft, and name those that
    there are of other fidelities; with ``watching`` write again whenever there are more, until all are, which ``say`` is told.

    ValueError where no run is done, unless they are waited for.
    """
    catalogue = find_study(given, configfile)
    plan = catalogue.plan
    pages = [SoFar(each, catalogue.base) for each in (plan.draft, plan) if each]
    if not watching:
        written = [each.said for each in pages if each.renew(growing=False)]
        beside = [f"{path}: of fidelity {fidelity}" for fidelity, path in _of_others(plan, catalogue.base).items()]
        if not written:
            at_work = [other.job for other in look_beside(plan, catalogue.base) if other.state == Stand.RUNNING] + [
                state.job.run.id for state in look_at(plan.jobs, catalogue.base) if state.state == Stand.RUNNING
            ]
            started = f"at work: {', '.join(at_work)}" if at_work else "start the study with snakemake"
            there = "".join(f"; there is {each}" for each in beside)
            raise ValueError(f"{pages[-1].folder}: no run is done yet; {started}, and add --watch to wait for its runs{there}")
        return "\n".join([*written, *beside])
    say(f"waiting for runs in {' and '.join(each.folder for each in pages)}; end with Ctrl-C")
    while True:
        begun = clock.monotonic()
        for each in pages:
            with suppress(FileNotFoundError):  # a run that was taken to its place between two looks is there at the next
                if each.renew(growing=True):
                    say(each.said)
        if not pages[-1].missing:
            return f"{pages[-1].folder}/report.html follows when snakemake is done"
        clock.sleep(max(REFRESH, REST * (clock.monotonic() - begun)))
