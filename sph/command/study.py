"""The study that a command is given: its configuration, or the folder of its results."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

import sph
from sph.experiments.registry import load_study
from sph.jobs.catalogue import FILE, Catalogue
from sph.scene.configuration import merge, read_yaml
from sph.study.plan import OWNER, Plan
from sph.study.sampling import chosen_study

CONFIGURATION = Path("config", "config.yaml")
"""The configuration that ``snakemake`` reads unless it is given another, and over which one is laid that names no scene."""


def find_study(given: Path | None, configfile: Path | None = None, started: bool = False) -> Catalogue:
    """The catalogue of a study; by default that of ``CONFIGURATION`` in the working folder, as for ``snakemake``.

    What is given is a configuration, or ``.../results/<study>/<fidelity>``, which decides the fidelity; the configuration of another study
    than that of ``CONFIGURATION``, which need not be there then, is found by its name.  ``started``: a configuration has the fidelity at
    which it was started last, by ``--config fidelity=...`` another than its own.  ValueError names what does not fit.
    """
    if given and (given.is_file() or given.suffix in (".yaml", ".yml")):
        if configfile:
            raise ValueError(f"{given}: is a configuration, and so is --configfile {configfile}; give one of them")
        given, configfile = None, given
    place = given.resolve() if given else None
    if place and place.parent.parent.name != "results":
        raise ValueError(f"{given}: is neither a configuration (YAML) nor the folder of a study's results, results/<study>/<fidelity>")
    base = place.parents[2] if place else Path.cwd()
    shipped = base / CONFIGURATION
    if configfile is None and place is None and not shipped.is_file():
        raise ValueError(f"{shipped}: no such file; go to the folder the study was started in, or give its configuration or results folder")
    data: Mapping[str, Any] = read_yaml(shipped) if shipped.is_file() else {}
    if place and configfile is None and data.get("study") != place.parent.name:
        found = _configurations_of(place.parent.name, base)
        if len(found) > 1:
            listed = ", ".join(str(path.relative_to(base)) for path in found)
            raise ValueError(f"{given}: several files are configurations of this study: {listed}; give the one with --configfile")
        configfile = found[0] if found else None
    if configfile:
        own = read_yaml(configfile)
        data = chosen_study(merge(data, own), own)
    if place:
        if data.get("study") != place.parent.name:
            other = f"the configuration's study is {data['study']!r}" if "study" in data else f"no configuration of it is found in {base}"
            raise ValueError(f"{given}: {other}; give the configuration of this one with --configfile")
        data = {**data, "fidelity": place.name}
    folders = [base, Path(sph.__file__).parents[1]]
    plan = load_study(data, folders)
    return Catalogue(plan.at(_started_last(plan, base)) if started and not place else plan, folders, base, check=False)


def _started_last(plan: Plan, base: Path) -> str:
    """The fidelity of a study whose plan of runs was written last, at every start of its workflow; its own where none was."""
    plans = [base / plan.at(name).folder / FILE for name in plan.study.fidelities]
    written = [path for path in plans if path.is_file()]
    return max(written, key=lambda path: path.stat().st_mtime).parent.name if written else plan.study.fidelity


def _configurations_of(study: str, base: Path) -> list[Path]:
    """The files at most two folders below where a study was started that name it; of several those whose scene its results are of."""
    named = dict[Path, Any]()
    for path in (path for depth in ("", "*/", "*/*/") for path in base.glob(f"{depth}*.y*ml")):
        with suppress(ValueError):
            data = read_yaml(path)
            if data.get("study") == study:
                named[path] = data.get("scene")
    owner = base / "results" / study / OWNER
    own = [path for path, scene in named.items() if scene == owner.read_text(encoding="utf-8").strip()] if owner.is_file() else []
    return own or list(named)
