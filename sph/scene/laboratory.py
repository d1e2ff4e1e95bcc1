"""Soil as laboratories give it: by the speed of shear waves instead of Young's modulus, and by its undrained strength.

A scene may write these; it keeps the keys that the equations have.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

from sph.scene.scheme import is_resolved
from sph.scene.soil import Soil

SPEED, UNDRAINED = "shear_wave_speed", "undrained_strength"
INSTEAD_OF = {SPEED: ("youngs_modulus",), UNDRAINED: ("cohesion", "friction_angle")}
"""Keys of the soil for which each stands."""


def _modulus(soil: Mapping[str, Any]) -> dict[str, float]:
    """Young's modulus (kPa) of soil by its speed of shear waves, density and Poisson's ratio: G = rho V_s^2."""
    speed, density, ratio = (float(soil[name]) for name in (SPEED, "density", "poisson_ratio"))
    return {"youngs_modulus": 2e-3 * (1.0 + ratio) * density * speed**2}


def _strength(soil: Mapping[str, Any]) -> dict[str, float]:
    """Undrained strength (kPa): a cohesion without friction."""
    return {"cohesion": float(soil[UNDRAINED]), "friction_angle": 0.0}


FORMS: dict[str, Callable[[Mapping[str, Any]], dict[str, float]]] = {SPEED: _modulus, UNDRAINED: _strength}


def as_computed(data: Mapping[str, Any], origin: str) -> Mapping[str, Any]:
    """A scene's mapping with the keys that these stand for; ValueError where both are written.

    A layer takes density and Poisson's ratio, where it has none of its own, from the scene's soil.  What cannot be computed stays, and is
    refused by the soil.
    """
    if not isinstance(data, Mapping):
        return data
    taken = {} if is_resolved(data) else {name: field.default for name, field in Soil.model_fields.items()}
    base, layers = data.get("soil", {}), data.get("layers")
    made = _with(data, base, taken, f"{origin}: soil")
    if isinstance(layers, Mapping) and isinstance(base, Mapping):
        inherited, own = taken | dict(base), dict(layers)
        for name, layer in layers.items():
            if isinstance(layer, Mapping):
                own[name] = _with(layer, layer.get("soil", {}), inherited, f"{origin}: layers.{name}.soil")
        made = {**made, "layers": own} if own != layers else made
    return made


def _with(holder: Mapping[str, Any], soil: Any, inherited: Mapping[str, Any], where: str) -> Mapping[str, Any]:
    """A scene or layer with its soil as it is computed."""
    forms = [form for form in FORMS if isinstance(soil, Mapping) and soil.get(form) is not None]
    made = dict(soil) if forms else {}
    for form in forms:
        both = [name for name in INSTEAD_OF[form] if soil.get(name) is not None]
        if both:
            raise ValueError(f"{where}.{form}: {soil[form]!r} stands for {' and '.join(INSTEAD_OF[form])}; leave out {' and '.join(both)}")
        try:
            found = FORMS[form](dict(inherited) | made) if float(soil[form]) > 0.0 else {}
        except (KeyError, TypeError, ValueError):
            continue
        if found and all(map(math.isfinite, found.values())):
            made = {name: value for name, value in made.items() if name != form} | found
    return {**holder, "soil": made} if forms else holder
