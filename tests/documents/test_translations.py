"""The Chinese translation is complete, and its check finds errors."""

import json
from pathlib import Path

import pytest

from app.text.i18n import read_messages, read_translations
from tests.support.setup_files import generator

translations = generator("translations")


def extracted(source: str) -> tuple[list[str], list[str]]:
    found = translations.Extract()
    translations.extract(source, "x.py", found)
    return sorted(found.texts), found.faults


def test_every_text_is_in_chinese() -> None:
    found = translations.extract_all()
    assert found.texts
    problems = list(translations.problems(found, translations.read_ts()))
    assert not problems, "\n".join(problems)


def test_what_is_checked_is_what_the_program_reads() -> None:
    finished = {english: one.chinese for english, one in translations.read_ts().items() if one.is_finished}
    assert read_messages(translations.TS) == finished
    assert finished.items() <= read_translations(translations.TS).items()


@pytest.mark.parametrize(
    ("source", "texts"),
    [
        ("tr('Tilt')", ["Tilt"]),
        ("i18n.tr('Tilt')", ["Tilt"]),
        ("NAME = marked('Ti' 'lt')", ["Tilt"]),
        ("tr('A' if x else 'B')", ["A", "B"]),
        ("tr('{n} frames', n=1)", ["{n} frames"]),
        ("tr('{n} frames', **values)", ["{n} frames"]),
        ("marked('{n} frames')", ["{n} frames"]),
        ("tr(NAME), tr(self.name, n=1), tr(NAMES[key])", []),
        ("print('Tilt')", []),
    ],
)
def test_texts_are_found(source: str, texts: list[str]) -> None:
    assert extracted(source) == (texts, [])


@pytest.mark.parametrize(
    ("source", "part"),
    [
        ("tr(f'{n} frames')", "f-string"),
        ("marked(f'{n} frames')", "f-string"),
        ("tr('a' + name)", "wants a literal"),
        ("tr(name())", "wants a literal"),
        ("tr('{n} frames'.format(n=1))", "wants a literal"),
        ("marked(NAME)", "wants a literal"),
        ("tr('{n} frames')", "placeholders n, values none"),
        ("tr('{n} frames', count=1)", "placeholders n, values count"),
        ("tr('frames', n=1)", "placeholders none, values n"),
    ],
)
def test_wrong_calls_are_found(source: str, part: str) -> None:
    _, faults = extracted(source)
    assert len(faults) == 1
    assert part in faults[0]


def test_problems_are_found() -> None:
    found = translations.Extract(texts=dict.fromkeys(("missing", "unfinished", "{n} ms", "good {n}"), "x.py:1"))
    messages = {
        "unfinished": translations.Translation("未", is_finished=False),
        "{n} ms": translations.Translation("{m} 毫秒", is_finished=True),
        "good {n}": translations.Translation("好 {n}", is_finished=True),
        "gone": translations.Translation("去", is_finished=True),
    }
    listed = list(translations.problems(found, messages))
    assert len(listed) == 4
    for part in ("missing", "unfinished", "placeholders", "gone"):
        assert any(part in line for line in listed), part


def test_a_capital_a_stop_and_an_ellipsis_follow() -> None:
    texts = dict.fromkeys(("lock", "Lock…", "Lock.", "LOCK", "Open", "open"), "x.py:1")
    messages = {
        english: translations.Translation(chinese, is_finished=True)
        for english, chinese in {"lock": "锁定", "LOCK": "锁定", "open": "未完成", "Open": "打开"}.items()
    }
    new = translations.updated(texts, messages)
    assert sorted(new) == ["Open", "lock", "open"]
    found = translations.Extract(texts=texts)
    assert list(translations.problems(found, new)) == []
    assert [line.split(": ", 1)[1] for line in translations.problems(found, messages)] == [
        "follows from another: 'LOCK'"
    ]


def test_update_keeps_adds_and_removes(tmp_path: Path) -> None:
    old = {"kept <&>": translations.Translation("留 <&>", is_finished=True), "gone": ("去", True)}
    new = translations.updated({"kept <&>": "x", "added\nline": "x"}, old)
    path = tmp_path / "zh_CN.ts"
    translations.write_ts(new, path)
    first = path.read_bytes()
    assert translations.read_ts(path) == new
    assert read_messages(path) == {"kept <&>": "留 <&>"}
    translations.write_ts(dict(reversed(translations.read_ts(path).items())), path)
    assert path.read_bytes() == first


def test_merge_fills_in_only_what_fits(tmp_path: Path) -> None:
    first = {"Tilt": "倾角", "Gone": "去", "{n} ms": "{m} 毫秒", "Done": "别", "Nothing": ""}
    (tmp_path / "a.json").write_text(json.dumps(first), encoding="utf-8")
    (tmp_path / "b.json").write_text(json.dumps({"Tilt": "倾斜"}), encoding="utf-8")
    messages = translations.updated(dict.fromkeys(("Tilt", "{n} ms", "Done", "Nothing"), "x"), {})
    messages["Done"] = translations.Translation("完成", is_finished=True)
    refused = list(translations.merge(tmp_path, messages))
    assert messages["Tilt"] == ("倾角", True)
    assert messages["Done"] == ("完成", True)
    assert not messages["{n} ms"].is_finished
    assert not messages["Nothing"].is_finished
    assert len(refused) == 5
    assert "a.json" in refused[-1]
    assert "倾斜" in refused[-1]


def test_corrections_replace_what_is_finished(tmp_path: Path) -> None:
    (tmp_path / "a-corrections.json").write_text(json.dumps({"Tilt": "倾角", "Gone": "去"}), encoding="utf-8")
    (tmp_path / "b.json").write_text(json.dumps({"Tilt": "倾斜"}), encoding="utf-8")
    messages = {"Tilt": translations.Translation("斜", is_finished=True)}
    refused = list(translations.merge(tmp_path, messages, over="a-corrections.json"))
    assert messages["Tilt"] == ("倾角", True)
    assert len(refused) == 2  # b's, because there was one; and what is gone from the source
