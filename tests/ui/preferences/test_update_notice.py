"""The notice of a newer version: opt-in, quiet, never by itself."""

from collections.abc import Callable
from pathlib import Path

import pytest
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from app.system.newer_version import find_newer
from tests.support.window.fakes_ui import window
from tests.support.window.steps import find
from ui.main import WindowOptions
from ui.preferences import update_notice
from ui.preferences.dialog import PreferencesDialog
from ui.preferences.update_notice import UpdateNotice
from ui.widgets.notice_bar import Notice


def test_only_who_gave_an_address_asks_and_is_told(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[str] = []
    told: list[Callable[[], Notice]] = []

    def noted(address: str, own: str) -> str | None:
        asked.append(address)
        return find_newer(address, own)

    monkeypatch.setattr(update_notice, "find_newer", noted)
    newer, same = tmp_path / "newer.txt", tmp_path / "same.txt"
    newer.write_text("999.1\n", encoding="utf-8")
    same.write_text("0.0.1\n", encoding="utf-8")
    with window(qapp, tmp_path / "data", options=WindowOptions(language="en")) as assembly:
        main = assembly.window
        notice = UpdateNotice(main.choices, main, tell=told.append, dismiss=lambda: None)
        notice.check()
        main.choices.use_theme("dark")
        assert asked == []  # nobody, ever, without an address
        main.menus["preferences"].trigger()
        dialog = find(main, PreferencesDialog)

        def give(address: str) -> None:
            dialog.updates.setText(address)
            dialog.updates.textEdited.emit(address)
            dialog.updates.editingFinished.emit()
            qtbot.waitUntil(lambda: not notice._asking.is_running)

        for address in (same.as_uri(), (tmp_path / "missing").as_uri(), "http://example.org/v"):
            give(address)
        assert told == []
        assert dialog.unusable.isVisible()
        give(newer.as_uri())
        assert not dialog.unusable.isVisible()
        (make,) = told
        assert make().text.startswith("A newer version is there: 999.1. This is ")
        give("")
        assert len(asked) == 4
        notice.check()
        assert len(asked) == 4
