"""The experiments: each is a folder here, a line of ``NAMES`` and a file of rules, or a configuration of a scene in variants."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from importlib import import_module
from pathlib import Path
from typing import Any

from sph.experiments.base import Experiment
from sph.experiments.variants.design import EXPERIMENTS as VARIANTS
from sph.study.plan import Plan
from sph.study.plan import load_study as load
from sph.study.schema import Study

NAMES = (
    "sensitivity",
    "trigger",
    "paper",
)
"""Of the folders of one experiment each; that of variants holds several."""
EXPERIMENTS: dict[str, Experiment] = {
    each.name: each for each in (*VARIANTS, *(import_module(f"{__package__}.{name}.design").EXPERIMENT for name in NAMES))
}
"""By name."""
CONFIGURED = [name for name, each in EXPERIMENTS.items() if each.keys]
"""Those with a file of their own, which a study may name."""
STUDY: type[Study] = next((each.study for each in EXPERIMENTS.values() if each.study), Study)
"""The configuration of the workflow: a study, with the keys that an experiment adds."""


def load_study(config: Mapping[str, Any] | Path | str, folders: Sequence[Path] = (Path(),), check: bool = True) -> Plan:
    """Validate a configuration and, with ``check``, every scene in it and the files of the experiments on its scene that it names.

    ``folders`` are searched in order for the scene file, a file of cases and those of experiments, of which the scenes of their runs are
    built when the experiment is asked for.  ValueError names file, key and value.
    """
    plan = load(config, folders, check, STUDY)
    for name in plan.study.experiments if check else ():
        if name in CONFIGURED and not EXPERIMENTS[name].alone:
            EXPERIMENTS[name].load(plan.experiment_file(name), plan, folders, False)
    return plan
