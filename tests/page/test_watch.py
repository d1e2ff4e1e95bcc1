"""``sph check --watch`` in a browser: the section and the findings follow the scene's file."""

from __future__ import annotations

import threading
from functools import partial
from pathlib import Path

import yaml
from small_scenes import SLOPE
from test_browser import Browser, pytestmark, wait  # noqa: F401  it is skipped where there is no browser

from sph.command.check import shown
from sph.command.watch import Watched, served


def test_the_preview_follows_the_file(tmp_path: Path) -> None:
    """Saved with another title, then with a fault, which leaves the drawing, then mended."""
    path = tmp_path / "slope.yaml"

    def save(**keys: object) -> None:
        path.write_text(yaml.safe_dump(SLOPE | keys))

    save(title="first")
    with served(Watched(path, partial(shown, path, {}, None))) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        browser = Browser(path)
        try:
            browser.driver.get(f"http://127.0.0.1:{server.server_port}/")

            def waits_for(words: str) -> None:
                def there(_: object) -> bool:
                    return words in str(browser.run("return document.querySelector('pre').textContent"))

                wait.WebDriverWait(browser.driver, 60, 0.1, ignored_exceptions=[Exception]).until(there, words)

            waits_for("slope: first")
            assert "particles" in str(browser.run("return document.querySelector('pre').textContent"))
            assert browser.run("return document.querySelector('svg').getBoundingClientRect().width") > 300
            save(title="second")
            waits_for("slope: second")
            save(duration=-1)
            waits_for("duration: Input should be greater than 0")
            assert browser.run("return document.querySelectorAll('pre.refused, svg').length") == 2, "the last drawing stays"
            save(title="third")
            waits_for("slope: third")
            assert not [entry for entry in browser.driver.get_log("browser") if entry["level"] == "SEVERE"]
        finally:
            browser.driver.quit()
            server.shutdown()
