"""Effect of the assumptions behind a scene, changed one at a time."""
