"""``sph check --watch``: a page in the browser with the section and the findings of a scene, which follows its files."""

from __future__ import annotations

import html
import io
import os
from collections.abc import Callable
from contextlib import suppress
from http.server import BaseHTTPRequestHandler, HTTPServer
from pathlib import Path
from typing import NamedTuple

PAGE = """<!doctype html>
<html lang="en"><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1"><title>{title}</title>
<style>body {{ font: 15px/1.45 system-ui, sans-serif; margin: 1rem auto; max-width: 75rem; padding: 0 1rem }}
svg {{ width: 100%; height: auto }} pre {{ white-space: pre-wrap; overflow-wrap: anywhere }} .refused {{ color: #a00 }}</style>
<h1>{title}</h1><div>{picture}</div><pre class="{kind}">{text}</pre>
<script>setInterval(async () => {{
  try {{ if (await (await fetch("state")).text() !== "{state}") location.reload() }} catch {{ document.title = "stopped: {title}" }}
}}, 1000)</script></html>
"""
"""What the browser shows; it asks every second whether a file was saved."""


class Shown(NamedTuple):
    """A scene as it was last looked at."""

    picture: str
    """SVG; that of the last scene that was not refused"""
    text: str
    files: list[str]
    """that it was read from"""
    refused: bool = False


class Watched:
    """A scene that is looked at again when one of its files was saved."""

    def __init__(self, path: Path, look: Callable[[], Shown]) -> None:
        self.path, self._look = path, look
        self._shown, self._seen = Shown("", "", [str(path)]), ""

    @property
    def state(self) -> str:
        """What changes when a file is saved."""
        return " ".join(map(_stamp, self._shown.files))

    def page(self) -> str:
        """The page as of now."""
        if self._seen != self.state:
            try:
                self._shown = self._look()
            except (OSError, ValueError) as error:
                self._shown = self._shown._replace(text=str(error), refused=True)
            self._seen = self.state
        title, kind = html.escape(self.path.name), "refused" if self._shown.refused else ""
        return PAGE.format(title=title, picture=self._shown.picture, text=html.escape(self._shown.text), kind=kind, state=self._seen)


def _stamp(file: str) -> str:
    try:
        status = os.stat(file)
    except OSError:
        return "-"
    return f"{status.st_mtime_ns}.{status.st_size}"


def served(watched: Watched) -> HTTPServer:
    """A server of the page on this machine alone, at a free port."""

    class Handler(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            answers: dict[str, Callable[[], str]] = {"/": watched.page, "/state": lambda: watched.state, "/favicon.ico": str}
            answer = answers.get(self.path)
            body = b"" if answer is None else answer().encode()
            self.send_response(404 if answer is None else 200)
            self.send_header("Content-Type", "text/html; charset=utf-8")
            self.send_header("Cache-Control", "no-store")
            self.end_headers()
            self.wfile.write(body)

        def log_message(self, format: str, *args: object) -> None:
            """Says nothing."""

    return HTTPServer(("127.0.0.1", 0), Handler)


def svg(save: Callable[[io.BytesIO], None]) -> str:
    """A drawing as it stands in a page, from what writes it into a file."""
    file = io.BytesIO()
    save(file)
    text = file.getvalue().decode()
    return text[text.index("<svg") :]


def watch(path: Path, look: Callable[[], Shown], say: Callable[[str], None]) -> None:
    """Serve the page until the command is interrupted; ``say`` is told its address."""
    with served(Watched(path, look)) as server:
        say(f"open http://127.0.0.1:{server.server_port}/ in a browser; it follows {path}; end with Ctrl-C")
        with suppress(KeyboardInterrupt):
            server.serve_forever()
