"""Files: trajectories, their survey coordinates, how any file is written whole, and the export to ParaView."""
