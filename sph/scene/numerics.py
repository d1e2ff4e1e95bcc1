"""Discretisation: resolution, integration and stabilisers."""

from __future__ import annotations

from typing import Literal

from sph.scene.configuration import Section, key


class ArtificialViscosity(Section):
    """Pairwise dissipation of approaching particles, signal-speed form (Monaghan 1997)."""

    alpha: float = key("coefficient, on V_p", ge=0, le=10, default=0.1)
    reconstruction: Literal["none", "linear"] = key(
        "approach velocity on which it acts: all of it (none), or what remains after linear reconstruction of the velocities (linear)",
        source="linear: Frontiere, Raskin and Owen 2017",
        default="none",
    )


class ArtificialStress(Section):
    """Repulsion of particles under tension, against their clumping: numerical fracture (Gray, Monaghan and Swift 2001)."""

    factor: float = key("share of the principal tension that is cancelled at the initial spacing", gt=0, le=1, default=0.3)
    exponent: float = key("power of W(r) / W(spacing)", ge=1, le=10, default=4.0)


class GradientCorrection(Section):
    """First-order consistent velocity gradients (Randles and Libersky 1996)."""

    min_determinant: float = key(
        "below this determinant of the moment matrix a particle keeps the plain gradient", ge=1e-6, le=1, default=0.3
    )


class ShortRangeRepulsion(Section):
    """A conservative spring between particles that come closer than a fraction of the spacing."""

    range: float = key("range over the spacing", ge=0.01, le=1, default=0.8)
    pressure: float = key("pressure-like stiffness of the spring", "kPa", gt=0, le=1e7, default=500.0)


class AdaptiveStep(Section):
    """The time step divided by a whole number, as the stiffest mode of the particles' present arrangement demands."""

    courant: float = key("largest step as a fraction of the limit measured during the run (Courant factor)", ge=0.01, lt=1, default=0.8)


class Numerics(Section):
    """Resolution, integration and stabilisers."""

    spacing: float = key("initial particle spacing", "m", "Sec. 4", ge=1e-6, le=100, default=1.0)
    lattice_shift: float = key(
        "horizontal shift of the lattice of particles against the shape of the soil, over the spacing: which particles are at the edge "
        "is arbitrary, and runs with other shifts show the effect",
        ge=-0.5,
        lt=0.5,
        default=0.0,
    )
    kernel: Literal["cubic_spline", "wendland_c2"] = key("smoothing kernel", source="Sec. 4", default="cubic_spline")
    smoothing_ratio: float = key(
        "smoothing length over spacing; the kernel must reach 1.2 spacings", source="Sec. 4 (h = 2.3 m)", ge=0.6, le=5, default=2.3
    )
    smoothing_length_is: Literal["half_support", "support"] = key(
        "reading of the smoothing length: the kernel ends at 2 h (literal) or at h", source="Sec. 4", default="half_support"
    )
    time_step: float = key(
        "time increment; with adaptive_step the largest one, which may lie above the limits", "s", "Sec. 2.6", ge=1e-9, le=1, default=1e-4
    )
    adaptive_step: AdaptiveStep | None = key("smaller time steps where the limit demands them", default=None)
    neighbour_skin: float = key("margin of the neighbour list over the spacing", gt=0, le=2, default=0.3)
    reference: Literal["current", "initial"] = key(
        "arrangement to which the strain of soil that has not failed refers: initial (total Lagrangian, rotated with the soil) or "
        "current (updated Lagrangian), as always for failed soil; only with initial does soft soil under a steady load come to rest",
        source="Sec. 2.1",
        default="current",
    )
    interfaces: Literal["weaker", "both"] = key(
        "which soil shears where soils of unlike strength meet and the weaker one has failed: weaker, it alone, on the stronger one as "
        "on a no-slip wall; both, as the kernel mixes them (the paper), which brakes weak soil on strong soil",
        source="ours",
        default="both",
    )
    gradient_tolerance: float = key(
        "kernel gradients are kept until a particle has moved this far, over the spacing; 0 renews them every step",
        ge=0,
        le=0.1,
        default=0.01,
    )
    precision: Literal["mixed", "double"] = key(
        "mixed: kernel gradients are kept in single precision, all fields and sums in double; double: all in double", default="mixed"
    )
    artificial_viscosity: ArtificialViscosity | None = key("pairwise artificial viscosity", default=ArtificialViscosity())
    artificial_stress: ArtificialStress | None = key("against the tensile instability (numerical fracture)", default=None)
    gradient_correction: GradientCorrection | None = key("corrected velocity gradients", default=None)
    short_range_repulsion: ShortRangeRepulsion | None = key("against pairing of particles", default=ShortRangeRepulsion())

    @property
    def smoothing_length(self) -> float:
        """h with the kernel ending at 2 h, m."""
        h = self.smoothing_ratio * self.spacing
        return h if self.smoothing_length_is == "half_support" else 0.5 * h
