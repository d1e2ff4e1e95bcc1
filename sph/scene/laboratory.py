"""Soil as laboratories give it: by the speed of shear waves instead of Young's modulus, and by its undrained strength.

A scene may write these; what is made of it has the keys that the equations have.  An undrained strength that grows with depth,
s_u = at_top + gradient z, becomes a cohesion (``at_top``) and its growth.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

from sph.scene.configuration import merge, validated
from sph.scene.scheme import is_resolved
from sph.scene.soil import Soil, UndrainedStrength

SPEED, UNDRAINED, GROWTH = "shear_wave_speed", "undrained_strength", "cohesion_growth"
INSTEAD_OF = {SPEED: ("youngs_modulus",), UNDRAINED: ("cohesion", "friction_angle")}
"""Keys of the soil for which each stands."""
RESIDUALS = ("residual_cohesion", "residual_friction_angle")
"""What an S_R stands for."""
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

    A layer takes over what is written in the scene's soil, key by key, before anything is computed of it: under a soil with a speed of
    shear waves one of another density has the same speed.  Of a quantity with two forms the layer's own counts (``_taken_over``).
    What cannot be computed stays, and is refused by the soil.
    """
    if not isinstance(data, Mapping):
        return data
    defaults = {} if is_resolved(data) else {name: field.default for name, field in Soil.model_fields.items()}
    written, layers = data.get("soil", {}), data.get("layers")
    if not isinstance(written, Mapping):
        return data
    soil = _computed(written, defaults, f"{origin}: soil")
    made = {**data, "soil": soil} if soil != written else data
    if isinstance(layers, Mapping):
        made = {**made, "layers": {name: _layer(layers[name], written, soil, defaults, f"{origin}: layers.{name}") for name in layers}}
    return made


def _layer(layer: Any, written: Mapping[str, Any], soil: Mapping[str, Any], defaults: Mapping[str, Any], where: str) -> Any:
    """A layer under the scene's soil, as it is written and as computed, with the keys of its own and those in which it then differs."""
    own = layer.get("soil", {}) if isinstance(layer, Mapping) else None
    if not isinstance(own, Mapping):
        return layer
    _check_one_form(own, f"{where}.soil")
    found = _computed(merge(_taken_over(layer, own, written, soil, f"{where}.soil"), own), defaults, f"{where}.soil")
    found = {name: None for name in (GROWTH, *RESIDUALS) if soil.get(name) is not None} | dict(found)
    named = {*own, *(key for form in FORMS if own.get(form) is not None for key in INSTEAD_OF[form])}
    kept = {name: value for name, value in found.items() if name in named or value != soil.get(name)}
    return {**layer, "soil": kept} if kept != own else layer


def _taken_over(
    layer: Mapping[str, Any], own: Mapping[str, Any], written: Mapping[str, Any], soil: Mapping[str, Any], where: str
) -> dict[str, Any]:
    """What a layer that writes ``own`` takes over of the scene's soil, without the forms of the quantities that it writes itself.

    A speed of shear waves replaces a modulus and the other way round, an undrained strength a cohesion and its friction angle, a cohesion
    the growth beside it, and an S_R the residual strengths.  A cohesion replaces an undrained strength, whose friction angle of 0 stays; a
    friction angle alone would make it the cohesion of another soil, and is refused.
    """
    there = {name for name, value in own.items() if value is not None}
    kept = dict(written)
    if there & {SPEED, *INSTEAD_OF[SPEED]}:
        kept = {name: value for name, value in kept.items() if name not in (SPEED, *INSTEAD_OF[SPEED])}
    if UNDRAINED in there:
        kept = {name: value for name, value in kept.items() if name not in INSTEAD_OF[UNDRAINED]}
        if isinstance(own[UNDRAINED], Mapping) and isinstance(kept.get(UNDRAINED), (int, float)):
            kept[UNDRAINED] = {"at_top": kept[UNDRAINED]}
    elif kept.get(UNDRAINED) is not None and there & {*INSTEAD_OF[UNDRAINED], GROWTH}:
        if "friction_angle" in there and "cohesion" not in there and own["friction_angle"] != 0:
            raise ValueError(
                f"{where}.friction_angle: {own['friction_angle']!r} under soil.{UNDRAINED}, which is a cohesion without friction; "
                "write the cohesion of the layer as well"
            )
        kept = {name: value for name, value in kept.items() if name != UNDRAINED}
        kept |= {name: soil[name] for name in (*INSTEAD_OF[UNDRAINED], GROWTH) if name in soil}
    replaced = {GROWTH} if there & {UNDRAINED, "cohesion"} else set()
    replaced |= {*RESIDUALS} if layer.get("S_R") is not None else set()
    return {name: value for name, value in kept.items() if name not in replaced}


def _check_one_form(soil: Mapping[str, Any], where: str) -> None:
    """ValueError where a soil writes a quantity in two forms."""
    for form in FORMS:
        both = [name for name in (*INSTEAD_OF[form], *[GROWTH] * (form == UNDRAINED)) if soil.get(name) is not None]
        if soil.get(form) is not None and both:
            raise ValueError(f"{where}.{form}: {soil[form]!r} stands for {' and '.join(INSTEAD_OF[form])}; leave out {' and '.join(both)}")


def _computed(soil: Mapping[str, Any], defaults: Mapping[str, Any], where: str) -> Mapping[str, Any]:
    """A soil with the keys of the equations instead of the forms that can be computed."""
    _check_one_form(soil, where)
    made = dict(soil)
    for form in FORMS:
        if made.get(form) is None:
            continue
        if form == UNDRAINED:
            made[form] = _undrained(soil[form], f"{where}.{form}")
        try:
            found = FORMS[form](dict(defaults) | made) if form == UNDRAINED or float(soil[form]) > 0.0 else {}
        except (KeyError, TypeError, ValueError):
            continue
        if found and all(math.isfinite(value) for value in found.values() if isinstance(value, float)):
            made = {name: value for name, value in made.items() if name != form} | found
    return made if made != soil else soil
