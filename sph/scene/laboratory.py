"""Soil as laboratories give it: by the speed of shear waves instead of Young's modulus, and by its undrained strength.

A scene may write these; it keeps the keys that the equations have.  An undrained strength that grows with depth, s_u = at_top + gradient z,
becomes a cohesion (``at_top``) and its growth.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

from sph.scene.configuration import validated
from sph.scene.scheme import is_resolved
from sph.scene.soil import Soil, UndrainedStrength

SPEED, UNDRAINED, GROWTH = "shear_wave_speed", "undrained_strength", "cohesion_growth"
INSTEAD_OF = {SPEED: ("youngs_modulus",), UNDRAINED: ("cohesion", "friction_angle")}
"""Keys of the soil for which each stands."""
LARGEST = 1e6
"""Largest undrained strength, kPa."""


def _modulus(soil: Mapping[str, Any]) -> dict[str, float]:
    """Young's modulus (kPa) of soil by its speed of shear waves, density and Poisson's ratio: G = rho V_s^2."""
    speed, density, ratio = (float(soil[name]) for name in (SPEED, "density", "poisson_ratio"))
    return {"youngs_modulus": 2e-3 * (1.0 + ratio) * density * speed**2}


def _undrained(written: Any, where: str) -> UndrainedStrength:
    """An undrained strength as it is written, one number or by its growth; ValueError for what is neither."""
    if isinstance(written, Mapping):
        return validated(UndrainedStrength, written, where)
    try:
        number = math.nan if isinstance(written, bool) else float(written)
    except (TypeError, ValueError):
        number = math.nan
    if not 0.0 < number <= LARGEST:
        raise ValueError(f"{where}: {written!r} must be above 0 kPa and at most {LARGEST:g}, or a section with at_top and gradient")
    return UndrainedStrength(at_top=number, gradient=0.0)


def _strength(soil: Mapping[str, Any]) -> dict[str, Any]:
    """Undrained strength: a cohesion without friction, and its growth where it has one."""
    written = soil[UNDRAINED]
    growth = {GROWTH: {"gradient": written.gradient, "datum": written.datum}} if written.gradient else {}
    return {"cohesion": written.at_top, "friction_angle": 0.0} | growth


FORMS: dict[str, Callable[[Mapping[str, Any]], dict[str, Any]]] = {SPEED: _modulus, UNDRAINED: _strength}


def as_computed(data: Mapping[str, Any], origin: str) -> Mapping[str, Any]:
    """A scene's mapping with the keys that these stand for; ValueError where both are written.

    A layer takes density and Poisson's ratio, where it has none of its own, from the scene's soil.  What cannot be computed stays, and is
    refused by the soil.  A layer that writes a strength of its own does not take over how that of the scene's soil grows.
    """
    if not isinstance(data, Mapping):
        return data
    taken = {} if is_resolved(data) else {name: field.default for name, field in Soil.model_fields.items()}
    base, layers = data.get("soil", {}), data.get("layers")
    made = _with(data, base, taken, f"{origin}: soil")
    if isinstance(layers, Mapping) and isinstance(base, Mapping):
        inherited, own = taken | dict(base), dict(layers)
        grows = isinstance(made.get("soil"), Mapping) and made["soil"].get(GROWTH) is not None
        for name, layer in layers.items():
            if isinstance(layer, Mapping):
                own[name] = _with(layer, layer.get("soil", {}), inherited, f"{origin}: layers.{name}.soil")
                soil = own[name].get("soil")
                if grows and isinstance(soil, Mapping) and "cohesion" in soil and GROWTH not in soil:
                    own[name] = {**own[name], "soil": {**soil, GROWTH: None}}
        made = {**made, "layers": own} if own != layers else made
    return made


def _with(holder: Mapping[str, Any], soil: Any, inherited: Mapping[str, Any], where: str) -> Mapping[str, Any]:
    """A scene or layer with its soil as it is computed."""
    forms = [form for form in FORMS if isinstance(soil, Mapping) and soil.get(form) is not None]
    made = dict(soil) if forms else {}
    for form in forms:
        both = [name for name in (*INSTEAD_OF[form], *[GROWTH] * (form == UNDRAINED)) if soil.get(name) is not None]
        if both:
            raise ValueError(f"{where}.{form}: {soil[form]!r} stands for {' and '.join(INSTEAD_OF[form])}; leave out {' and '.join(both)}")
        if form == UNDRAINED:
            made[form] = _undrained(soil[form], f"{where}.{form}")
        try:
            found = FORMS[form](dict(inherited) | made) if form == UNDRAINED or float(soil[form]) > 0.0 else {}
        except (KeyError, TypeError, ValueError):
            continue
        if found and all(math.isfinite(value) for value in found.values() if isinstance(value, float)):
            made = {name: value for name, value in made.items() if name != form} | found
    return {**holder, "soil": made} if forms else holder
