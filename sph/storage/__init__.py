"""Files: trajectories, how any file is written whole, and the export to ParaView."""
