"""Draw the critical amplitudes, or a map."""

from collections.abc import Sequence

from sph.experiments.trigger.critical import read_critical
from sph.experiments.trigger.maps import read_shares
from sph.experiments.trigger.points import read_points
from sph.figures import save
from sph.figures.trigger import MAPPED, figure_class_map, figure_critical, figure_map, figure_shares
from sph.jobs.log import Job, job_log


def draw_trigger(figure: str, tables: dict[str, str], note: str, paths_to_pictures: Sequence[str]) -> None:
    """'trigger', 'shares', 'map-class' or 'map-' and one of ``MAPPED``; paths to the tables that it shows by their names."""
    if figure == "trigger":
        drawn = figure_critical(read_critical(tables["critical"]), note)
    elif figure == "shares":
        drawn = figure_shares(read_shares(tables["shares"]), note)
    elif figure == "map-class":
        drawn = figure_class_map(read_points(tables["points"]), note)
    else:
        drawn = figure_map(read_points(tables["points"]), MAPPED[figure.removeprefix("map-")], note)
    save(drawn, *paths_to_pictures)


if __name__ == "__main__":
    snakemake: Job
    with job_log(snakemake.log[0]):
        draw_trigger(
            snakemake.params.figure,
            {name: str(path) for name, path in snakemake.input.items()},
            snakemake.params.note,
            [snakemake.output.png, snakemake.output.pdf],
        )
