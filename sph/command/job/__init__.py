"""What ``sph.command.status`` takes from ``sph.jobs.log``, under its former name."""

from sph.jobs.log import read_log as read_log
