"""What the answers rest on: the assumptions behind a scene, changed one at a time."""
