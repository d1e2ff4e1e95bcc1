"""Keep the points of a search's last round as its table."""

from sph.command.job import job_log
from sph.experiments.trigger.points import read_points
from sph.study.tables import write_csv

if __name__ == "__main__":
    with job_log(snakemake.log[0]):  # type: ignore[name-defined]
        write_csv(read_points(snakemake.input[0]), snakemake.output[0])  # type: ignore[name-defined]
