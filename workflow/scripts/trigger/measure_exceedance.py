"""Count how many motions exceed a run-out or a displacement, and draw it."""

from collections.abc import Mapping

from sph.experiments.trigger.design import Searched
from sph.experiments.trigger.exceedance import exceedance
from sph.experiments.trigger.points import Key, read_points
from sph.figures import save
from sph.figures.reach import figure_reach
from sph.jobs.log import Job, job_log
from sph.scene.schema import Scene
from sph.study.planned import Planned
from sph.study.tables import write_csv


def measure_exceedance(
    path_to_points: str, scenes: Mapping[Key, Planned], searched: Searched, note: str, path_to_table: str, *pictures: str
) -> None:
    """Table and figure, with the section of the cases whose scenes, by case and other values, have one ground."""
    table = exceedance(read_points(path_to_points), searched)
    write_csv(table, path_to_table)
    by_case: dict[str, list[Scene]] = {}
    for (case, *_), scene in scenes.items():
        by_case.setdefault(case, []).append(scene.build())
    of_one_ground = {case: built[0] for case, built in by_case.items() if all(each.geometry == built[0].geometry for each in built)}
    save(figure_reach(table, searched, of_one_ground, note), *pictures)


if __name__ == "__main__":
    snakemake: Job
    with job_log(snakemake.log[0]):
        measure_exceedance(
            snakemake.input.points, snakemake.params.scenes, snakemake.params.searched, snakemake.params.note, *snakemake.output
        )
