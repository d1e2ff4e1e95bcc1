"""The prediction for many cores follows its formula, and runs on a tiny setting."""

from __future__ import annotations

from typing import Any

import cores
import pytest

NUMBERS = {"step": 1e-2, "asked": 1e10, "meeting": 1e-6, "bandwidth": 1e11}


def test_prediction_by_hand() -> None:
    assert cores.predict(**NUMBERS, serial=0.5, cores=1) == pytest.approx(1.0)
    # Ten cores ask for all that the node reads; a step takes 1 ms, 4 meetings of 16 threads 32 us, what one thread does alone 10 ms.
    assert cores.predict(**NUMBERS, serial=0.0, cores=16) == pytest.approx(1e-2 / (1e-3 + 3.2e-5))
    assert cores.predict(**NUMBERS, serial=0.5, cores=16) == pytest.approx(2e-2 / (1e-3 + 1e-2 + 3.2e-5))


@pytest.mark.long
def test_the_numbers_agree_with_each_other(script: Any) -> None:
    found, printed = script("cores.py", "--spacing", "2.5", "--serial-spacing", "5", "--steps", "5", "--repeats", "2")
    assert found["particles"] == 472
    assert 0.0 < found["serial"] < 1.0 and found["meeting"] > 0.0
    for name, serial in (("times_as_fast", found["serial"]), ("times_as_fast_still", 0.0)):
        assert found[name]["1"] == pytest.approx(1.0)
        constants = {key: found[key] for key in NUMBERS}
        assert found[name]["16"] == pytest.approx(cores.predict(**constants, serial=serial, cores=16))
    assert f"{found['measured_two']:.2f} times as fast as one" in printed
