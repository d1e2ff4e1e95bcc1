"""Keep the points of a search's last round as its table."""

from sph.analysis.points import read_points
from sph.analysis.tables import write_csv
from sph.command.job import job_log

if __name__ == "__main__":
    with job_log(snakemake.log[0]):  # type: ignore[name-defined]
        write_csv(read_points(snakemake.input[0]), snakemake.output[0])  # type: ignore[name-defined]
