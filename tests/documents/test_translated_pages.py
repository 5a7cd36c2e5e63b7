"""Pages in two languages have the same structure: headings, rows, steps, code and pictures."""

import re
import tomllib
from pathlib import Path
from typing import Final

import pytest

from app.guided.results import GuidedKind
from app.limits.limits import SETTING_BOUNDS
from app.settings.profile_file import parse_profile
from app.settings.profiles import LIMITS, NO_PROFILE, SETTINGS_BY_KEY

ROOT: Final = Path(__file__).parents[2]
PAGES: Final = tuple(sorted((*ROOT.glob("*.zh_CN.md"), *(ROOT / "docs").glob("*.zh_CN.md"))))
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


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
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
