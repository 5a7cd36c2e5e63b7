"""Links to pages, pictures and headings lead to existing targets."""

import re
from pathlib import Path
from typing import Final
from urllib.parse import unquote

import pytest

ROOT: Final = Path(__file__).parents[2]
PAGES: Final = tuple(
    sorted(page for folder in (ROOT, ROOT / "docs", ROOT / "ui" / "help" / "guide") for page in folder.glob("*.md"))
)
_LINK = re.compile(r"\]\(<?([^)\s>]+)>?(?:\s+\"[^\"]*\")?\)")
_CODE = re.compile(r"```.*?```|`[^`\n]*`", re.DOTALL)
_HEADING = re.compile(r"^#+ +(.+?) *$", re.MULTILINE)
_NAMED_FILE = re.compile(r"`((?:\.ci|app|docs|packaging|protocol|tests|ui)/[\w./-]*\w)`")
"""A path of this tree such as `app/engine/transport.py`, without placeholders."""


def named(page: Path) -> str:
    return str(page.relative_to(ROOT))


def links(text: str) -> list[str]:
    """The local targets, in order."""
    return [link for link in _LINK.findall(_CODE.sub("", text)) if "://" not in link and not link.startswith("mailto:")]


def anchors(page: Path) -> set[str]:
    """The anchor of a heading, as on GitHub and GitLab."""
    headings = _HEADING.findall(_CODE.sub(lambda code: code[0] if "\n" not in code[0] else "", page.read_text("utf-8")))
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


def test_there_are_pages() -> None:
    assert {"README.md", "CHANGELOG.md", "docs/protocol.md"} <= {named(page) for page in PAGES}


@pytest.mark.parametrize("page", PAGES, ids=named)
def test_every_link_has_a_target(page: Path) -> None:
    for link in links(page.read_text("utf-8")):
        path, _, anchor = unquote(link).partition("#")
        target = page.parent / path if path else page
        assert target.exists(), link
        assert target.resolve().is_relative_to(ROOT), f"{link} leads out of the repository"
        if anchor:
            assert anchor in anchors(target), link


@pytest.mark.parametrize("page", [page for page in PAGES if page.name != "CHANGELOG.md"], ids=named)
def test_files_that_are_named_exist(page: Path) -> None:
    """Change logs name old files; every other page has to name existing ones."""
    for name in _NAMED_FILE.findall(page.read_text("utf-8")):
        assert (ROOT / name).exists(), name


def test_every_page_of_the_documents_is_reached_from_the_first_one() -> None:
    reached, waiting = set[Path](), [ROOT / "README.md"]
    while waiting:
        page = waiting.pop().resolve()
        if page.suffix == ".md" and page.is_file() and page not in reached:
            reached.add(page)
            waiting += [page.parent / unquote(link).partition("#")[0] for link in links(page.read_text("utf-8"))]
    assert [named(page) for page in PAGES if page.resolve() not in reached] == []
