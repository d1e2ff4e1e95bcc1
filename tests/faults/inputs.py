"""What users write: sound configurations, records, surveys and command lines of every kind, and how they are spoilt."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import yaml
from configurations import HARD_NUMBERS, HARD_TEXTS, junk, keys
from hypothesis import strategies as st
from record_files import afad, csmip, esm, geonet, knet, unam
from small_scenes import TWO_BODIES

from sph.experiments.paper.design import AnyStudy
from sph.experiments.sensitivity.schema import Sensitivity
from sph.experiments.trigger.schema import Trigger
from sph.experiments.variants.schema import Assumptions, CostAccuracy
from sph.scene.configuration import merge
from sph.scene.schema import Scene
from sph.stability.standing import FailureRule

TINY: dict[str, Any] = {
    "scheme": "paper",
    "name": "tiny",
    "duration": 0.02,
    "geometry": {"shape": "block", "width": 4.0, "height": 3.0},
    "gravity": {"ramp": 0.0, "duration": 0.01},
    "numerics": {"spacing": 1.0, "smoothing_ratio": 1.3, "time_step": 1e-4},
    "outputs": {"frame_interval": 0.01, "series_interval": 0.01},
}
SLOPE = {"shape": "slope", "slope_angle": 45.0, "slope_height": 4.0, "base_depth": 2.0, "apron_length": 3.0, "crest_length": 3.0}
GROUND = {"shape": "ground_line", "points": [[10.0, 102.0], [13.0, 102.0], [16.0, 105.0], [19.0, 105.0]], "base": 100.0}
SCENES = [
    TINY,
    TINY | {"geometry": SLOPE, "motion": {"kind": "tapered_sine", "start": 0.01, "ramp": 0.0, "decay_start": 0.02, "end": 0.02}},
    TINY | {"geometry": GROUND, "motion": {"kind": "ricker", "amplitude": 1.0, "frequency": 300.0, "peak": 0.015}},
    TINY
    | {
        "layers": {
            "cover": {"region": {"kind": "depth", "bottom": 1.0}, "soil": {"cohesion": 5.0}, "S_R": 0.1},
            "rock": {"region": {"kind": "elevation", "top": 1.0}, "soil": {"density": 2600.0}},
            "lens": {"region": {"kind": "polygon", "points": [[0.0, 0.0], [1.5, 0.0], [0.0, 2.5]]}, "gamma": 2.0},
        }
    },
    TINY
    | {
        "motion": {
            "kind": "record",
            "start": 0.01,
            "amplitude": 2.0,
            "vertical": {"factor": 0.5},
            "baseline": {},
            "band_pass": {"low": 1.0, "high": 20.0},
            "trim": {"taper": 0.01},
            "resample": {"interval": 0.02},
            "data": {"interval": 0.01, "x": [0.0, 1.0, -2.0, 1.0, 0.5, 0.0], "y": [0.0, 1.0, 0.0, -1.0, 0.0, 0.0]},
        }
    },
    TINY
    | {
        "geometry": TWO_BODIES,
        "walls": {"base": "free_slip", "sides": "free_slip", "friction": {"base": 0.3}},
        "early_stop": {"window": 0.01},
    },
    TINY
    | {
        "geometry": SLOPE,
        "walls": {
            "base": "absorbing",
            "sides": "absorbing",
            "bedrock": {"density": 2e3, "s_wave_speed": 1e3, "p_wave_speed": 2e3},
        },
    },
    merge(
        TINY,
        {
            "geometry": SLOPE,
            "soil": {"blow_count": 10.0, "fines_content": 10.0},
            "water": {"pressure": "carried", "level": 2.0, "excess_pressure": {"liquefaction": {}}},
            "motion": {"kind": "tapered_sine", "start": 0.01, "ramp": 0.0, "decay_start": 0.02, "end": 0.02},
        },
    ),
    merge(
        TINY,
        {
            "walls": {"base": "none", "sides": "periodic"},
            "geometry": {"width": 8.0},
            "coupling": {"initial_state": "fluid", "fluid": {"law": "capped_viscosity", "max_viscosity": 1e3}},
            "motion": {"kind": "constant", "amplitude": 1.0, "start": 0.01, "ramp": 0.0},
            "initial_velocity": {"along": "y", "position": [0.0, 2.0], "x": [0.0, 2.0], "y": [1.0, 1.0]},
            "prescribed_velocity_gradient": {"xy": 1.0},
            "numerics": {
                "adaptive_step": {},
                "artificial_stress": {},
                "gradient_correction": {},
                "kernel": "wendland_c2",
                "precision": "double",
            },
        },
    ),
]
STUDY = {
    "study": "s",
    "scene": "tiny.yaml",
    "fidelity": "a",
    "grid": {"S_R": ["0.1", "0.25"], "gamma": [1], "amplitude": ["6.0"]},
    "fidelities": {"a": {}, "b": {"numerics": {"spacing": 0.5}}},
    "figures": {"strengths": ["0.1"], "gamma": "1", "compared_gammas": ["1"], "compared_strengths": ["0.25"]},
}
ANY = {name: value for name, value in STUDY.items() if name not in ("grid", "figures")}
FREE = [
    ANY | {"grid": {"S_R": ["0.1", "0.25"], "soil.cohesion": [20, "150"], "numerics.kernel": ["cubic_spline", "wendland_c2"]}},
    ANY | {"cases": [{"S_R": "0.1", "walls.layers": 2}, {"S_R": 0.25, "walls.layers": "3"}], "figures": {"runs": ["case-000002"]}},
    ANY | {"sample": {"method": "random", "size": 5, "ranges": {"S_R": [0.1, 0.5], "soil.cohesion": {"bounds": [1, 9], "scale": "log"}}}},
]
"""Studies over other dimensions than the paper's."""
COST_ACCURACY = {
    "scene": "tiny.yaml",
    "cases": {"weak": {"coupling": {"S_R": 0.1}}, "strong": {"coupling": {"S_R": 0.5}}},
    "timed_case": "weak",
    "reference": {"parameter": "spacing", "variant": "1 m"},
    "baseline": "a",
    "parameters": {
        "spacing": {"about": "x", "variants": {"1 m": {}, "0.5 m": {"numerics": {"spacing": 0.5}}}, "exceptions": {"0.5 m": {"repeats": 1}}}
    },
}
ASSUMPTIONS = {
    "scene": "tiny.yaml",
    "cases": {"weak": {}},
    "reference": {"parameter": "S_R", "variant": "as it is"},
    "parameters": {"S_R": {"variants": {"as it is": {}, "S_R 0.1": {"coupling": {"S_R": 0.1}}}}},
}
SENSITIVITY = {
    "factors": {
        "S_R": {"keys": {"coupling.S_R": 1.0}, "bounds": [0.1, 0.5]},
        "height": {"keys": {"geometry.slope_height": 1.0, "geometry.apron_length": 0.75}, "bounds": [3.0, 5.0], "scale": "log"},
    },
    "metrics": {"displacement_magnitude": {"log_offset": 0.01}, "runout": {}},
    "morris": {"trajectories": 2},
    "sobol": {"samples": 8},
    "confirm": {"fidelity": "b", "points": 2},
}
TRIGGER = {
    "cases": {"as it is": {}, "slip": {"walls": {"sides": "free_slip", "layers": 8}}},
    "amplitude": {"lowest": 1.0, "highest": 8.0, "cells": 2},
    "tolerance": 0.5,
    "S_R": ["0.1", 0.25],
    "gamma": [1],
    "confirm": {"fidelity": "b", "S_R": ["0.1"], "gamma": [1], "cases": ["slip"]},
    "maps": {
        "cases": ["slip"],
        "S_R": {"lowest": 0.1, "highest": 0.5, "cells": 1},
        "gamma": {"lowest": 1, "highest": 100, "cells": 1, "scale": "logarithmic"},
    },
}
MODELS = {
    "scene": Scene,
    "study": AnyStudy,
    "cost-accuracy": CostAccuracy,
    "assumptions": Assumptions,
    "sensitivity": Sensitivity,
    "trigger": Trigger,
    "rule": FailureRule,
}


def text(value: Any) -> str:
    """A value as an argument of a command line."""
    try:
        return str(value).replace("\0", "")[:4000]
    except ValueError:
        return "9" * 5000


any_text = st.one_of(
    st.sampled_from([*map(text, HARD_NUMBERS), *(t.replace("\0", "") for t in HARD_TEXTS)]), st.text(max_size=12), junk.map(text)
).map(lambda t: t.encode("utf-8", "replace").decode().replace("\0", ""))
a_number = st.one_of(st.sampled_from(["1", "0.25g", "2.5", "1e-6", "0.1"]), st.floats(1e-6, 1.0).map(str), st.floats().map(str), any_text)
dotted_keys = st.sampled_from([".".join(map(str, path)) for path, _ in keys(Scene)])
a_good_setting = st.sampled_from(list(keys(Scene))).flatmap(
    lambda pair: pair[1].map(lambda value: f"{'.'.join(map(str, pair[0]))}={text(yaml.safe_dump(value, default_flow_style=True))}")
)
a_setting = st.one_of(a_good_setting, a_good_setting, st.tuples(dotted_keys, any_text).map("=".join), any_text)
a_rule = st.one_of(st.tuples(st.sampled_from(list(FailureRule.model_fields)), a_number).map("=".join), any_text)
a_file = st.sampled_from(["SCENE", "RECORD", "FOLDER", "/dev/null", "absent", "n" * 300, "/dev/zero/x", "-", ""])
lines = st.one_of(
    st.tuples(st.just("info"), st.just("SCENE"), st.just("--set"), a_setting),
    st.tuples(st.just("newmark"), st.just("SCENE"), st.just("--ay=1m/s2"), st.just("--set"), a_setting),
    st.tuples(st.just("newmark"), st.just("RECORD"), a_number.map("--ay={}g".format), a_number.map("--scale-to={}g".format)),
    st.tuples(
        st.just("newmark"), st.just("RECORD"), a_number.map("--ay={}g".format), a_number.map("--upslope={}g".format), st.just("--json")
    ),
    st.tuples(st.just("fos"), st.just("SCENE"), st.just("--rule"), a_rule, a_number.map("--tolerance={}".format)),
    st.tuples(st.just("fos"), st.just("SCENE"), any_text.map("--reduce={}".format), st.just("--rule=displacement=0.5")),
    st.tuples(st.just("yield-acceleration"), st.just("SCENE"), st.just("--rule=displacement=0.5"), st.just("--rule"), a_rule),
    st.tuples(st.just("advise"), a_number.map("--error={}".format), any_text.map("--quantity={}".format)),
    st.tuples(st.just("advise"), a_number.map("--error={}".format), any_text.map("--of={}".format)),
    st.tuples(st.just("advise"), st.just("--error=0.2"), a_file.map("--table={}".format)),
    st.tuples(st.sampled_from(["plot", "metrics", "info"]), a_file),
    st.tuples(st.just("newmark"), a_file, st.just("--ay=1m/s2")),
    st.tuples(st.just("run"), st.just("SCENE"), a_file.map("--restart={}".format)),
    st.tuples(st.just("run"), st.just("SCENE"), any_text.map("--until={}".format)),
    st.tuples(
        st.just("run"),
        st.just("SCENE"),
        st.sampled_from(["FOLDER", "/", "absent/x.nc", "/dev/null/x.nc", "n" * 300]).map("--out={}".format),
    ),
    st.tuples(st.just("run"), st.just("SCENE"), st.just("--until=x"), any_text.map("--threads={}".format)),
    st.tuples(st.just("schema"), any_text),
    st.tuples(st.just("check"), st.just("SCENE"), st.just("--set"), a_setting),
    st.tuples(st.just("motion"), st.sampled_from(["RECORD", "SCENE"]), any_text.map("--unit={}".format)),
    st.tuples(st.just("motion"), a_file, st.just("--json")),
    st.tuples(st.just("cost"), a_file, a_number.map("--speed={}".format), a_number.map("--start={}".format)),
    st.tuples(st.just("pack"), a_file, st.just("--results"), a_file.map("--out={}.zip".format)),
)
cells = st.one_of(st.floats(-1e3, 1e3).map(str), st.sampled_from(list(map(text, HARD_NUMBERS))), st.text(max_size=5))
rising = st.lists(st.tuples(st.floats(1e-9, 10.0), st.floats(-1e3, 1e3)), min_size=2, max_size=20).map(
    lambda rows: "\n".join(f"{t},{a}" for t, a in zip(np.cumsum([row[0] for row in rows]).tolist(), [row[1] for row in rows], strict=True))
)
PEER = "A\nB\nACCELERATION TIME SERIES IN UNITS OF G\nNPTS= 7, DT= .01 SEC\n .1E-1 -.2E-1 .3E+0 -.1E-5 0.0\n .1E-1 -.2E-1\n"
SMC = "\n".join(
    ["2 CORRECTED ACCELEROGRAM", *["*"] * 10]
    + [f"{0:10d}" * 7 + f"{1:10d}" if line == 1 else f"{4 if line == 2 else 0:10d}" + f"{0:10d}" * 7 for line in range(6)]
    + ["".join(f"{100.0 if line == 0 and at == 1 else 0.0:15.7E}" for at in range(5)) for line in range(10)]
    + ["| comment", "   -1.0000   20.0000  -30.00001000.00000"]
)
SHORT = np.array([0.43, -0.41, 0.002, 0.0])
KNET = knet(SHORT, 4)
OTHERS = {
    "asc": esm(SHORT, 0.25),
    "txt": afad({"N-S": SHORT, "E-W": SHORT, "U-D": SHORT}, 0.25),
    "asa": unam({"N00E": SHORT, "V": SHORT}, 0.25),
    "v2a": geonet({"N10E": SHORT, "Up": SHORT}, 0.25),
    "v1": csmip({"90 Deg": SHORT}, 0.25, 1, (90,)),
    "v2": csmip({"90 Deg": SHORT}, 0.25, 2, (90,)),
}
"""Records of further formats by their endings."""
comma_separated = st.one_of(
    rising,
    st.lists(st.lists(cells, min_size=1, max_size=3).map(",".join), max_size=6).map("\n".join),
    st.lists(st.tuples(st.floats(), st.floats()).map(lambda row: f"{row[0]},{row[1]}"), min_size=2, max_size=5).map("\n".join),
    st.text(max_size=60),
)


def broken(base: Mapping[str, Any] | str) -> st.SearchStrategy[str]:
    """A text, that of a mapping as YAML, with a piece cut out and something put in."""
    whole = base if isinstance(base, str) else yaml.safe_dump(base)
    inserted = st.one_of(
        st.text(max_size=5),
        st.sampled_from(["&a ", "*a", "<<: ", "!!bool ", "\t", "? ", "- ", "{", "[" * 2000, "'", "|", "%", "2001-99-99"]),
    )
    return st.tuples(st.integers(0, len(whole)), st.integers(0, 10), inserted).map(
        lambda cut: whole[: cut[0]] + cut[2] + whole[cut[0] + cut[1] :]
    )


surveys = st.one_of(
    broken("x,y\n120,440\n150,440\n170,465\n200,465\n"),
    broken("LINESTRING Z (0 0 440, 30 0 440, 50 0 465, 80 0 465)"),
    broken('{"type": "Feature", "properties": {}, "geometry": {"type": "LineString", "coordinates": [[0, 440], [30, 440], [50, 465]]}}'),
)

records = st.one_of(
    st.tuples(st.just("csv"), comma_separated),
    *(
        st.tuples(st.just(ending), st.one_of(st.just(text), broken(text)))
        for ending, text in (("at2", PEER), ("smc", SMC), ("EW", KNET), *OTHERS.items())
    ),
)
