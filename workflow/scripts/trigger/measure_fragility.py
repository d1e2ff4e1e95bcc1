"""Fit fragility curves to the critical intensities of many motions, and draw them."""

from sph.experiments.trigger.critical import read_critical
from sph.experiments.trigger.design import Searched
from sph.experiments.trigger.fragility import fragility
from sph.figures import save
from sph.figures.fragility import figure_fragility
from sph.jobs.log import Job, job_log
from sph.study.tables import write_csv


def measure_fragility(path_to_critical: str, searched: Searched, note: str, path_to_fits: str, path_to_curves: str, *pictures: str) -> None:
    """Tables of fits and curves, and the figure in its kinds."""
    critical = read_critical(path_to_critical)
    fits, curves = fragility(critical, searched.intensity.shown_unit)
    write_csv(fits, path_to_fits)
    write_csv(curves, path_to_curves)
    save(figure_fragility(critical, fits, curves, searched, note), *pictures)


if __name__ == "__main__":
    snakemake: Job
    with job_log(snakemake.log[0]):
        measure_fragility(snakemake.input[0], snakemake.params.searched, snakemake.params.note, *snakemake.output)
