"""The page of a study: that it holds what the files hold, escapes it, and stays within its size."""

from __future__ import annotations

import base64
import datetime
import functools
import json
import math
import re
import zlib
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from made import FOLDER, RIGHT, TITLE, listed_study, made_study
from matplotlib.figure import Figure
from PIL import Image
from synthetic import synthetic

from sph.checks.finding import finding
from sph.experiments.trigger.annual import annual_columns
from sph.experiments.trigger.critical import critical_table
from sph.experiments.trigger.design import Searched
from sph.figures.before_after import figure_before_after
from sph.figures.style import metres
from sph.measures.fields import FIELDS as PARTICLE_FIELDS
from sph.measures.metrics import CLASSES, UNDETERMINED
from sph.output.run import Run
from sph.page import build
from sph.page.answer import FINDINGS
from sph.page.build import StudyFiles, build_page, write_page
from sph.page.explorer import DETAILS, LOST, explorer
from sph.page.facts import claims, going, limit, searched, unshaken
from sph.page.levels import levels
from sph.page.second_spacing import with_second_class
from sph.page.sections import DOCS, existing
from sph.page.tables import chosen_keys, csv_table, layer_table, scene_table, short
from sph.scene.gravity import GRAVITY
from sph.scene.schema import load_scene
from sph.scene.units import in_both
from sph.stability.extrapolation import Extrapolated
from sph.stability.record import search_group
from sph.stability.search import Search
from sph.storage import trajectory
from sph.study.dimensions import Dimension
from sph.study.preflight import Row, write_preflight
from sph.study.tables import number_column, read_table, write_csv

SCENES = Path(__file__).parents[2] / "config" / "scenes"
HOSTILE = "</script><img src=x onerror=alert(1)>"


@pytest.fixture(autouse=True)
def _quickly_drawn(monkeypatch: pytest.MonkeyPatch) -> None:
    """The slope before and after, which other tests look at, takes half of the time of a page."""
    blank = functools.wraps(figure_before_after)(lambda *of, **how: Figure(figsize=(1.0, 1.0)))
    monkeypatch.setattr(build, "figure_before_after", blank)
    monkeypatch.setattr(build, "found_equilibrium", lambda scene: None)


class Words(HTMLParser):
    """What a reader sees, and the elements that carry it."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.elements: list[tuple[str, dict[str, str | None]]] = []
        self.text = ""
        self.data = ""
        self._inside = ""
        self.feed(page)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, dict(attrs)))
        if tag in ("script", "style"):
            self._inside = "data" if dict(attrs).get("id") == "data" else tag

    def handle_endtag(self, tag: str) -> None:
        self._inside = "" if tag in ("script", "style") else self._inside

    def handle_data(self, data: str) -> None:
        if self._inside == "data":
            self.data += data
        elif not self._inside:
            self.text += " ".join(data.split()) + " "

    @property
    def runs(self) -> dict[str, Any]:
        """The data of the runs."""
        return json.loads(self.data)


def unpacked(text: str, kind: str, width: int) -> np.ndarray:
    """Frames of a packed array, as the page's script sums them."""
    steps = np.frombuffer(zlib.decompress(base64.b64decode(text)), kind).reshape(-1, width)
    return np.add.accumulate(steps, axis=0, dtype=steps.dtype)


def test_the_page_tells_every_run_as_the_table_does(study: StudyFiles) -> None:
    words = Words(build_page(study))
    for row in read_table(study.table).to_dict("records"):
        name = f"runs/S_R-{row['S_R']}_gamma-{row['gamma']}_amplitude-{row['amplitude']}.nc"
        told = words.runs["points"][f"{row['S_R']}|{row['gamma']}|{row['amplitude']}"]
        named = dict(zip(words.runs["columns"], told["facts"], strict=True))
        assert name in words.text and told["file"] == name
        assert named["class"] == row["collapse_class"] and named["displacement of A (m)"] == metres(row["displacement_magnitude"])
    found = list(read_table(study.table)["collapse_class"])
    counts = ", ".join(f"{found.count(name)} {name}" for name in CLASSES)
    assert f"4 runs over strength ratio S_R, rate of the loss of strength γ and amplitude of shaking: {counts}; 1 diverged" in words.text


def test_a_diverged_run_is_marked_and_has_no_numbers(study: StudyFiles) -> None:
    words = Words(build_page(study))
    facts = dict(zip(words.runs["columns"], words.runs["points"]["0.50|100|6.0"]["facts"], strict=True))
    assert facts["status"] == "diverged" and facts["class"] == "undetermined"
    assert facts["displacement of A (m)"] == facts["run-out (m)"] == "–"
    assert sum(tag == "tr" and attrs.get("class") == "bad" for tag, attrs in words.elements) == 1
    assert "1 diverged" in words.text
    # Nor does it take part in the common scale of colours.
    moved = [np.hypot(*Run.read(run).displacement()).max() for run in list(study.runs.values())[:-1]]
    assert words.runs["largest"] == pytest.approx(max(moved))


def test_nothing_that_a_file_holds_becomes_markup(study: StudyFiles) -> None:
    Path(FOLDER, "trigger").mkdir()
    Path(FOLDER, "trigger", "claim.csv").write_text(f'claim,verdict,note\n11,"{HOSTILE}",**bold**\n')
    page = build_page(study._replace(name=HOSTILE, files=existing(FOLDER, study.sections)))
    words = Words(page)
    assert TITLE in words.text and HOSTILE in words.text
    assert [tag for tag, _ in words.elements].count("script") == 2 and not any("onerror" in attrs for _, attrs in words.elements)
    assert words.runs["folder"] == FOLDER


def test_the_page_asks_for_nothing_outside(study: StudyFiles) -> None:
    words = Words(build_page(study))
    for tag, attrs in words.elements:
        for name in ("src", "href"):  # the documentation lies beside the program; a link there is followed by a click only
            assert (attrs.get(name) or "#").startswith(("#", "data:") if tag != "a" else ("#", "..")), (tag, attrs)
    policy = next(attrs["content"] for _, attrs in words.elements if attrs.get("http-equiv"))
    assert policy is not None and policy.startswith("default-src 'none'")


def test_every_picture_has_words(study: StudyFiles) -> None:
    page = build_page(study)
    pictures = [attrs for tag, attrs in Words(page).elements if tag == "img"]
    assert len(pictures) == 8 and all(len(attrs["alt"] or "") > 20 for attrs in pictures)
    assert "drawn from runs/S_R-0.10_gamma-100_amplitude-6.0.nc, runs/S_R-0.50_gamma-100_amplitude-4.0.nc" in Words(page).text


def test_a_section_names_its_command_until_its_files_exist(study: StudyFiles) -> None:
    before = Words(build_page(study)).text
    assert "snakemake --cores 2 sensitivity" in before
    for name in ("up", "other"):  # at the page's fidelity and at another one
        path = Path(FOLDER).with_name(name) / "sensitivity" / "morris.csv"
        path.parent.mkdir(parents=True)
        path.write_text(f"parameter,share\n{name},0.123456789\n")
        assert str(path) in existing(FOLDER, study.sections)
    after = Words(build_page(study._replace(files=existing(FOLDER, study.sections)))).text
    assert "snakemake --cores 2 sensitivity" not in after and "0.1235" in after
    assert after.count("results/made/up/sensitivity/morris.csv") == after.count("results/made/other/sensitivity/morris.csv") == 1


def test_the_fragility_is_said_before_its_tables(study: StudyFiles) -> None:
    assert "snakemake --cores 2 fragility" in Words(build_page(study)).text
    folder = Path(FOLDER, "trigger")
    (folder / "figures").mkdir(parents=True)
    (folder / "fragility_fit.csv").write_text("case,median,sentence\nas it is,3.123456789,A 50 % chance at 3.12.\n")
    annual = [{"case": "wet", "sentence": "Once in 50 years."}, {"case": "dry", "sentence": HOSTILE}]
    empty = {column.name: "collapse" if column.dtype == "str" else 0.02 for column in annual_columns("1")}
    write_csv(pd.DataFrame([empty | row for row in annual]), folder / "fragility_annual.csv")
    (folder / "exceedance.csv").write_text("case,exceeded\nas it is,1\n")
    for name in ("fragility", "exceedance"):
        Image.new("RGB", (40, 30), "white").save(folder / "figures" / f"{name}.png")
    page = build_page(study._replace(files=existing(FOLDER, study.sections)))
    section = Words(page[page.index('<section id="fragility">') : page.index('<section id="further">')])
    assert "snakemake" not in section.text and HOSTILE in section.text
    places = [section.text.index(words) for words in ("A 50 % chance at 3.12.", "wet: Once in 50 years.", "dry: ", "3.123")]
    assert places == sorted(places) and section.text.count("Once in 50 years.") == 1, "no column of the table, whose CSV holds it"
    assert [attrs["alt"].partition(":")[0] for tag, attrs in section.elements if tag == "img"] == ["Fragility", "Exceedance"]
    for name in ("fragility_fit.csv", "fragility_annual.csv", "exceedance.csv"):
        assert f"{folder}/{name}" in section.text


def test_the_order_of_the_runs_does_not_matter(study: StudyFiles) -> None:
    turned = study._replace(runs=dict(list(study.runs.items())[::-1]), stages=study.stages[::-1])
    assert build_page(turned) == build_page(study)


def test_positions_come_back_to_half_a_quantum(study: StudyFiles) -> None:
    data = Words(build_page(study)).runs
    held = data["points"]["0.10|100|6.0"]["run"]
    run = Run.read(list(study.runs.values())[1])
    soil = np.flatnonzero(run.soil)
    probe = int(run["probe_particle"][0])
    order = [probe, *soil[soil != probe]]
    frames = [int(np.argmin(np.abs(run["time"] - time))) for time in held["times"]]
    assert held["times"][0] == 3.0 and held["times"][-1] == 15.0 and len(frames) == 25
    numbers = unpacked(held["positions"], "<i2", 2 * len(order)).reshape(-1, 2, len(order))
    for axis, name in enumerate(("x", "y")):
        there = data["middle"][axis] + data["quantum"] * numbers[:, axis]
        np.testing.assert_allclose(there, run[name][frames][:, order], atol=0.51 * data["quantum"])
    assert data["quantum"] == pytest.approx(2.5 / 200)
    np.testing.assert_array_equal(unpacked(held["shares"]["beta"], "u1", len(order)), 255)
    time, horizontal, vertical = np.frombuffer(zlib.decompress(base64.b64decode(held["curve"])), "<f4").reshape(3, -1)
    end = [run[f"probe_displacement_{axis}"][-1, 0] for axis in ("x", "y")]
    assert (time[-1], horizontal[-1], vertical[-1]) == pytest.approx((15.0, *end)) and end[0] < -5.0


def test_a_lost_particle_is_no_number(study: StudyFiles) -> None:
    data = Words(build_page(study)).runs
    held = data["points"]["0.50|100|6.0"]["run"]
    numbers = unpacked(held["positions"], "<i2", 2 * held["particles"]).reshape(-1, 2, held["particles"])
    assert held["times"][-1] == 9.0
    assert np.count_nonzero(numbers[-1] == LOST) == 2 and np.count_nonzero(numbers[:-1] == LOST) == 0


def test_the_runs_are_kept_in_the_detail_that_fits(study: StudyFiles) -> None:
    whole = build_page(study)
    data = Words(whole).runs
    assert data["detail"] == DETAILS[0].words()
    runs = [point["run"] for point in data["points"].values()]
    packed = sum(len(run["positions"]) + len(run["curve"]) + len(run["shares"]["beta"]) for run in runs)
    largest = len(whole) - packed // 3
    tight = build_page(study, largest=largest)
    assert len(tight) <= largest
    assert Words(tight).runs["detail"] not in (DETAILS[0].words(), "no drawing")
    frames = [point["run"]["times"] for point in Words(tight).runs["points"].values()]
    assert all(times[0] == 3.0 and times[-1] in (9.0, 15.0) for times in frames)
    least = Words(build_page(study, largest=1)).runs
    assert least["detail"] == "no drawing" and not any("run" in point for point in least["points"].values())


def test_cost_counts_shared_stages_once(study: StudyFiles) -> None:
    # Each run says 2 s; two each hold pre-failure runs of 0.75 and 1 s, and both of these the gravity stage of 0.5 s.
    text = Words(build_page(study)).text
    assert "(5.75 s)" in text and f"{8 / 3600:.3g} core-hours if every run" in text


def test_a_table_of_other_runs_is_refused(study: StudyFiles) -> None:
    with pytest.raises(ValueError, match="study.csv: .* 3 runs"):
        build_page(study._replace(size=3, runs=dict(list(study.runs.items())[1:])))


def test_a_list_is_chosen_by_run(study: StudyFiles) -> None:
    listed = listed_study(study)
    words = Words(build_page(listed))
    assert words.runs["axes"] == ["run"] and list(words.runs["points"]) == [f"case-{number:06d}" for number in range(1, 5)]
    assert words.runs["points"]["case-000002"]["title"] == "S_R 0.10, γ 100 s⁻¹, amplitude 6.0 m/s² (0.612 g)"
    assert "case-000002: S_R 0.10, γ 100 s⁻¹, amplitude 6.0 m/s² (0.612 g)" in words.text
    options = [attrs["value"] for tag, attrs in words.elements if tag == "option" and (attrs["value"] or "").startswith("case-")]
    assert options == list(words.runs["points"])


def test_a_run_of_another_slope_is_drawn_with_its_own_surroundings(study: StudyFiles) -> None:
    data = Words(build_page(listed_study(study))).runs
    own = {name: point["run"]["own"] for name, point in data["points"].items()}
    assert [name for name, changed in own.items() if changed] == ["case-000003"]
    assert set(own["case-000003"]) == {"spacing", "quantum", "middle", "surface", "box", "shaking"}
    assert own["case-000003"]["spacing"] == 5.0 and own["case-000003"]["shaking"] == [3.0, 11.0]
    assert data["right"] > max(data["surface"][0]) + 20.0, "the picture holds the widest"


def test_a_page_of_a_part_of_the_runs_says_so(study: StudyFiles) -> None:
    few = study._replace(runs=dict(list(study.runs.items())[:3]), stages=study.stages[:3])
    words = Words(build_page(few))
    assert words.runs["axes"] == ["run"] and len(words.runs["points"]) == 3
    assert "4 runs over" in words.text and "3 of 4 runs" in words.text and "1 diverged" in words.text
    assert "with shared stages counted once" not in words.text


@pytest.mark.parametrize("name", ["claims.csv", "figures/fig4.png", "runs/S_R-0.10_gamma-100_amplitude-6.0.nc"])
def test_a_damaged_file_is_named_and_the_earlier_page_stays(study: StudyFiles, name: str) -> None:
    size = write_page(f"{FOLDER}/report.html", study)
    assert size == Path(FOLDER, "report.html").stat().st_size
    Path(FOLDER, name).write_bytes(b"a,b\n1\n\xff")
    with pytest.raises(ValueError, match=re.escape(name)):
        write_page(f"{FOLDER}/report.html", study)
    assert Path(FOLDER, "report.html").stat().st_size == size


def test_what_nobody_has_measured_is_named_below_the_answer(study: StudyFiles) -> None:
    assumed = {"coupling.softening": "strength is lost within 100 mm", "soil.K0": "0.43"}
    words = Words(build_page(study._replace(assumed=assumed))).text
    assert "Assumed, not measured: strength is lost within 100 mm; and 1 more" in words and "soil.K0" in words
    assert "More certain with: shear tests of the slip at which strength is lost" in words
    assert "soil.K0" not in Words(build_page(study._replace(assumed=assumed, client=True))).text
    assert "Assumed, not measured" not in Words(build_page(study)).text


def test_what_the_release_measured_is_a_link(study: StudyFiles) -> None:
    """The page of a study says nothing of speed, validation and robustness itself, but where it is told."""
    words = Words(build_page(study))
    links = [attrs["href"] or "" for tag, attrs in words.elements if tag == "a" and (attrs["href"] or "").startswith("..")]
    assert len(links) == len(DOCS) and all(Path(FOLDER, link).is_file() for link in links)
    anchors = {attrs.get("id") for _, attrs in words.elements}
    assert not anchors & {"validation", "robustness", "speed-and-accuracy", "limits"}


def test_the_page_begins_with_the_answer(study: StudyFiles) -> None:
    """Whether it stands, at which shaking it goes and how far, beside Newmark's block; then what limits the trust in it."""
    table = read_table(study.table)
    table["yield_acceleration"], table["newmark_displacement"] = 2.0, [0.1, 0.4, 0.1, 0.4]
    write_csv(table, study.table)
    first = Words(build_page(study)).text.partition("One run")[0]
    for words in (
        "Without shaking does not stand in 4 of 4 runs",
        "Yield acceleration not searched sph yield-acceleration",
        "Factor of safety not searched sph fos",
        "at most 4 m/s² (0.408 g)",
    ):
        assert words in first
    for amplitude, runs in table[table["diverged"] == 0].groupby("amplitude"):
        classes, moved = (
            " to ".join(dict.fromkeys(words))
            for words in (sorted(runs["collapse_class"], key=CLASSES.index), map(metres, sorted(runs["displacement_magnitude"])))
        )
        assert f"{amplitude} ({float(amplitude) / GRAVITY:.3g} g) {classes} {moved}" in first
    assert "0.100" in first and "0.400" in first and "1 of 4 runs diverged" in first and "Expected error" in first
    assert "2 of 4 runs move A by less than a spacing (2.5 m)" in first, "those at 4 m/s2, by 2.43 and by 0 m"


def test_the_papers_results_and_claims_come_before_the_single_runs(study: StudyFiles) -> None:
    first, _, rest = Words(build_page(study)).text.partition("Strength ratio S_R")
    assert re.search(r"The paper's claims \d of 12 hold .*not covered: 1, ", first)
    assert first.index("Figure 4.") < first.index("Each claim is turned into a test") and "Figure 1." in rest
    # What runs leave open is decided by a search, in its first case.
    write_csv(pd.DataFrame({"claim": [11, 11], "case": ["a", "b"], "verdict": ["holds", "fails"]}), f"{FOLDER}/claim.csv")
    assert claims([f"{FOLDER}/claims.csv"], [f"{FOLDER}/claim.csv"])[0][1].startswith("1 of 12")


def test_findings_and_the_factor_of_safety_are_shown_once_they_exist(study: StudyFiles) -> None:
    findings, factor = Path(FOLDER).parent / FINDINGS.format(fidelity="up"), Path(FOLDER) / "stages" / "factor_of_safety.nc"
    thin = finding("thin-layer", "numerics.spacing", subject="clay", value=2, bound=4)
    note = finding("factor-of-safety", value=1.41, error=0.1, coarse=2.0, fine=1.0, step_taken=True)
    write_preflight(findings, [Row(thin, 3, "one"), Row(note, 1, "one")])
    words, how = limit([note], note.code, [], "sph fos")
    assert words == "1.41 ± 0.10" and "sph fos" in how
    assert limit([], note.code, [], "sph fos") == ("not searched", "sph fos")
    unknown = finding("stability-unknown", subject=note.code, reason="too few rows")
    assert limit([unknown], note.code, [], "sph fos") == ("not known", "too few rows")
    # Of several slopes the least and the most, and how to have one more closely.
    weaker = finding("factor-of-safety", value=1.09, error=0.08, coarse=2.0, fine=1.0, step_taken=True)
    words, how = limit([note, weaker], note.code, [], "sph fos")
    assert words == "1.09 ± 0.08 to 1.41 ± 0.10" and "of 2 slopes" in how and "sph fos" in how
    searched_file(factor, "factor_of_safety", 1.35, 0.02)
    first = Words(build_page(study._replace(files=[*existing(FOLDER, study.sections), str(factor)]))).text.partition("One run")[0]
    assert (
        "3 of 4 runs: clay is thin: 2 particles across, should be at least 4" in first
        and "Factor of safety 1.35 ± 0.02 static, extrapolated from spacings of 2 and 1 m" in first
    )
    # The weakest slope by slices stands beside it.
    slices = [
        finding("limit-equilibrium", bishop=1.44, spencer=factor, spencer_surface="line", spencer_crack=0.0) for factor in (1.42, 1.31)
    ]
    write_preflight(findings, [Row(each, 1, "one") for each in (note, *slices)])
    first = Words(build_page(study)).text.partition("One run")[0]
    assert "Factor of safety Bishop 1.44 (circle), Spencer 1.31 (not circular); 1.41 ± 0.10 by SPH static" in first
    assert "Yield acceleration Spencer: not found; not searched by SPH sph yield-acceleration" in first


def searched_file(path: Path, by: str, value: float, error: float, reason: str = "") -> str:
    """The file of a search at two spacings, of 2 and 1 m."""
    found = Extrapolated((2.0, 1.0), (Search(value, value, ()), Search(value, value, ())), value, error, True, value)
    trajectory.write(path, search_group(load_scene(SCENES / "paper.yaml"), by, Search(math.nan, math.nan, ()) if reason else found, reason))
    return str(path)


def test_the_newmark_block_has_the_yield_acceleration_of_the_headline(study: StudyFiles) -> None:
    """One number in the headline, in the table of runs and behind the block: that of the search, with its error and how it was found."""
    file = Path(FOLDER) / "stages" / "yield_acceleration.nc"
    made = searched_file(file, "yield_acceleration", 0.193 * GRAVITY, 0.02 * GRAVITY)
    table = read_table(study.table)
    table["yield_acceleration"], table["newmark_displacement"] = trajectory.read(file).attrs["value"], 0.1
    write_csv(table, study.table)
    quick = finding("yield-acceleration", value=1.7, error=0.3, coarse=4.0, fine=2.0, step_taken=True)
    write_preflight(f"{FOLDER}/preflight.csv", [Row(quick, 4, "one")])
    first = Words(build_page(study._replace(files=[*existing(FOLDER, study.sections), made]))).text.partition("One run")[0]
    headline = in_both(float(table["yield_acceleration"][0]), 0.02 * GRAVITY).replace("m/s2", "m/s²")
    assert f"Yield acceleration {headline} static, extrapolated from spacings of 2 and 1 m" in first
    assert "uses the yield acceleration by SPH." in first and "at most" not in first.partition("Shaking at which")[0]
    assert "1.7 ± 0.3" not in first, "a second number"
    words, how = limit([quick], quick.code, [], "sph yield-acceleration")
    assert words.startswith("1.7 ± 0.3 m/s2") and "a quick search before the runs" in how, "where no run has one"
    assert limit([], quick.code, [], "sph yield-acceleration") == ("not searched", "sph yield-acceleration")


def test_limits_of_several_slopes(tmp_path: Path) -> None:
    """The least and the most, of how many, and why there is none: it may be the weakest that has none."""
    values, reasons = (1.35, 1.15, math.nan), ("", "", "fails even at 0.1")
    files = [
        searched_file(tmp_path / f"factor_of_safety_S_R-{number}.nc", "factor_of_safety", value, 0.05, reason)
        for number, (value, reason) in enumerate(zip(values, reasons, strict=True))
    ]

    def told(count: slice) -> str:
        return limit([], "factor-of-safety", files[count], "sph fos")[0]

    assert told(slice(1)) == "1.35 ± 0.05 of S_R-0" and limit([], "factor-of-safety", files[:1], "")[0] == "1.35 ± 0.05 of one slope"
    quick = [finding("factor-of-safety", value=value, error=0.1, coarse=2.0, fine=1.0, step_taken=True) for value in (1.2, 1.4)]
    beside = limit(quick, "factor-of-safety", files[:1], "sph fos")[0]
    assert beside == "1.20 ± 0.10 to 1.40 ± 0.10; more closely 1.35 ± 0.05 of S_R-0", "that of one slope is not that of all"
    assert told(slice(2)) == "1.15 ± 0.05 to 1.35 ± 0.05 of 2 slopes"
    assert told(slice(3)) == "1.15 ± 0.05 to 1.35 ± 0.05 of 2 slopes; not found: fails even at 0.1"
    assert told(slice(2, 3)) == "not found: fails even at 0.1"


def test_a_search_of_an_earlier_version_is_said_to_be_of_one_spacing(tmp_path: Path) -> None:
    trajectory.write(
        tmp_path / "yield_acceleration.nc", search_group(load_scene(SCENES / "paper.yaml"), "yield_acceleration", Search(1.8, 2.2, ()))
    )
    words, how = limit([], "yield-acceleration", [str(tmp_path / "yield_acceleration.nc")], "")
    assert words == "2 m/s2 (0.204 g)" and "at the spacing of the runs alone, which makes slopes too strong" in how


def test_whether_it_stands_is_said_once() -> None:
    """The static test before the runs decides whether the slope stands; soil that softens in the runs before the shaking is told apart."""
    stands, fails = (Row(finding(code), 2, "one") for code in ("stands-unshaken", "fails-unshaken"))
    table = pd.DataFrame({"status": ["complete", "failed_unshaken"], "failed_unshaken": [1e-4, 0.2]})
    assert unshaken(table, [fails])[0] == "does not stand in 2 of 2 runs"
    assert unshaken(table, [stands])[0] == "fails in 1 of 2 runs" and "stands at peak strength" in unshaken(table, [stands])[1]
    assert unshaken(table[:1], [stands])[0] == "stands", "a particle at yield is no slope that fails"
    assert unshaken(table[:1], [])[0] == "not tested"
    narrow = Row(finding("factor-of-safety", value=1.05, error=0.1), 1, "one")
    assert unshaken(table[:1], [stands, narrow])[0] == "not certain in 1 of 1 runs"


def test_the_shaking_is_bracketed_by_the_weakest_slope() -> None:
    cohesion, shaking = Dimension("soil.cohesion", "kPa", "", False), Dimension("amplitude", "m/s2", "", False)
    rows = [("5", "1", "stable"), ("5", "2", "minor"), ("50", "1", "stable"), ("50", "2", "stable")]
    table = pd.DataFrame(rows, columns=["soil.cohesion", "amplitude", "collapse_class"]).assign(status="complete")
    assert going(table, [cohesion, shaking]) == "between 1 m/s2 (0.102 g) and 2 m/s2 (0.204 g) in the weakest case"
    assert going(table, [cohesion, shaking], missing=1) == "at most 2 m/s2 (0.204 g) in the weakest case", "a run to come may fail at less"
    assert going(table.iloc[2:], [cohesion, shaking]).startswith("no failure found up to 2 m/s2 (0.204 g)")
    assert going(table.iloc[1:2], [cohesion, shaking]).startswith("at most 2 m/s2 (0.204 g)")
    diverged = table.assign(collapse_class=["stable", "minor", UNDETERMINED, "stable"])
    assert going(diverged, [cohesion, shaking]).startswith("at most 2 m/s2 (0.204 g)"), "a run that diverged is not known to stand"
    assert going(table.drop(columns="amplitude"), [cohesion]) == "only one level of shaking was run"
    weak = table.assign(status=["failed_unshaken", "failed_unshaken", "complete", "complete"])
    assert going(weak, [cohesion, shaking]).startswith("no failure found up to 2 m/s2 (0.204 g)"), "what fails unshaken is no answer"
    assert going(weak[:2], [cohesion, shaking]) == "no answer: every run fails without shaking"
    twice = with_second_class(table, pd.DataFrame({"run": [1, 0], "second_class": ["stable", "stable"]}), [])
    assert going(twice, [cohesion, shaking]) == "not known: at 2 m/s2 (0.204 g) it depends on the spacing"
    finer = with_second_class(table, pd.DataFrame({"run": [1, 0], "second_class": ["minor", "collapse"]}), [])
    assert going(finer, [cohesion, shaking]).startswith("at most 2 m/s2 (0.204 g)"), "with other particles it fails at less"
    both = with_second_class(table, pd.DataFrame({"run": [1, 0], "second_class": ["collapse", "stable"]}), [])
    assert going(both, [cohesion, shaking]) == going(table, [cohesion, shaking])
    lost = with_second_class(table, pd.DataFrame({"run": [1, 0], "second_class": [UNDETERMINED, "stable"]}), [])
    assert going(lost, [cohesion, shaking]) == going(table, [cohesion, shaking]), "it diverged with other particles"
    many = pd.DataFrame({"amplitude": [str(1 + n / 10) for n in range(20)], "collapse_class": "minor"})
    many = many.assign(
        displacement_magnitude=2.0, runout=np.nan, newmark_displacement=np.inf, reached_side="back", findings="", at_rest=1, diverged=0
    )
    many = many.assign(energy_line_runout=np.nan, corominas_runout=np.nan)
    shown = levels(many, [shaking], "A")
    assert [tuple(row) for row in shown.rows] == [("all", "minor", "2.00", "–", "unlimited")] and "upper bound" not in shown.note
    moving = levels(many.assign(at_rest=[0, *[1] * 19]), [shaking], "A")
    assert moving.rows[0][2] == "2.00 to ≥ 2.00" and "still moved at the end" in moving.note
    further = many.assign(runout=[9.0, *[1.0] * 19], findings="thin-box block-not-rigid")
    assert levels(further.assign(reached_side="front back"), [shaking], "A").rows[0][2:4] == ("≥ 2.00", "≥ 1.00 to ≥ 9.00")
    met = levels(further.assign(reached_side=["front back", *["back"] * 19]), [shaking], "A")
    assert met.rows[0][2:4] == ("2.00 to ≥ 2.00", "1.00 to ≥ 9.00") and "would have gone further" in met.note and "upper bound" in met.note


def test_a_search_says_at_which_intensity_the_slope_goes(tmp_path: Path) -> None:
    slope = load_scene(SCENES / "gentle_layered.yaml")
    for name, unit, words in (
        ("amplitude", "m/s2", "2.5 m/s2 (0.255 g) (searched; class collapse)"),
        ("motion.factor", "-", "factor of the motion 2.5"),
    ):
        over = Searched((Dimension(name, unit, "", False),), name)
        points = pd.DataFrame({"case": "slope", name: ["2", "3"], "collapse_class": ["stable", "collapse"]})
        points = points.assign(still_moving=0, failed_fraction=0.0, wall_time=1.0)
        estimates = {("slope",): {"collapse": {"yield_acceleration": 1.0, "newmark_intensity": 2.0}}}
        write_csv(critical_table(points, ["collapse"], estimates, over), tmp_path / "trigger.csv")
        assert searched(slope, [str(tmp_path / "trigger.csv")]).startswith(words)
    assert searched(slope, []) == ""


def test_the_scene_is_told_by_names_values_and_units() -> None:
    scene = load_scene(SCENES / "gentle_layered.yaml")
    varied = {"layers.clay.soil.cohesion": "3, 10"}
    table = chosen_keys(scene_table(scene, varied))
    rows = {what: (value, unit) for what, value, unit, _ in table.rows}
    assert rows["base of the walls"] == ("absorbing", "") and rows["spacing"] == ("1", "m")
    assert rows["points"][0] == f"{len(scene.geometry.points)} values"
    at_once = chosen_keys(scene_table(scene.model_copy(update={"coupling": scene.coupling.model_copy(update={"softening": None})}), varied))
    assert "onset of failure" not in rows and ("onset of failure", "at once") in {row[:2] for row in at_once.rows}
    assert not any("." in what for what in rows)
    layers = layer_table(scene, varied)
    clay = dict(zip(layers.head, layers.rows[1], strict=True))
    assert clay["layer"] == "clay" and clay["where"] == "from 6 m below the ground to 10 m" and clay["cohesion (kPa)"] == "3, 10"
    assert clay["density (kg/m³)"] == "1850" and clay["strength ratio S_R"] == "0.25"
    assert clay["rate of the loss of strength γ (s⁻¹)"] == "0"


def test_the_page_counts_as_the_survey_does(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    data = Words(build_page(made_study(RIGHT))).runs
    assert (data["origin"], data["direction"], data["upwards"]) == ([180.0, 430.0], -1, "elevation (m)")


@pytest.mark.parametrize(
    ("cell", "shown"), [("NaN", "–"), ("0.10", "0.10"), ("0.123456789", "0.1235"), ("collapse", "collapse"), ("1e-300000", "0"), ("", "")]
)
def test_cells_are_read_as_written_or_to_four_digits(cell: str, shown: str) -> None:
    assert short(cell) == shown


def test_headings_have_the_units_that_are_declared(tmp_path: Path) -> None:
    path = tmp_path / "critical.csv"
    path.write_text("case,critical_amplitude,share\nslope,2.5,0.5\n")
    variables = [number_column("critical_amplitude", "m s-2", ""), number_column("share", "1", "")]
    assert csv_table(path, "", variables).head == ["case", "critical_amplitude (m s-2)", "share"]


def test_a_long_table_says_that_it_is_cut(tmp_path: Path) -> None:
    path = tmp_path / "long.csv"
    path.write_text("a\n" + "1\n" * 501)
    table = csv_table(path, "")
    assert len(table.rows) == 500 and table.note == "The first 500 of 501 rows."


def test_a_length_below_a_centimetre_is_told_as_that() -> None:
    """8 mm is neither nothing nor a centimetre, and at least 8 mm is at least nothing; a block that never stops has no end."""
    shown = [metres(value) for value in (0.0, 0.0084, 0.033, 0.211, 24.0, np.inf, np.nan)]
    assert shown == ["0", "< 0.01", "0.033", "0.211", "24.0", "unlimited", "–"]
    assert [metres(value, True) for value in (0.0084, 0.033, np.nan)] == ["< 0.01 ?", "≥ 0.033", "–"]


def test_a_page_for_a_client_has_no_commands_paths_and_empty_sections(study: StudyFiles) -> None:
    own, client = (Words(build_page(study._replace(client=client))).text for client in (False, True))
    commands = ("snakemake --cores", "study.csv there", "sph fos", "sph run", "claims.csv")
    for words in (*commands, "not searched", "Not computed yet", "core-hours"):
        assert words in own and words not in client, (words, client[max(client.find(words) - 80, 0) :][:200])
    for words in (
        TITLE,
        "Shaking at which it fails",
        "All runs",
        "Versions",
        "Figure 4",
        "peak horizontal acceleration",
        "size of a particle",
    ):
        assert words in client, words
    assert "docs/" not in client
    for key in ("numerics.spacing", "soil.cohesion", "few-particles", "gamma-100", "failed_unshaken", "smoothing ratio"):
        assert key in own and key not in client, key
    signed = Words(build_page(study._replace(client=True, project="Road 7", author="A. Geologist"))).text
    assert f"Road 7 · A. Geologist · {datetime.date.today().isoformat()}" in signed


def test_a_run_with_liquefied_sand_says_so_and_shows_its_pore_pressure(tmp_path: Path) -> None:
    sand = {"soil": {"blow_count": 10.0}, "water": {"pressure": "carried", "level": 10.0, "excess_pressure": {"liquefaction": {}}}}
    dry = synthetic(overrides={"numerics": {"spacing": 2.5}})
    ratio, wet = np.zeros(dry["beta"].shape), dry.soil & (dry["y0"] < 10.0)
    times = np.where(wet & (np.arange(wet.size) % 2 == 0), 5.0, np.nan)
    ratio[10:, wet] = 0.6
    liquefied = synthetic(overrides={"numerics": {"spacing": 2.5}} | sand, pore_pressure_ratio=ratio, t_f=times)
    for name, run in {"dry": dry, "liquefied": liquefied}.items():
        run.attrs["particle_steps"] = 1
        trajectory.write(tmp_path / f"{name}.nc", run.trajectory)
    shown = explorer([tmp_path / "liquefied.nc", tmp_path / "dry.nc"], "A", 10**7)
    assert list(shown["shares"].items()) == [(name, PARTICLE_FIELDS[name].label) for name in ("beta", "pore_pressure_ratio")]
    held, other = shown["runs"]
    packed = unpacked(held["shares"]["pore_pressure_ratio"], "u1", held["particles"]).reshape(len(held["times"]), -1)
    assert set(packed[-1]) == {0, 153} and np.mean(packed[-1] > 0) == pytest.approx(np.mean(wet[dry.soil]), abs=0.01), "0.6 of 255"
    assert held["liquefied"] == ["soil has liquefied: 50 % of its sand below water, half of that by 5 s, the first at 5 s"]
    assert list(other["shares"]) == ["beta"] and other["liquefied"] == []
    assert list(explorer([tmp_path / "dry.nc"], "A", 10**7)["shares"]) == ["beta"]
