"""Saving CSV and pictures on the Live page, and the reported outcome."""

import csv
import io
from collections.abc import Iterator
from datetime import UTC, datetime
from itertools import repeat
from pathlib import Path
from unittest.mock import Mock

import pytest
from PySide6.QtCore import QEvent, Qt
from PySide6.QtGui import QImage
from PySide6.QtWidgets import QApplication, QWidget
from pytestqt.qtbot import QtBot

from app.text.i18n import CHINESE, set_language
from tests.support.window.live_bench import Bench, live_bench
from tests.support.window.steps import choosing, let_lay_out
from ui.core.texts import Texts
from ui.files.file_dialogs import ThenPath, default_name
from ui.files.save_bar import SaveBar
from ui.style.theme import Meaning, Space


@pytest.fixture
def live(qtbot: QtBot, qapp: QApplication) -> Iterator[Bench]:
    with live_bench(qtbot, qapp) as bench:
        yield bench


def save(live: Bench, name: str, path: Path | None) -> list[Path]:
    """Click a button with a person who chooses `path`; what was suggested."""
    suggested: list[Path] = []

    def choose(_parent: QWidget, _title: str, one: Path, _filter: str, then: ThenPath) -> None:
        suggested.append(one)
        if path is not None:
            then(path)

    live.page.save.note.ask_path = choose
    live.click(name)
    live.qtbot.waitUntil(lambda: not live.page.save.note.is_saving)
    live.page.refresh()
    return suggested


def test_the_values_in_sight_are_saved(live: Bench, tmp_path: Path) -> None:
    live.say()
    live.now_s += 100  # the first one is out of sight
    live.say(tilt_deg=20)
    live.now_s += 1
    live.say(tilt_deg=61, active=True)
    path = tmp_path / "values.csv"
    suggested = save(live, "live_save_csv", path)
    assert suggested[0].name.startswith("dps-s ttyUSB0 20")
    assert suggested[0].suffix == ".csv"
    rows = list(csv.DictReader(io.StringIO(path.read_text("utf-8-sig"), newline="")))
    assert [(row["tilt_deg"], row["active"]) for row in rows if row["tilt_deg"]] == [("20", "false"), ("61", "true")]
    assert [row["event"] for row in rows if row["event"]] == ["activated"]
    assert {row["cell_voltage_v"] for row in rows} == {"", "3.94"}
    note = live.page.save.note
    assert (note.text, note.meaning) == (f"Saved to {path}. Rows: {len(rows)}.", Meaning.GOOD)


def test_saved_values_are_those_at_the_time_of_the_click(live: Bench, tmp_path: Path) -> None:
    live.say()
    path = tmp_path / "values.csv"

    def choose_late(_parent: QWidget, _title: str, _one: Path, _filter: str, then: ThenPath) -> None:
        live.now_s += 2
        live.say(tilt_deg=99)  # acquisition goes on behind the dialog
        then(path)

    live.page.save.note.ask_path = choose_late
    live.qtbot.keyClick(live.page, Qt.Key.Key_S, Qt.KeyboardModifier.ControlModifier)
    live.qtbot.waitUntil(lambda: not live.page.save.note.is_saving)
    assert ",99," not in path.read_text("utf-8-sig")
    assert ",12," in path.read_text("utf-8-sig")


def test_no_file_without_a_choice(live: Bench, tmp_path: Path) -> None:
    live.say()
    save(live, "live_save_csv", None)
    assert live.page.save.note.text == ""
    assert not live.page.save.note.is_saving


def test_the_outcome_follows_the_language(live: Bench, tmp_path: Path) -> None:
    live.say()
    path = tmp_path / "values.csv"
    save(live, "live_save_csv", path)
    set_language(CHINESE)
    QApplication.sendEvent(live.page, QEvent(QEvent.Type.LanguageChange))
    assert live.page.save.note.text == f"已保存到 {path}。行数：{len(path.read_text('utf-8-sig').splitlines()) - 1}。"


def test_a_file_that_cannot_be_written_is_reported(live: Bench, tmp_path: Path) -> None:
    live.say()
    save(live, "live_save_csv", tmp_path / "missing" / "values.csv")
    note = live.page.save.note
    assert note.meaning is Meaning.ATTENTION
    assert "No such file" in note.text
    assert live.page.save.csv.isEnabled()


def test_the_picture_has_a_caption(live: Bench, tmp_path: Path) -> None:
    live.say()
    path = tmp_path / "live.png"
    suggested = save(live, "live_save_png", path)
    assert suggested[0].suffix == ".png"
    seen = live.find(QWidget, "live_seen")
    picture = QImage(str(path))
    ratio = seen.devicePixelRatio()
    assert picture.width() == round(seen.width() * ratio)
    assert picture.height() == round((seen.height() + 28) * ratio)
    foot = picture.copy(0, round(seen.height() * ratio), picture.width(), round(28 * ratio))
    assert len({foot.pixel(x, y) for x in range(foot.width()) for y in range(foot.height())}) > 2  # it has text


def test_the_picture_has_its_key(live: Bench, tmp_path: Path) -> None:
    live.say()
    path = tmp_path / "key.png"
    live.page.save.note.ask_path = choosing(path)
    both = Qt.KeyboardModifier.ControlModifier | Qt.KeyboardModifier.ShiftModifier
    live.qtbot.keyClick(live.page, Qt.Key.Key_S, both)
    live.qtbot.waitUntil(lambda: not live.page.save.note.is_saving)
    assert path.read_bytes().startswith(b"\x89PNG")


def test_a_default_name_has_no_letters_that_a_system_refuses(live: Bench) -> None:
    name = default_name("sim://demo?lifelike&noise=1", ".csv", datetime(2026, 3, 1, 9, 30, 5, tzinfo=UTC))
    assert name == "dps-s sim-demo 2026-03-01 09-30-05.csv"


def test_a_long_saving_can_be_cancelled(live: Bench, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    live.say()
    monkeypatch.setattr("ui.files.save_bar.csv_parts", lambda *_, **__: repeat(b"row"))
    path = tmp_path / "values.csv"
    live.page.save.note.ask_path = choosing(path)
    live.click("live_save_csv")
    assert live.page.save.note.is_saving
    assert not live.page.save.png.isEnabled()
    assert live.page.save.note.text.startswith("Saving…")
    live.click("live_save_cancel")
    live.qtbot.waitUntil(lambda: not live.page.save.note.is_saving)
    assert live.page.save.note.text == "Cancelled."
    assert list(tmp_path.iterdir()) == []
    assert live.page.save.csv.isEnabled()
    assert not live.page.save.stop.isVisible()


def test_the_buttons_take_two_lines_only_where_one_has_no_room(qtbot: QtBot) -> None:
    bar = SaveBar(Texts(), take_excerpt=Mock(), take_picture=Mock(), take_drawing=Mock(), find_origin=Mock())
    qtbot.addWidget(bar)
    bar.show()
    needed = bar.csv.sizeHint().width() + bar.png.sizeHint().width() + 2 * Space.S
    for width, is_one_line in ((needed, True), (needed + 200, True), (needed - 30, False)):
        bar.resize(width, 100)
        let_lay_out(bar)
        assert (bar.csv.y() == bar.png.y()) is is_one_line
        assert all(bar.rect().contains(one.geometry()) for one in (bar.csv, bar.png))
