"""Pages of the gallery are run as they are written."""

from __future__ import annotations

import io
import re
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "workflow" / "scripts" / "docs"))
from run_page import MAX_LINES, run_page  # noqa: E402

PAGE = """# A page

```sh
echo what it prints
```

```python
from pathlib import Path

Path("made").mkdir()
Path("made/picture.png").write_bytes(b"a picture")
print("| a |")
print("| --- |")
```

```yaml
is: not run
```

![A picture](made/picture.png) and [a page](../index.md)
"""
RUN = """# A page

```sh
echo what it prints
```

```text
what it prints
```


```python
from pathlib import Path

Path("made").mkdir()
Path("made/picture.png").write_bytes(b"a picture")
print("| a |")
print("| --- |")
```

| a |
| --- |


```yaml
is: not run
```

![A picture](page/made/picture.png) and [a page](../index.md)
"""


def run(tmp_path: Path, text: str) -> str:
    (tmp_path / "page.md").write_text(text, encoding="utf-8")
    run_page(str(tmp_path / "page.md"), ROOT, tmp_path / "page", io.StringIO())
    page, took = (tmp_path / "page" / "page.md").read_text(encoding="utf-8").split("\n*All commands of this page took ")
    assert re.fullmatch(r"\d+ s on .+ cores\.\*\n", took)
    return page


def test_what_is_printed_and_made_goes_into_the_page(tmp_path: Path) -> None:
    assert run(tmp_path, PAGE) == RUN
    assert (tmp_path / "page" / "made" / "picture.png").read_bytes() == b"a picture"


def test_blocks_find_the_repository(tmp_path: Path) -> None:
    text = run(tmp_path, "```sh\nls config/config.yaml docs/index.md Snakefile\n.venv/bin/python -c 'print(6 * 7)'\n```\n")
    assert text.endswith("```text\nSnakefile\nconfig/config.yaml\ndocs/index.md\n42\n```\n\n")


def test_long_output_is_cut_and_says_so(tmp_path: Path) -> None:
    text = run(tmp_path, f"```python\nfor n in range({MAX_LINES + 5}):\n    print(n)\n```\n")
    assert f"\n{MAX_LINES - 1}\n... and 5 lines more\n" in text


@pytest.mark.parametrize(
    ("block", "place", "said"),
    [
        ("```sh\necho fine\nls nothing.txt\n```\n", "the block at line 7", "nothing.txt"),
        ("```sh\nls nothing.txt | cat\n```\n", "the block at line 7", "nothing.txt"),
        ("```python\nprint(absent)\n```\n", "the block at line 7", "NameError: name 'absent'"),
    ],
)
def test_a_block_that_fails_is_named(tmp_path: Path, block: str, place: str, said: str) -> None:
    with pytest.raises(ValueError, match=rf"page\.md: {place} fails:\n(.|\n)*{said}"):
        run(tmp_path, f"# A page\n\n```sh\necho fine\n```\n\n{block}")
    assert not (tmp_path / "page").exists()


def test_every_case_of_the_gallery_is_listed() -> None:
    pages = [path for path in (ROOT / "docs" / "gallery").glob("*.md") if path.stem != "index"]
    settings, index = ((ROOT / name).read_text(encoding="utf-8") for name in ("mkdocs.yml", "docs/gallery/index.md"))
    assert len(pages) >= 6 and not [path for path in pages if f"gallery/{path.name}" not in settings or f"]({path.name})" not in index]
