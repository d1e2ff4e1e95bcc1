"""Walls, one kind a file: absorbing, free slip, and the contact that keeps soil before the faces of those that stand still."""
