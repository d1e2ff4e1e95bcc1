"""What the jobs of the workflow make of runs and tables, by experiment: ``making`` reads and writes what a step is given and returns."""
