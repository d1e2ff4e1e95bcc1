"""Files: trajectories, their survey coordinates, how any file is written whole, archives, and the export to ParaView."""
