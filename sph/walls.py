"""The box around the soil."""

from __future__ import annotations

from typing import Literal

from sph.configuration import Section, key


class WallFriction(Section):
    """Coulomb friction between soil and free-slip walls; a wall without a coefficient has none."""

    base: float = key("coefficient of friction (tangent of the angle) at base and top", ge=0, le=10, default=0.0)
    sides: float = key("coefficient of friction at the side walls", ge=0, le=10, default=0.0)


class Walls(Section):
    """How the box holds the soil."""

    base: Literal["sticky", "free_slip", "none"] = key(
        "bottom of the box: fixed 'dynamic boundary' particles (the paper), a frictionless floor, or nothing",
        source="Sec. 2.4; free_slip ours",
        default="sticky",
    )
    sides: Literal["sticky", "free_slip", "periodic", "none"] = key(
        "side walls: fixed particles that hold the soil (the paper), a frictionless wall, soil that goes on periodically, or nothing",
        source="Sec. 2.4; free_slip and periodic ours",
        default="sticky",
    )
    top: Literal["sticky", "free_slip", "none"] = key("lid of the box, for flows between plates", default="none")
    friction: WallFriction | None = key("friction on free-slip walls", default=None)
    layers: int = key(
        "layers of boundary particles; free-slip walls need as many as fill the kernel's support but for one spacing",
        source="Sec. 4 (2,404 particles)",
        ge=1,
        le=8,
        default=2,
    )

    @property
    def hold(self) -> bool:
        """Whether there is a wall at all."""
        return any(how in ("sticky", "free_slip") for how in (self.base, self.sides, self.top))
