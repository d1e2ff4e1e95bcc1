"""The shaking that triggers failure: searches by refinement, critical amplitudes, maps over S_R, gamma and amplitude."""
