"""What fills the keys that a scene does not name: its scheme.

``paper`` takes everything from the paper's scene, its soil and its strength ratio included, and is for that scene and for tests.
``resolved``, the default, takes from the program only how the scene is computed, and that failed soil never carries more than its peak
strength (``RESOLVED``).  What soil it is, what it keeps of its strength and how it is damped decide the answer, and must be written
(``NEEDED``).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from sph.scene.configuration import dotted, merge

SCHEMES = ("resolved", "paper")
RESOLVED: dict[str, Any] = dotted(
    {
        "walls.base": "no_slip",
        "walls.sides": "free_slip",
        "coupling.solid_after_failure": "elastic_plastic",
        "numerics.smoothing_ratio": 1.3,
        "numerics.time_step": 2.5e-3,
        "numerics.adaptive_step.courant": 0.8,
        "numerics.reference": "initial",
        "numerics.gradient_tolerance": 0.02,
        "numerics.interfaces": "weaker",
        "numerics.artificial_viscosity.alpha": 0.03,
        "numerics.artificial_viscosity.reconstruction": "linear",
    }
)
"""Keys of the scheme ``resolved`` whose defaults are not those of the paper's scene."""

SOFTENING = "coupling.softening"
"""How strength is lost with slip, which decides most of what is seldom measured."""
BY_SLIP = f"{SOFTENING}.slip_at_residual"
"""With this key strength falls with slip, and gamma, where it is not written, is 0."""

NEEDED = {
    "soil.density": "density, kg/m3",
    "soil.youngs_modulus": "Young's modulus, kPa; or write soil.shear_wave_speed, m/s",
    "soil.poisson_ratio": "Poisson's ratio",
    "soil.cohesion": "peak cohesion, kPa; or write soil.undrained_strength, of saturated clay",
    "soil.friction_angle": "peak friction angle, degree",
    "soil.viscosity": "viscosity of failed soil beyond its yield stress, Pa s; the paper's debris has 2",
    "coupling.S_R": "strength that failed soil keeps, over its peak: residual over peak c and phi in a shear box or ring shear test; or "
    "write soil.residual_cohesion and soil.residual_friction_angle",
    "coupling.gamma": "rate at which strength falls after failure, 1/s; 100 is at once (the paper), 1 within seconds; or "
    "write coupling.softening.slip_at_residual, the slip at which it is lost",
    "damping": "Rayleigh damping: ratio and two frequencies, of the slope and of the motion's upper end; or null",
    "numerics.spacing": "spacing of the particles, m; a twentieth of the slope's height for a first look",
}
"""What a scene of the scheme ``resolved`` must write, and what it means."""
AT_REST: dict[str, Any] = dotted({"gravity.initial_stress": "geostatic", "gravity.ramp": 0.0})
"""What is filled in where a K0 is written."""
INSTEAD = {
    "soil.youngs_modulus": ("soil.shear_wave_speed",),
    "soil.cohesion": ("soil.undrained_strength",),
    "soil.friction_angle": ("soil.undrained_strength",),
    "coupling.gamma": (BY_SLIP,),
    "coupling.S_R": ("soil.residual_cohesion", "soil.residual_friction_angle"),
}
"""Keys that may be written instead of one of these."""


def filled(data: Mapping[str, Any]) -> Mapping[str, Any]:
    """A scene's mapping with what its scheme fills in."""
    made = merge(RESOLVED, data) if is_resolved(data) else data
    made = merge(AT_REST, made) if _writes_rest(data) else made
    return merge({"coupling": {"gamma": 0.0}}, made) if has_key(data, BY_SLIP, set_there=True) else made


def _writes_rest(data: Mapping[str, Any]) -> bool:
    """Whether the scene's own soil or that of a layer has a K0."""
    layers = data.get("layers") if isinstance(data, Mapping) else None
    of_layers = layers.values() if isinstance(layers, Mapping) else ()
    return any(has_key(each, "soil.K0", set_there=True) for each in (data, *of_layers))


def missing(data: Mapping[str, Any], origin: str) -> list[str]:
    """A line for each key that a scene's mapping must write and does not."""
    if not is_resolved(data):
        return []
    lines = [
        f"{origin}: {name}: must be given, since the results depend on it: {text}"
        for name, text in NEEDED.items()
        if not has_key(data, name) and not all(has_key(data, other, set_there=True) for other in INSTEAD.get(name, (name,)))
    ]
    return lines and [*lines, f"{origin}: scheme: paper would take what is not written from the paper's scene"]


def is_resolved(data: Mapping[str, Any]) -> bool:
    """Whether a scene's mapping is of the scheme ``resolved``."""
    return isinstance(data, Mapping) and data.get("scheme", "resolved") == "resolved"


def has_key(data: Mapping[str, Any], name: str, set_there: bool = False) -> bool:
    """Whether a dotted key is there, and with ``set_there`` is not null; one whose section is no mapping is refused elsewhere."""
    value: Any = data
    for part in name.split("."):
        if not isinstance(value, Mapping):
            return not set_there
        if part not in value:
            return False
        value = value[part]
    return not (set_there and value is None)
