"""Samples without times: their number and interval in the head, in every layout, or a refusal that names what is missing."""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np
import pytest
from record_files import lines_of

from sph.scene.ground_motion import read_components, read_record

INTERVAL = 0.005
SAMPLES = np.round(2.0 * np.sin(np.arange(100) / 7.0), 6)
COUNTED = [
    "100 0.005",
    "  100  5.0E-03",
    "100, 0.005",
    "100\t0.005 s",
    "100 0.005 NPTS, DT",
    "NPTS= 100, DT= .005 SEC",
    "npts=100 dt=0.005",
]
TITLES = ["", "Kobe 1995, 000\nacceleration in g\n", "1940 El Centro\nunits: gal\n"]


@pytest.mark.parametrize("ending", ["th", "ACC", "txt", "csv"])
@pytest.mark.parametrize("each", [1, 3, 5, 8])
def test_samples_below_their_number_and_interval(tmp_path: Path, each: int, ending: str) -> None:
    path = tmp_path / f"a.{ending}"
    for title, head in itertools.product(TITLES, COUNTED):
        path.write_text(f"{title}{head}\n" + lines_of(SAMPLES.tolist(), "{:12.6f}", each))
        unit = "gal" if "gal" in title else "g"
        time, acceleration = read_record(path, None if title else "g")
        np.testing.assert_allclose(time, INTERVAL * np.arange(100), atol=1e-12, err_msg=head)
        np.testing.assert_allclose(acceleration, {"g": 9.81, "gal": 0.01}[unit] * SAMPLES, rtol=1e-12, err_msg=head)


@pytest.mark.parametrize("first", [0.0, INTERVAL])
@pytest.mark.parametrize("mark", [" ", ", "])
def test_pairs_below_their_number_and_interval(tmp_path: Path, mark: str, first: float) -> None:
    """As DEEPSOIL has them."""
    path = tmp_path / "a.txt"
    pairs = [f"{first + INTERVAL * at:.3f}{mark}{value:.6f}" for at, value in enumerate(SAMPLES)]
    path.write_text("\n".join(["100 0.005", *pairs]))
    time, acceleration = read_record(path, "g")
    np.testing.assert_allclose(time, INTERVAL * np.arange(100), atol=1e-12)
    np.testing.assert_allclose(acceleration, 9.81 * SAMPLES, rtol=1e-12)
    path.write_text("\n".join(["100 0.005", *pairs[:60], f"9.99{mark}1.0", *pairs[61:]]))
    with pytest.raises(ValueError, match=r"a.txt, line 62: its time must lie 0.3 s after the first"):
        read_record(path, "g")


@pytest.mark.parametrize("text", ["2 0.1\n3 0.2\n4 0.3\n", "2,0.1\n3,0.2\n"])
def test_columns_of_time_and_acceleration_stay_columns(tmp_path: Path, text: str) -> None:
    path = tmp_path / "a.csv"
    path.write_text(text)
    assert read_record(path, "m/s2").time[:2].tolist() == [2.0, 3.0]


VALUES = lines_of(SAMPLES.tolist(), "{:12.6f}", 5)
BAD = [
    ("a.th", VALUES, "g", "no line that counts them; write a line .* as '4000 0.005'"),
    ("a.csv", lines_of(SAMPLES.tolist(), "{:12.6f}", 1), "g", "line 1: must have .* has 1 .*samples without times, write a line"),
    ("a.txt", VALUES, "g", "line 1: must have .* has 5 .*samples without times, write a line"),
    ("a.acc", "101 0.005\n" + VALUES, "g", "line 1: must hold the 101 samples that its header states, holds 100"),
    ("a.csv", "90 0.005\n" + VALUES, "g", "line 1: must hold the 90 samples"),
    ("a.th", "1 0.005\n0.1\n", "g", "at least two samples"),
    ("a.th", "100 0\n" + VALUES, "g", "interval of its samples"),
    ("a.th", "100 0.005\n" + VALUES, None, "a.th: does not say its unit"),
    ("a.th", "acceleration (g x 1000)\n100 0.005\n" + VALUES, "g", r"line 1: 'acceleration \(g x 1000\)': states a factor"),
    ("a.th", "acc in g\nunits: gal\n100 0.005\n" + VALUES, None, "line 1: 'acc in g': .*more than one unit"),
    ("a.th", "acc in g\n100 0.005\n" + VALUES, "gal", "is in g by its own words, unit: gal contradicts it"),
    ("a.th", "component: up\n100 0.005\n" + VALUES, "g", "vertical component"),
    ("a.th", "100 0.005\n" + VALUES.replace("0.", "x.", 1), "g", "line 2: must be finite numbers"),
]  # fmt: skip


@pytest.mark.parametrize(("name", "text", "unit", "message"), BAD, ids=range(len(BAD)))
def test_what_is_refused(tmp_path: Path, name: str, text: str, unit: str | None, message: str) -> None:
    path = tmp_path / name
    path.write_text(text)
    with pytest.raises(ValueError, match=message) as refused:
        read_components(path, unit)  # type: ignore[arg-type]
    assert str(path) in str(refused.value)
