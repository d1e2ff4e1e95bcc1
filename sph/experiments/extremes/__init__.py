"""How far the solver can be pushed: one key at a time to the ends of its range."""
