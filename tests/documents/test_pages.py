"""Files that are named exist, pages in two languages have one structure, and docs/protocol.md is current. That links
lead to targets is held by lychee (.github/workflows/tests.yml)."""

import re
import tomllib
from pathlib import Path
from typing import Final

import pytest

from app.guided.results import GuidedKind
from app.limits.limits import SETTING_BOUNDS
from app.settings.profile_file import parse_profile
from app.settings.profiles import LIMITS, NO_PROFILE
from app.settings.values import SETTINGS_BY_KEY
from protocol.messages import Frame
from protocol.stream import StreamParser
from tests.support.processes import ROOT
from tests.support.setup_files import tool

PAGES: Final = tuple(
    sorted(
        page
        for folder in (ROOT, ROOT / "docs", ROOT / "docs" / "internals", ROOT / "ui" / "help" / "guide")
        for page in folder.glob("*.md")
    )
)
_NAMED_FILE = re.compile(r"`((?:\.ci|app|docs|packaging|protocol|tests|ui)/[\w./-]*\w)`")
"""A path of this tree such as `app/engine/transport.py`, without placeholders."""


def named(page: Path) -> str:
    return str(page.relative_to(ROOT))


@pytest.mark.parametrize("page", [page for page in PAGES if page.name != "CHANGELOG.md"], ids=named)
def test_files_that_are_named_exist(page: Path) -> None:
    """Change logs name old files; every other page has to name existing ones."""
    for name in _NAMED_FILE.findall(page.read_text("utf-8")):
        assert (ROOT / name).exists(), name


# Pages in two languages


TRANSLATED: Final = tuple(sorted((*ROOT.glob("*.zh_CN.md"), *(ROOT / "docs").glob("*.zh_CN.md"))))
BOTH: Final = pytest.mark.parametrize("page", ["profile.md", "profile.zh_CN.md"])


def form(text: str) -> list[str]:
    """The start of each line that is not running text, and the text in backticks."""
    prose = re.sub(r"```.*?```", "```", text, flags=re.DOTALL)
    return re.findall(r"^ *(#+|!\[|\d+\.|\||-|```)", prose, flags=re.MULTILINE)


def code(text: str) -> list[str]:
    """Commands in code blocks, without their comments, which are in the language of the page."""
    blocks = re.findall(r"```\n(.*?)```", text, flags=re.DOTALL)
    return [re.sub(r"\s+# .*", "", line) for block in blocks for line in block.splitlines()]


def pictures(text: str) -> list[str]:
    return [name.replace("zh_CN", "en") for name in re.findall(r"!\[[^\]]*\]\(([^)]+)\)", text)]


@pytest.mark.parametrize("page", TRANSLATED, ids=lambda page: page.name)
def test_a_page_has_the_same_form_in_both_languages(page: Path) -> None:
    chinese = page.read_text("utf-8")
    english = page.with_name(page.name.replace(".zh_CN", "")).read_text("utf-8")
    assert form(chinese) == form(english)
    assert code(chinese) == code(english)
    assert pictures(chinese) == pictures(english)
    assert f"]({page.name})" in english, "the English page leads to the Chinese one"


@BOTH
def test_the_profile_page_has_a_profile_that_is_accepted(page: str) -> None:
    (example,) = re.findall(r"```toml\n(.*?)```", (ROOT / "docs" / page).read_text("utf-8"), flags=re.DOTALL)
    assert parse_profile(example.encode()).settings == tomllib.loads(example)["settings"]


@BOTH
def test_the_profile_page_names_every_key_with_its_bounds(page: str) -> None:
    text = (ROOT / "docs" / page).read_text("utf-8")
    for key in (*SETTINGS_BY_KEY, *(kind.value for kind in GuidedKind)):
        assert f"`{key}`" in text, key
    to = " 到 " if "zh_CN" in page else " to "
    for key, bound in LIMITS.items():
        row = f"| `{key}` | {NO_PROFILE.limit(key):g} | {bound.low:g}{to}{bound.high:g} |"
        assert row in text
    for key, allowed in SETTING_BOUNDS.items():
        row = next(line for line in text.splitlines() if line.startswith(f"| `{key}`"))
        assert row.endswith(f" {allowed.low:g}{to}{allowed.high:g} |")


# The protocol page


protocol_page = tool("docs/generate", "protocol_page")
FRAME = re.compile(r"`((?:41 75|42 61)(?: [0-9A-F]{2})+)`")


PROTOCOL = (ROOT / "docs" / "protocol.md").read_text(encoding="utf-8")


def test_the_protocol_page_is_current() -> None:
    assert protocol_page.main(["--check"]) == 0, "run python docs/generate/protocol_page.py"


def test_every_frame_on_the_page_is_one() -> None:
    printed = {bytes.fromhex(found) for found in FRAME.findall(PROTOCOL)}
    assert len(printed) > 40
    misprint = bytes.fromhex("41 75 20 01 3C 50")
    for raw in printed - {misprint}:
        parser = StreamParser()
        (piece,) = parser.feed(raw) + parser.flush()
        assert isinstance(piece, Frame), piece
