"""What a run has left, for whoever measures, draws or exports it: one view of it, its survey coordinates, and the export to ParaView."""
