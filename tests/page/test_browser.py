"""The page in a browser: another run is chosen, shown and printed, on a desk and on a phone, without a network."""

from __future__ import annotations

import base64
import json
import re
import shutil
from collections.abc import Iterator
from contextlib import chdir
from pathlib import Path
from typing import Any

import pandas as pd
import pytest
from made import FOLDER, RIGHT, listed_study, made_study
from PIL import Image
from test_answer import RUNS

from sph.figures.style import DPI
from sph.page.build import StudyFiles, write_page
from sph.page.places import at_places
from sph.page.tables import metres
from sph.study.tables import read_table

webdriver = pytest.importorskip("selenium.webdriver", reason="no browser test: selenium is missing (pip install -e '.[test]')")
wait = pytest.importorskip("selenium.webdriver.support.wait")
BROWSER = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
DRIVER = shutil.which("chromedriver")
pytestmark = pytest.mark.skipif(
    not (BROWSER and DRIVER), reason="no browser test: chromium or chromedriver is missing (apt-get install chromium chromium-driver)"
)
LABEL = "return document.getElementById(arguments[0]).ariaLabel"
DESK, PHONE = (1200, 900), (360, 740)


class Browser:
    """A page open in chromium."""

    def __init__(self, path: Path) -> None:
        options = webdriver.ChromeOptions()
        options.binary_location = BROWSER
        for argument in ("--headless=new", "--no-sandbox", "--disable-dev-shm-usage", "--disable-gpu"):
            options.add_argument(argument)
        options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
        self.driver = webdriver.Chrome(options=options, service=webdriver.ChromeService(executable_path=DRIVER))
        self.url = path.resolve().as_uri()

    def open(self, width: int, height: int, **features: str) -> None:
        """Load the page in a window of a size in CSS pixels, with media features such as ``prefers_color_scheme``."""
        size = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 600}
        self.driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
        wanted = [{"name": name.replace("_", "-"), "value": value} for name, value in features.items()]
        self.driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": wanted})
        self.driver.get(self.url)
        self.shown("S_R")

    def run(self, script: str, *arguments: Any) -> Any:
        return self.driver.execute_script(script, *arguments)

    def text(self, name: str) -> str:
        return str(self.run("return document.getElementById(arguments[0]).textContent", name))

    def shown(self, words: str, canvas: str = "profile") -> str:
        """Pixels of a canvas, once what it says of itself holds some words."""

        def ready(_: Any) -> str | None:
            label = self.run(LABEL, canvas)
            return str(self.run("return document.getElementById(arguments[0]).toDataURL()", canvas)) if words in label else None

        return str(wait.WebDriverWait(self.driver, 60, 0.05).until(ready, f"{canvas}: {words}"))

    def choose(self, name: str, value: str) -> None:
        """Click on a radio button, as a reader does: where it lies on the screen."""
        radio = self.driver.find_element("css selector", f"input[name='{name}'][value='{value}']")
        self.driver.execute_script("arguments[0].scrollIntoView({block: 'center', behavior: 'instant'})", radio)
        webdriver.ActionChains(self.driver).move_to_element(radio).click().perform()

    def press(self, key: str) -> None:
        webdriver.ActionChains(self.driver).send_keys(key).perform()

    def requests(self) -> list[str]:
        """Addresses that the page has asked for since the last look, those inside itself left out."""
        entries = [json.loads(entry["message"])["message"] for entry in self.driver.get_log("performance")]
        urls = [entry["params"]["request"]["url"] for entry in entries if entry["method"] == "Network.requestWillBeSent"]
        return [url for url in urls if not url.startswith(("data:", "blob:"))]


@pytest.fixture(scope="module")
def opened(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Browser, StudyFiles]]:
    """A browser with the page of the made study, and its files, in the working folder."""
    with chdir(tmp_path_factory.mktemp("page")):
        study = made_study()
        write_page(f"{FOLDER}/report.html", study)
        browser = Browser(Path(FOLDER, "report.html"))
        yield browser, study
        browser.driver.quit()


@pytest.fixture
def study(opened: tuple[Browser, StudyFiles]) -> StudyFiles:
    """The files behind the page."""
    return opened[1]


@pytest.fixture
def browser(opened: tuple[Browser, StudyFiles]) -> Iterator[Browser]:
    """The browser; what a test has done with the page must not have led to an error or to a request."""
    browser = opened[0]
    yield browser
    assert not [entry for entry in browser.driver.get_log("browser") if entry["level"] in ("SEVERE", "WARNING")]
    assert set(browser.requests()) == {browser.url}


def told(study: StudyFiles, S_R: str, amplitude: str) -> Any:
    table = read_table(study.table)
    return table[(table["S_R"] == S_R) & (table["amplitude"] == amplitude)].iloc[0]


@pytest.mark.parametrize("size", [DESK, PHONE], ids=["desk", "phone"])
def test_another_run_is_chosen_with_mouse_and_keyboard(study: StudyFiles, browser: Browser, size: tuple[int, int]) -> None:
    browser.open(*size)
    pictures = [(browser.shown("S_R 0.10, γ 100 s⁻¹, amplitude 6.0"), browser.shown("amplitude 6.0", "curve"))]
    assert browser.text("class") == told(study, "0.10", "6.0")["collapse_class"]
    browser.choose("amplitude", "4.0")
    pictures.append((browser.shown("S_R 0.10, γ 100 s⁻¹, amplitude 4.0"), browser.shown("amplitude 4.0", "curve")))
    row = told(study, "0.10", "4.0")
    assert browser.text("class") == row["collapse_class"] and metres(row["displacement_magnitude"]) in browser.text("numbers")
    browser.choose("S_R", "0.10")
    browser.press("\ue014")  # right arrow
    pictures.append((browser.shown("S_R 0.50, γ 100 s⁻¹, amplitude 4.0"), browser.shown("S_R 0.50", "curve")))
    assert browser.text("class") == told(study, "0.50", "4.0")["collapse_class"] == "stable"
    assert "S_R-0.50_gamma-100_amplitude-4.0.nc" in browser.text("facts")
    assert browser.run("return document.activeElement.value") == "0.50"
    assert all(len({pair[canvas] for pair in pictures}) == 3 for canvas in (0, 1))


@pytest.mark.parametrize("size", [DESK, PHONE], ids=["desk", "phone"])
def test_the_page_is_as_wide_as_the_window(browser: Browser, size: tuple[int, int]) -> None:
    browser.open(*size)
    assert browser.run("return document.documentElement.scrollWidth <= innerWidth")
    browser.run("for (const part of document.querySelectorAll('details')) part.open = true")
    assert browser.run("return document.documentElement.scrollWidth <= innerWidth")


@pytest.mark.parametrize("size", [DESK, PHONE], ids=["desk", "phone"])
def test_no_drawing_is_cut_at_its_lower_edge(browser: Browser, size: tuple[int, int]) -> None:
    browser.open(*size)
    for name in ("profile", "curve"):
        last_row = (
            f"const c = document.getElementById('{name}'); return [...c.getContext('2d').getImageData(0, c.height - 1, c.width, 1).data]"
        )
        assert set(browser.run(last_row)) == {255}, name


def test_a_diverged_run_says_so(browser: Browser) -> None:
    browser.open(*DESK)
    browser.choose("S_R", "0.50")
    browser.shown("S_R 0.50")
    assert browser.text("class") == "undetermined" and "a particle was too fast" in browser.text("numbers")
    assert browser.text("frame-note").startswith("1 of ")  # lost in the last frame
    assert "9.00" in browser.text("now")


def test_the_time_slider_goes_back_to_the_undeformed_slope(browser: Browser) -> None:
    browser.open(*DESK)
    at_end = browser.shown("at 15 s")
    browser.run("document.getElementById('time').focus()")
    browser.press("\ue011")  # home
    assert browser.shown("at 3 s") != at_end and browser.text("now").startswith("3.00")
    browser.choose("amplitude", "4.0")
    browser.shown("at 3 s, S_R 0.10, γ 100 s⁻¹, amplitude 4.0")  # another run is shown at the same time


def test_colours_follow_the_field(browser: Browser) -> None:
    browser.open(*DESK)
    before = browser.shown("displacement (m)")
    browser.run("document.querySelector('select[name=colour]').focus()")
    browser.press("w")  # the option that begins so
    assert browser.shown("weight of the solid state") != before


def test_the_chosen_run_is_announced_and_the_focus_is_seen(browser: Browser) -> None:
    browser.open(*DESK)
    assert browser.run("return document.getElementById('class').closest('[aria-live]').getAttribute('aria-live')") == "polite"
    unnamed = "return [...document.querySelectorAll('input, select, button')].filter((e) => !e.labels?.length && !e.ariaLabel).length"
    assert browser.run(unnamed) == 0
    browser.run("document.querySelector('input[name=S_R]:checked').focus()")
    browser.press("\ue014")
    outline = "return getComputedStyle(document.querySelector('input[name=S_R]:checked + span')).outlineStyle"
    assert browser.run(outline) == "solid"


def test_who_wants_no_motion_gets_none(browser: Browser) -> None:
    shown = "return getComputedStyle(document.getElementById('play')).display"
    browser.open(*DESK)
    assert browser.run(shown) != "none"
    browser.open(*DESK, prefers_reduced_motion="reduce")
    assert browser.run(shown) == "none"


def test_dark_mode_turns_the_page_and_leaves_the_pictures_white(browser: Browser) -> None:
    browser.open(*DESK, prefers_color_scheme="dark")
    backgrounds = [f"return getComputedStyle(document.querySelector('{part}')).backgroundColor" for part in ("body", "canvas", "img")]
    body, canvas, image = (browser.run(script) for script in backgrounds)
    assert body != "rgb(255, 255, 255)" and canvas == image == "rgb(255, 255, 255)"


def test_print_shows_the_chosen_run_without_controls(browser: Browser) -> None:
    browser.open(*DESK)
    browser.choose("S_R", "0.50")
    browser.choose("amplitude", "4.0")
    browser.shown("S_R 0.50, γ 100 s⁻¹, amplitude 4.0")
    browser.driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "print"})
    visible = "return document.getElementById(arguments[0]).checkVisibility()"
    assert [browser.run(visible, name) for name in ("choice", "play", "time")] == [False, False, False]
    assert [browser.run(visible, name) for name in ("title", "class", "profile", "curve")] == [True] * 4
    browser.run("document.querySelector('#answer details').open = false")
    pdf = base64.b64decode(browser.driver.execute_cdp_cmd("Page.printToPDF", {})["data"])
    assert pdf.startswith(b"%PDF") and len(pdf) > 50_000
    assert browser.run("return document.querySelector('#answer details').open"), "every warning is printed"
    widths = [int(width) for width in re.findall(rb"/Subtype /Image\s+/Width (\d+)", pdf)]
    assert widths.count(browser.run("return document.getElementById('profile').width")) == 2, "profile and curve"


@pytest.mark.parametrize("size", [DESK, PHONE], ids=["desk", "phone"])
def test_a_run_of_a_list_is_found_by_its_words(tmp_path: Path, size: tuple[int, int]) -> None:
    with chdir(tmp_path):
        write_page(f"{FOLDER}/report.html", listed_study(made_study()))
        browser = Browser(Path(FOLDER, "report.html"))
        try:
            browser.open(*size)
            first = browser.shown("S_R 0.10, γ 100 s⁻¹, amplitude 6.0")  # goes farthest
            assert browser.run("return document.documentElement.scrollWidth <= innerWidth")
            browser.run("document.getElementById('find').focus()")
            for letter in "0.50 4.0":
                browser.press(letter)
            assert browser.shown("S_R 0.50, γ 100 s⁻¹, amplitude 4.0") != first
            assert browser.run("return [...document.querySelector('select[name=run]').options].map((o) => o.value)") == ["case-000003"]
            browser.run("document.getElementById('find').value = ''; document.getElementById('find').dispatchEvent(new Event('input'))")
            assert browser.run("return document.querySelector('select[name=run]').value") == "case-000003", "what is shown stays chosen"
            browser.run("document.querySelector('select[name=run]').focus()")
            browser.press("\ue013")  # arrow up
            browser.shown("S_R 0.10, γ 100 s⁻¹, amplitude 6.0")
            for letter in "\ue004zzz":
                browser.press(letter)
            assert not [entry for entry in browser.driver.get_log("browser") if entry["level"] in ("SEVERE", "WARNING")]
        finally:
            browser.driver.quit()


@pytest.mark.parametrize(("size", "within"), [(DESK, "#answer"), (PHONE, "#overview img")], ids=["desk", "phone"])
def test_the_first_screen_shows_before_it_tells(browser: Browser, size: tuple[int, int], within: str) -> None:
    """On a desk all of the answer without scrolling; on a phone what happens and the slope, and after it the matrix and the facts."""
    browser.open(*size)
    bottom = "return document.querySelector(arguments[0]).getBoundingClientRect().bottom"
    assert 0 < browser.run(bottom, within) <= size[1]
    picture = browser.run("const of = document.querySelector('#overview img'); return [of.clientWidth, of.naturalWidth, of.naturalHeight]")
    assert picture[0] <= size[0] and (picture[1] < 800) == (size == PHONE), "a phone has a picture of its own, that need not scroll"
    assert picture[0] * DPI / (96 * picture[1]) > 0.85, "its words are hardly smaller than they are drawn"
    order = "const at = (id) => document.getElementById(id); return at(arguments[0]).compareDocumentPosition(at(arguments[1]))"
    assert browser.run(order, "overview", "answer") == browser.run(order, "answer", "explorer") == 4, "each before the next"
    assert browser.run("return document.documentElement.scrollWidth <= innerWidth"), "a matrix scrolls by itself"


def test_all_that_is_known_of_a_place_is_on_the_screen_of_a_phone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sph.page.answer.at_places", lambda *_: at_places(RUNS))
    with chdir(tmp_path):
        write_page(f"{FOLDER}/report.html", made_study())
        browser = Browser(Path(FOLDER, "report.html"))
    try:
        browser.open(*PHONE)
        cells = "[...document.querySelectorAll('#places td')].filter((of) => of.offsetParent)"
        assert max(browser.run(f"return {cells}.map((of) => of.getBoundingClientRect().right)")) <= PHONE[0]
        label = f"return {cells}.map((of) => getComputedStyle(of, '::before').content.replaceAll('\"', '') + of.textContent)"
        assert "depth up to (m): 2.10" in browser.run(label) and not any("\N{EN DASH}" in cell for cell in browser.run(label))
        browser.open(*DESK)
        assert browser.run(f"return {cells}.length") == browser.run("return document.querySelectorAll('#places td').length")
    finally:
        browser.driver.quit()


def test_a_cell_of_the_matrix_opens_its_run(browser: Browser) -> None:
    browser.open(*DESK)
    browser.driver.find_element("css selector", "#matrix a[href='#run=S_R-0.10_gamma-100_amplitude-4.0']").click()
    browser.shown("S_R 0.10, γ 100 s⁻¹, amplitude 4.0")
    assert abs(browser.run("return document.getElementById('explorer').getBoundingClientRect().top")) < 2.0


def test_an_address_names_a_run(browser: Browser, study: StudyFiles) -> None:
    wanted = "S_R-0.50_gamma-100_amplitude-4.0"
    browser.open(*DESK)
    browser.run(f"location.hash = '#run={wanted}'")
    browser.shown("S_R 0.50, γ 100 s⁻¹, amplitude 4.0")
    assert browser.run("return document.querySelector('input[name=S_R]:checked').value") == "0.50"
    browser.choose("S_R", "0.10")
    browser.shown("S_R 0.10, γ 100 s⁻¹, amplitude 4.0")
    assert browser.run("return location.hash") == "#run=S_R-0.10_gamma-100_amplitude-4.0"
    browser.driver.get("about:blank")
    browser.driver.get(f"{browser.url}#run={wanted}")
    browser.shown("S_R 0.50, γ 100 s⁻¹, amplitude 4.0")
    links = browser.run("return [...document.querySelectorAll('#runs td a')].map((link) => link.hash)")
    assert links == [f"#run={name}" for name in study.runs]
    browser.run("document.querySelector(`#runs td a[href$='S_R-0.10_gamma-100_amplitude-6.0']`).click()")
    browser.shown("S_R 0.10, γ 100 s⁻¹, amplitude 6.0")
    requests = [url.partition("#")[0] for url in browser.requests()]
    assert set(requests) <= {browser.url, "about:blank"}
    browser.driver.get(browser.url)


def test_tables_and_pictures_can_be_kept(browser: Browser, study: StudyFiles, tmp_path: Path) -> None:
    """The study's table with all metrics, the displacement of the run shown, a table as it is shown, the profile and a figure."""
    browser.driver.execute_cdp_cmd("Browser.setDownloadBehavior", {"behavior": "allow", "downloadPath": str(tmp_path)})
    browser.open(*DESK)

    def kept(kind: str) -> Path:
        before = set(tmp_path.iterdir())
        browser.run("document.querySelector(`button[data-save='${arguments[0]}']`).click()", kind)

        def done(_: Any) -> list[Path]:
            new = [path for path in tmp_path.iterdir() if path not in before]
            whole = all(path.suffix in (".csv", ".png") and path.stat().st_size for path in new)  # the browser reserves the name first
            return new if whole else []

        return wait.WebDriverWait(browser.driver, 30, 0.1).until(done, kind)[0]  # type: ignore[no-any-return]

    table = kept("study")
    assert table.name == "study.csv" and table.read_text(encoding="utf-8") == Path(study.table).read_text(encoding="utf-8")
    history = pd.read_csv(kept("history"))
    assert list(history.columns) == ["time (s)", "horizontal (m)", "vertical (m)"] and history["time (s)"].iloc[-1] == 15.0
    row = told(study, "0.10", "6.0")
    assert history["horizontal (m)"].iloc[-1] == pytest.approx(row["displacement_horizontal"], rel=1e-5)
    levels = pd.read_csv(kept("table"))
    assert list(levels["shaking (m/s²)"]) == ["4.0 (0.408 g)", "6.0 (0.612 g)"]
    for kind in ("profile", "picture"):
        with Image.open(kept(kind)) as image:
            assert image.format == "PNG"
    browser.requests()  # those of what was kept
    browser.driver.get(browser.url)


def test_a_surveyed_slope_is_drawn_in_its_coordinates(tmp_path: Path) -> None:
    """Numbers of the survey on both axes, increasing to the right also where the slope falls to the right."""
    with chdir(tmp_path):
        write_page(f"{FOLDER}/report.html", made_study(RIGHT))
        browser = Browser(Path(FOLDER, "report.html"))
        try:
            browser.open(*DESK)
            browser.run(
                "window.written = []; const fill = CanvasRenderingContext2D.prototype.fillText;"
                "CanvasRenderingContext2D.prototype.fillText = function (text, x, y) {"
                " if (this.canvas.id === 'profile') window.written.push([text, x, y]); fill.call(this, text, x, y); };"
                "document.getElementById('time').dispatchEvent(new Event('input'))"
            )
            written = browser.run("return window.written")
        finally:
            browser.driver.quit()
    words = [text for text, _, _ in written]
    assert "elevation (m)" in words and {"440", "450", "460", "100", "120"} <= set(words)
    level = next(y for text, _, y in written if text == "100")
    places = {float(text): x for text, x, y in written if y == level}
    assert len(places) >= 4 and list(places) == sorted(places) and list(places.values()) == sorted(places.values())
