"""The Chinese translation is complete, and the tool that keeps it takes nothing away."""

from pathlib import Path

import pytest

from app.text.i18n import read_messages
from tests.support.setup_files import tool

translations = tool("docs/generate", "translations")


def test_every_text_is_in_chinese() -> None:
    found = translations.extract_all()
    assert found.texts
    problems = list(translations.problems(found, translations.read_ts()))
    assert not problems, "\n".join(problems)


@pytest.mark.parametrize(
    ("source", "texts", "fault"),
    [
        ("i18n.tr('Tilt'), marked('Ti' 'lt')", ["Tilt"], ""),
        ("tr('A' if x else 'B')", ["A", "B"], ""),
        ("tr('{n} frames', n=1), tr(self.name, n=1), tr(NAMES[key])", ["{n} frames"], ""),
        ("tr(f'{n} frames')", [], "f-string"),
        ("tr('a' + name)", [], "wants a literal"),
        ("tr('{n} frames', count=1)", ["{n} frames"], "placeholders n, values count"),
    ],
)
def test_texts_and_wrong_calls_are_found(source: str, texts: list[str], fault: str) -> None:
    found = translations.Extract()
    translations.extract(source, "x.py", found)
    assert sorted(found.texts) == texts
    assert len(found.faults) == bool(fault)
    assert fault in "".join(found.faults)


def test_what_is_missing_unfinished_or_left_over_is_a_problem() -> None:
    found = translations.Extract(
        texts=dict.fromkeys(("missing", "unfinished", "{n} ms", "{n:.1f} s", "good {n}"), "x.py:1")
    )
    messages = {
        "unfinished": translations.Translation("未", is_finished=False),
        "{n} ms": translations.Translation("{m} 毫秒", is_finished=True),
        "{n:.1f} s": translations.Translation("{n} 秒", is_finished=True),
        "good {n}": translations.Translation("好 {n}", is_finished=True),
        "gone": translations.Translation("去", is_finished=True),
    }
    listed = list(translations.problems(found, messages))
    assert len(listed) == 5
    for part in ("missing", "unfinished", "placeholders", "gone"):
        assert any(part in line for line in listed), part


def test_an_update_keeps_adds_and_removes(tmp_path: Path) -> None:
    old = {"kept <&>": translations.Translation("留 <&>", is_finished=True), "gone": ("去", True)}
    new = translations.updated({"kept <&>": "x", "added\nline": "x"}, old)
    path = tmp_path / "zh_CN.ts"
    translations.write_ts(new, path)
    assert translations.read_ts(path) == new
    assert read_messages(path) == {"kept <&>": "留 <&>"}
