"""Translation at run time, also with bad translations; joining sentences and lists in both languages."""

import ast
import logging
import re
import string
from collections.abc import Iterator
from pathlib import Path
from xml.sax.saxutils import escape

import pytest
from PySide6.QtWidgets import QHBoxLayout, QLabel, QPushButton, QVBoxLayout, QWidget
from pytestqt.qtbot import QtBot

from app.text import i18n
from app.text.csv_cells import cell, defused
from app.text.i18n import CHINESE, ENGLISH, set_language, system_language, tr
from app.text.messages import UserMessage, joined
from app.text.sentences import capitalised, join_names, join_sentences, with_units
from tests.support.pseudo_language import PSEUDO, pseudo
from tests.support.window.cut_off import cut_off
from tests.support.window.spoken import untranslated

Messages = dict[str, tuple[str, str]]


def write_ts(path: Path, messages: Messages) -> str:
    """A .ts file of English -> (translation, type or ""); returns its path as text."""
    lines = "".join(
        f"<message><source>{escape(english)}</source>"
        f"<translation{_type_attribute(kind)}>{escape(text)}</translation></message>"
        for english, (text, kind) in messages.items()
    )
    path.write_text(f"<!DOCTYPE TS><TS><context><name>dps-s</name>{lines}</context></TS>", encoding="utf-8")
    return str(path)


def _type_attribute(kind: str) -> str:
    return f' type="{kind}"' if kind else ""


def test_english_is_the_text_itself() -> None:
    assert i18n.language() == "en"
    assert tr("Tilt") == "Tilt"
    assert tr("{name} took {ms:.1f} ms", name="Tilt", ms=2) == "Tilt took 2.0 ms"


def test_braces_without_values_stay() -> None:
    assert tr("a set {1, 2}") == "a set {1, 2}"


def test_finished_translations_are_used_and_others_are_not(tmp_path: Path) -> None:
    messages = {
        "Tilt": ("倾角", ""),
        "Light": ("光线", "unfinished"),
        "Old": ("旧", "vanished"),
        "Empty": ("", ""),
        "a < b & c": ("甲 < 乙 & 丙", ""),
    }
    set_language(write_ts(tmp_path / "pseudo.ts", messages))
    assert [tr(text) for text in ("Tilt", "Light", "Old", "Empty", "Unknown")] == [
        "倾角",
        "Light",
        "Old",
        "Empty",
        "Unknown",
    ]
    assert tr("a < b & c") == "甲 < 乙 & 丙"


@pytest.mark.parametrize("bad", ["{nam} ms", "{name", "{0}", "{name.missing}", "{name:d}", "{name[3}"])
def test_a_translation_that_cannot_be_filled_in_gives_the_english(
    bad: str, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    set_language(write_ts(tmp_path / "pseudo.ts", {"{name} ms": (bad, "")}))
    with caplog.at_level(logging.WARNING):
        assert tr("{name} ms", name="x") == "x ms"
    assert "cannot be filled in" in caplog.text


def test_an_english_text_that_does_not_fit_its_values_raises() -> None:
    with pytest.raises(KeyError):
        tr("{name}", other=1)


def test_a_broken_file_leaves_english(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    broken = tmp_path / "broken.ts"
    broken.write_text("<TS><context>", encoding="utf-8")
    for path in (broken, tmp_path / "missing.ts"):
        set_language(str(path))
        assert tr("Tilt") == "Tilt"
        assert i18n.language() == str(path)
    assert caplog.text.count("No translations") == 2


def test_an_unknown_language_is_refused_and_changes_nothing() -> None:
    with pytest.raises(ValueError, match="fr"):
        set_language("fr")
    assert i18n.language() == "en"


def test_chinese_can_be_set() -> None:
    set_language("zh_CN")
    assert i18n.language() == "zh_CN"


@pytest.mark.parametrize(
    ("environ", "expected"),
    [
        ({}, "en"),
        ({"LANG": "C"}, "en"),
        ({"LANG": "en_US.UTF-8"}, "en"),
        ({"LANG": "zh_CN.UTF-8"}, "zh_CN"),
        ({"LANG": "zh_SG"}, "zh_CN"),
        ({"LANG": "zh"}, "zh_CN"),
        ({"LANG": "zh_CN.GB18030@stroke"}, "zh_CN"),
        ({"LANG": "zh-Hans-CN"}, "zh_CN"),
        ({"LANG": "zh_TW.UTF-8"}, "en"),
        ({"LANG": "zh_Hant_HK"}, "en"),
        ({"LANG": "Chinese (Simplified)_China.936"}, "zh_CN"),
        ({"LANG": "Chinese (Traditional)_Taiwan.950"}, "en"),
        ({"LANG": "zh_CN.UTF-8", "LC_MESSAGES": "en_GB.UTF-8"}, "en"),
        ({"LANG": "en_US.UTF-8", "LC_ALL": "zh_CN.UTF-8"}, "zh_CN"),
        ({"LANG": "en_US.UTF-8", "LANGUAGE": "zh_CN:en"}, "zh_CN"),
        ({"LANG": "C.UTF-8", "LANGUAGE": "zh_CN"}, "en"),
        ({"LC_ALL": "", "LANG": "zh_CN"}, "zh_CN"),
    ],
)
def test_system_language(environ: dict[str, str], expected: str) -> None:
    assert system_language(environ) == expected


def test_system_language_asks_the_platform_where_nothing_is_set(monkeypatch: pytest.MonkeyPatch) -> None:
    for variable in ("LC_ALL", "LC_MESSAGES", "LANG", "LANGUAGE"):
        monkeypatch.delenv(variable, raising=False)
    monkeypatch.setattr("locale.getlocale", lambda: ("Chinese (Simplified)_China", "936"))
    assert system_language() == "zh_CN"
    monkeypatch.setattr("locale.getlocale", lambda: (None, None))
    assert system_language() == "en"


# The pseudo-language, and the helpers that find cut-off and untranslated texts


SENTENCES = (
    "Tilt", "Measure…", "&File", "{time} ago", "The module is ACTIVE: lock it first.", "Picture (*.png)", "a\nb word",
)  # fmt: skip


@pytest.mark.parametrize("text", SENTENCES)
def test_a_pseudo_text_is_longer_and_keeps_placeholders(text: str) -> None:
    made = pseudo(text)
    assert 1.3 <= len(made) / len(text) <= 1.8
    assert (made[0], made[-1]) == ("[", "]")
    fields = [name for _, name, _, _ in string.Formatter().parse(text)]
    assert [name for _, name, _, _ in string.Formatter().parse(made)] == fields
    for kept in ("&", "…", "*.png", "\n"):
        assert (kept in made) == (kept in text)


def test_units_and_numbers_are_left_alone() -> None:
    assert [pseudo(text) for text in ("{volts:.2f} V", "−{seconds} s", "01", "E3")] == [
        "{volts:.2f} V", "−{seconds} s", "01", "E3",
    ]  # fmt: skip


def test_placeholders_are_filled_in() -> None:
    set_language(PSEUDO)
    assert tr("{time} ago", time="12 s").startswith("[12 s ")
    assert i18n.language() == PSEUDO


def test_a_text_that_is_not_translated_is_found(qtbot: QtBot) -> None:
    set_language(PSEUDO)
    row = Row(qtbot, width=500)
    row.label.setText(tr("A text of some length"))
    assert [fault.split(",")[0] for fault in untranslated(row)] == ["QPushButton"]


class Row(QWidget):
    """One label beside one button, for what the finder has to find."""

    def __init__(self, qtbot: QtBot, *, width: int) -> None:
        super().__init__()
        qtbot.addWidget(self)
        self.label, self.button = QLabel("A text of some length"), QPushButton("And a button")
        row = QHBoxLayout(self)
        row.addWidget(self.label)
        row.addWidget(self.button)
        self.setFixedWidth(width)
        self.show()


def test_squeezed_texts_are_found(qtbot: QtBot) -> None:
    assert cut_off(Row(qtbot, width=500)) == []
    narrow = Row(qtbot, width=500)
    narrow.label.setFixedWidth(40)
    narrow.button.setFixedWidth(50)
    found = cut_off(narrow)
    assert len(found) == 2
    assert "A text of some length" in found[0]
    assert "And a button" in found[1]
    narrow.label.setToolTip("A text of some length")
    narrow.button.setAccessibleName("And a button")
    assert cut_off(narrow) == []


def test_overlapping_and_outside_widgets_are_found(qtbot: QtBot) -> None:
    one = QWidget()
    qtbot.addWidget(one)
    one.resize(300, 100)
    first, second, third = (QLabel(text, one) for text in ("one", "two", "three"))
    first.setGeometry(10, 10, 80, 30)
    second.setGeometry(60, 20, 80, 30)
    third.setGeometry(260, 10, 80, 30)
    one.show()
    found = " | ".join(cut_off(one))
    assert "overlap by 30x20" in found
    assert "outside its parent" in found


def test_wrapped_texts_without_height_are_found(qtbot: QtBot) -> None:
    one = QWidget()
    qtbot.addWidget(one)
    label = QLabel("words that need three lines or four", wordWrap=True)
    QVBoxLayout(one).addWidget(label)
    one.setFixedSize(120, 30)
    one.show()
    assert any("of height" in fault for fault in cut_off(one))


# What is kept may be read in another language: a record, a fact


ROOT = Path(__file__).parents[3]
ONE_LANGUAGE = ("app/cli/", "app/terminal/", "app/__main__.py")
"""A command ends in the language in which it began."""


def calls_now(node: ast.AST) -> Iterator[ast.AST]:
    """What is called when this is, without what functions in it would call."""
    if not isinstance(node, ast.Lambda):
        yield node
        for child in ast.iter_child_nodes(node):
            yield from calls_now(child)


def is_translated(node: ast.AST) -> bool:
    for one in calls_now(node):
        match one:
            case ast.Call(func=ast.Name(id="tr" | "join_sentences") | ast.Attribute(attr="translated" | "tr")):
                return True
            case ast.Attribute(attr="sentence", ctx=ast.Load()):
                return True
    return False


def kept_in(source: str) -> Iterator[tuple[int, str]]:
    """Line and target of each translated text that an attribute keeps, or an exception takes along."""
    is_any = re.search(r"\b(tr|join_sentences|translated|sentence)\b", source)
    for node in ast.walk(ast.parse(source)) if is_any else ():
        match node:
            case ast.Assign(targets=[target], value=value) | ast.AnnAssign(target=target, value=ast.expr() as value):
                place = target.value if isinstance(target, ast.Subscript) else target
                if isinstance(place, ast.Attribute) and is_translated(value):
                    yield node.lineno, ast.unparse(target)
            case ast.Raise(exc=ast.Call() as error) if is_translated(error):
                yield node.lineno, ast.unparse(error.func)


def test_no_translated_text_is_kept() -> None:
    found = []
    for file in sorted((ROOT / "app").rglob("*.py")):
        name = file.relative_to(ROOT).as_posix()
        if not name.startswith(ONE_LANGUAGE):
            kept = kept_in(file.read_text(encoding="utf-8"))
            found += [f"{name}:{line}: {what}" for line, what in kept]
    assert found == []


@pytest.mark.parametrize(
    ("code", "is_kept"),
    [
        ("self.why = tr('Lost.')", True),
        ("self.why: str = error.sentence", True),
        ("raise Refused(message('{why}', why=tr('Lost.')))", True),
        ("self.why = lambda: tr('Lost.')", False),
        ("self.why = message(marked('Lost.'))", False),
        ("why = tr('Lost.')", False),
    ],
)
def test_what_counts_as_kept(code: str, is_kept: bool) -> None:
    assert bool(list(kept_in(code))) is is_kept


# Sentences and lists


@pytest.fixture(autouse=True)
def in_english_again() -> Iterator[None]:
    yield
    set_language(ENGLISH)


def test_sentences_are_joined_as_in_their_language() -> None:
    assert join_sentences(["Fires at 20°.", "", "Rearms at 10°."]) == "Fires at 20°. Rearms at 10°."
    assert join_sentences(["在 20° 开伞。", "在 10° 复位。"]) == "在 20° 开伞。在 10° 复位。"


def test_names_are_joined_with_the_comma_of_the_language() -> None:
    assert join_names(["Tilt", "Light"]) == "Tilt, Light"
    set_language(CHINESE)
    assert join_names(["倾角", "光线"]) == "倾角、光线"


def test_the_first_letter_becomes_a_capital() -> None:
    assert capitalised("advised: 55° or more.") == "Advised: 55° or more."
    assert capitalised("") == ""


def test_joined_messages_have_the_comma_of_the_language_that_they_are_read_in() -> None:
    both = joined([UserMessage("M-07"), UserMessage("H6"), UserMessage("1, 2")])
    set_language(CHINESE)
    assert both.translated() == "M-07，H6，1, 2"
    assert joined([UserMessage("M-07"), UserMessage("H6")], " + ").translated() == "M-07 + H6"
    set_language(ENGLISH)
    assert both.translated() == both.in_english() == "M-07, H6, 1, 2"
    assert both.to_json()["text"] == "{p0}, {p1}, {p2}"  # as records store it


def test_joined_messages_that_are_sentences_have_the_space_of_the_language() -> None:
    both = joined([UserMessage("A jolt may fire it."), UserMessage("Choose a port.")], " ")
    assert both.translated() == both.in_english() == "A jolt may fire it. Choose a port."
    set_language(CHINESE)
    assert both.translated() == "颠簸即可能触发。请选择串口。"


def test_a_number_keeps_its_unit() -> None:
    assert with_units("Below 0.5 g for 2.00 s: 3 steps, 低于 0.5 g 达") == (
        "Below 0.5\u00a0g for 2.00\u00a0s: 3 steps, 低于 0.5\u00a0g 达"
    )


# CSV cells: none is a formula in a spreadsheet


@pytest.mark.parametrize(
    "text",
    [
        *("=1+1", "+1", "-1", "@SUM(A1)", "|cmd", "%1", "'=1"),
        *("＝1+1", "＋1", "－1", "＠SUM(A1)"),
        *("\t=1", "\r=1", "  =1", " ＋1"),
    ],
)
def test_no_cell_is_a_formula(text: str) -> None:
    assert defused(text) == f"'{text}"
    assert cell(text) == f"'{text}"
    assert cell([text, 1]) == f"'{text} 1"


@pytest.mark.parametrize("text", ["41 75", "a=1", "", "激活"])
def test_other_text_is_left_as_it_is(text: str) -> None:
    assert defused(text) == cell(text) == text


@pytest.mark.parametrize(
    ("value", "expected"), [(None, ""), (True, "true"), (False, "false"), (-1.5, "-1.5"), (0, "0"), ([1, 2], "1 2")]
)
def test_a_number_stays_a_number(value: object, expected: str) -> None:
    assert cell(value) == expected
