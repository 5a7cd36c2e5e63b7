"""Damage of a recording is reported where it is exported and shown, and in the command line."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

import app.__main__ as program
from app.recordings.library import recordings_folder
from app.recordings.recording import Recording
from app.text.i18n import ENGLISH, set_language
from tests.support.cli_line import Printed
from tests.support.records.recordings_desk import Desk, made, record
from tests.support.window.fakes_ui import speak_chinese
from ui.pages.live.page import LivePage
from ui.pages.recordings.page import RecordingsPage
from ui.services.recording_jobs import ExportKind
from ui.style.theme import Meaning

pytest_plugins = ["tests.support.cli_fixtures"]


def damage(path: Path) -> None:
    """Changes one bit in the middle."""
    data = bytearray(path.read_bytes())
    data[len(data) // 2] ^= 0x10
    path.write_bytes(data)


def test_the_command_line_reports_damage(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    damage(record(recordings_folder()))
    for name in ("x.csv", "x.mcap"):
        assert program.main(["recordings", "export", "latest", str(tmp_path / name)]) == 4
        printed = Printed(capsys)
        assert "Rows written to" in printed.out
        assert "Damaged or altered" in printed.err
    assert "damaged data left out" in (tmp_path / "x.csv").read_text("utf-8-sig")


@pytest.fixture
def desk(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> Iterator[Desk]:
    """The list and the Live page, with a recording of which a bit was changed."""
    template = record(tmp_path / "template")
    damage(template)
    with made(qtbot, qapp, tmp_path / "data", template, RecordingsPage, LivePage) as one:
        yield one


def test_the_window_reports_damage_at_export_and_on_the_live_page(desk: Desk, tmp_path: Path) -> None:
    desk.page.work.export(desk.page.work.entries[0], tmp_path / "x.csv", ExportKind.CSV)
    desk.until(lambda: "Saved" in desk.said())
    assert "Damaged or altered" in desk.said()
    assert desk.page.strip.notice is not None
    assert desk.page.strip.notice.meaning is Meaning.ATTENTION
    speak_chinese()
    assert "已损坏或被修改" in desk.said()
    set_language(ENGLISH)
    desk.open()
    shown = desk.live.recording
    assert isinstance(shown, Recording)
    assert shown.damage is not None
    desk.until(lambda: "Damaged or altered" in desk.live._recorded.banner.label.text())
