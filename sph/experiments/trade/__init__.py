"""What each saving of computing time costs in accuracy: runs, table, order of convergence, and what that answers."""
