"""What ``sph.command.info`` takes from ``sph.jobs.concerns``, under its former name."""

from sph.jobs.concerns import of_motion as of_motion
from sph.jobs.concerns import peak_accelerations as peak_accelerations
from sph.jobs.concerns import thin_box as thin_box
