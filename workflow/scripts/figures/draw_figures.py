"""Draw the figures of one run, or of some, of a study."""

from collections.abc import Mapping, Sequence
from typing import Any

from sph.experiments.paper.figures import FIGURES
from sph.figures import MARKED, RUN_FIGURES, save
from sph.jobs.log import Job, job_log
from sph.study.planned import Planned


def draw_figures(
    paths_to_png: Sequence[str],
    paths_to_pdf: Sequence[str],
    scenes: Mapping[str, Planned],
    figures: Mapping[str, tuple[Sequence[str], Sequence[Sequence[str]]]],
    fidelity: str,
    marked: Mapping[str, Any],
) -> None:
    """Draw figures of any study and of the paper's, by name, from the files of runs of planned scenes, each with its titles.

    Titles name each run: its curve or profile, or its panel and that; there are none where the figure shows one run.
    ``marked`` are the places of the study, and the quantity of profiles.
    """
    runs = {path: scene.read(path) for path, scene in scenes.items()}
    for (name, (paths, titles)), *pictures in zip(figures.items(), paths_to_png, paths_to_pdf, strict=True):
        shown: Any = {} if titles else runs[paths[0]]
        for (*panel, last), path in zip(titles, paths, strict=False):
            (shown.setdefault(panel[0], {}) if panel else shown)[last] = runs[path]
        given = {key: marked[key] for key in MARKED.get(name, ())}
        save((RUN_FIGURES | FIGURES)[name](shown, fidelity=fidelity, **given), *pictures)


if __name__ == "__main__":
    snakemake: Job
    with job_log(snakemake.log[0]):
        draw_figures(snakemake.output.png, snakemake.output.pdf, **snakemake.params.given)
