"""What ``sph.command.status`` takes from ``sph.jobs.progress``, under its former name."""

from sph.jobs.progress import LINE as LINE
