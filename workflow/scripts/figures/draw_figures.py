"""Draw the figures of one run, or of some, of a study."""

import functools
import math
from collections.abc import Mapping, Sequence
from typing import Any

from sph.experiments.paper.figures import FIGURES
from sph.figures import MARKED, RUN_FIGURES, save
from sph.figures.profile import moving_farthest
from sph.jobs.log import Job, job_log
from sph.study.planned import Planned
from sph.study.schema import FEW_PROFILES, PROFILES


def draw_figures(
    paths_to_png: Sequence[str],
    paths_to_pdf: Sequence[str],
    scenes: Mapping[str, Planned],
    figures: Mapping[str, tuple[Sequence[str], Sequence[Sequence[str]]]],
    fidelity: str,
    marked: Mapping[str, Any],
    choice: Mapping[str, Any],
) -> None:
    """Draw figures of any study and of the paper's, by name, from the files of runs of planned scenes, each with its titles.

    Titles name each run: its curve or profile, or its panel and that; there are none where the figure shows one run.
    ``marked`` are the places of the study, how its other runs are shaken, and the quantity of profiles, of which ``choice``
    (``Plan.profile_choice``) chooses the runs.
    """

    def moved(path: str) -> float:
        far = float(scenes[path].read(path).history(choice["probe"]).displacement_magnitude[-1])
        return -1.0 if math.isnan(far) else far

    chosen = moving_farthest(choice.get("groups", []), functools.cache(moved), FEW_PROFILES)
    drawn = {name: chosen if name == PROFILES and chosen else paths for name, (paths, _) in figures.items()}
    runs = {path: scene.read(path) for path, scene in scenes.items() if any(path in paths for paths in drawn.values())}
    fewer = chosen and len(chosen) < choice["size"]
    words = f"{len(chosen)} of {choice['of']}{choice['rule']}" if fewer else ""
    for (name, (paths, titles)), *pictures in zip(figures.items(), paths_to_png, paths_to_pdf, strict=True):
        shown: Any = {} if titles else runs[paths[0]]
        for (*panel, last), path in zip(titles, paths, strict=False):
            if path in drawn[name]:
                (shown.setdefault(panel[0], {}) if panel else shown)[last] = runs[path]
        given = {key: {**marked, "choice": words}[key] for key in MARKED.get(name, ())}
        save((RUN_FIGURES | FIGURES)[name](shown, fidelity=fidelity, **given), *pictures)


if __name__ == "__main__":
    snakemake: Job
    with job_log(snakemake.log[0]):
        draw_figures(snakemake.output.png, snakemake.output.pdf, **snakemake.params.given)
