"""How often a year each class is reached, from the fragility and the hazard of the site."""

from sph.experiments.trigger.annual import annual_table
from sph.experiments.trigger.critical import read_critical
from sph.experiments.trigger.design import Searched
from sph.experiments.trigger.hazard import read_hazard
from sph.jobs.log import Job, job_log
from sph.study.tables import write_csv


def measure_annual(path_to_critical: str, path_to_hazard: str, span: tuple[float, float], searched: Searched, path_to_table: str) -> None:
    """One row a case and class, from a search between the ends of ``span``."""
    intensity = searched.intensity
    hazard = read_hazard(path_to_hazard, intensity.unit)
    write_csv(annual_table(read_critical(path_to_critical), hazard, *span, intensity.shown_unit), path_to_table)


if __name__ == "__main__":
    snakemake: Job
    with job_log(snakemake.log[0]):
        measure_annual(
            snakemake.input.critical,
            snakemake.input.hazard,
            snakemake.params.span,
            snakemake.params.searched,
            snakemake.output[0],
        )
