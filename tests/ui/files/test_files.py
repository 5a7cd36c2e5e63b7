"""Files from the command line, the menu or a drop are opened by the page of their type; printing."""

import os
import sys
from pathlib import Path
from threading import Thread

import pytest
from PySide6.QtCore import QMessageLogContext, QtMsgType, qInstallMessageHandler
from PySide6.QtWidgets import QApplication, QMenu, QWidget
from pytestqt.qtbot import QtBot

import app.__main__ as program
from app.cli.commands import is_file_name
from tests.support.window.capture_window import write_capture
from tests.ui.pages.diagnosis.test_diagnosis_page import diagnosis
from ui.core.preferences import Preferences
from ui.files.file_dialogs import FileOpener, FilePage, ThenPath, add_recent
from ui.files.report_printer import print_report
from ui.main import WindowOptions
from ui.pages.diagnosis.capture_files import SUFFIX


def recent_menu(window: QWidget) -> QMenu:
    menu = window.findChild(QMenu, "menu_recent")
    assert isinstance(menu, QMenu)
    return menu


def test_open_and_recent_files(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    path = write_capture(tmp_path / f"chosen{SUFFIX}", seconds=1)
    with diagnosis(qtbot, qapp, tmp_path) as (assembly, page):
        window = assembly.window
        asked: list[str] = []

        def choose(_parent: QWidget, _folder: Path, _title: str, kinds: str, then: ThenPath) -> None:
            asked.append(kinds)
            then(path)

        window.files.choose = choose
        window.menus["open"].trigger()
        qtbot.waitUntil(lambda: page.opened is not None)
        assert f"*{SUFFIX}" in asked[0]
        recent_menu(window).aboutToShow.emit()
        (recent,) = recent_menu(window).actions()
        assert recent.text() == path.name
        first = page.opened
        recent.trigger()
        qtbot.waitUntil(lambda: page.opened is not None and page.opened is not first)


def test_the_window_begins_with_the_file(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    path = write_capture(tmp_path / f"begun{SUFFIX}", seconds=1)
    options = WindowOptions(language="en", file=path)
    with diagnosis(qtbot, qapp, tmp_path, options=options) as (assembly, page):
        qtbot.waitUntil(lambda: page.opened is not None)
        assert not assembly.window.panel.isVisible()


def test_a_file_of_unknown_type_is_reported(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with diagnosis(qtbot, qapp, tmp_path) as (assembly, page):
        said: list[str] = []
        assembly.window.files.say = said.append
        assert not assembly.window.files.open(tmp_path / "a.xyz")
        assert said == ["No page opens a.xyz."]
        assert page.opened is None
        recent_menu(assembly.window).aboutToShow.emit()
        (none,) = recent_menu(assembly.window).actions()
        assert not none.isEnabled()


@pytest.mark.skipif(sys.platform == "win32", reason="makes a named pipe")
@pytest.mark.parametrize("suffix", [".toml", ".dpscap", ".csv", ".json"])
def test_a_pipe_is_refused_and_not_waited_for(qtbot: QtBot, tmp_path: Path, suffix: str) -> None:
    path, opened, said = tmp_path / f"pipe{suffix}", list[Path](), list[str]()
    os.mkfifo(path)  # type: ignore[attr-defined,unused-ignore]
    window, page = QWidget(), FilePage("any", (suffix,), opened.append)
    qtbot.addWidget(window)
    preferences = Preferences(tmp_path / "settings.ini")
    opener = FileOpener(window, lambda: [page], said.append, preferences=preferences, say=said.append)
    assert not opener.open(path)
    assert (opened, said) == ([], [f"pipe{suffix} cannot be read: unknown kind of file."])


@pytest.mark.parametrize(
    ("words", "name"),
    [(["a.toml"], "a.toml"), (["gui", "b.dpscap"], "b.dpscap"), (["a.toml", "--demo"], "a.toml")],
)
def test_dps_s_file_opens_the_window_on_it(
    words: list[str], name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen: list[WindowOptions] = []

    def run(options: WindowOptions) -> int:
        seen.append(options)
        return 0

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("ui.main.run", run)
    Path(name).touch()
    assert program.main(words) == 0
    assert [one.file for one in seen] == [Path(name)]


def test_a_missing_file_opens_no_window(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert program.main(["nowhere.toml"]) == 2
    assert "nowhere.toml cannot be read: No such file or directory." in capsys.readouterr().err
    assert program.main(["bogus"]) == 2
    assert "There is no command bogus." in capsys.readouterr().err


def test_commands_take_precedence_over_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("read").touch()
    Path("flight").touch()
    assert not is_file_name("read")
    assert is_file_name("flight")
    assert is_file_name("later.toml")
    assert not is_file_name("raed")


def test_a_recent_file_shows_letters_that_would_be_invisible(qtbot: QtBot, tmp_path: Path) -> None:
    menu, opened = QMenu(), list[Path]()
    qtbot.addWidget(menu)
    path = tmp_path / "M&7\u202elmot.toml"
    add_recent(menu, "recent", [str(path)], opened.append)
    (action,) = menu.actions()
    assert action.text().startswith("M&&7")
    assert "\u202e" not in action.text() + action.toolTip()
    action.trigger()
    assert opened == [path]


_PAGE = (
    "<table width='100%' border='1'>"
    + "<tr><td>CHUTE_A</td><td>NO-GO: the cell voltage is low</td></tr>" * 70
    + "</table>"
)


def test_a_report_printed_in_a_background_thread_causes_no_warning_of_qt(qapp: object) -> None:
    said: list[str] = []
    printed: list[bytes] = []

    def hear(_kind: QtMsgType, _context: QMessageLogContext, text: str) -> None:
        said.append(text)

    before = qInstallMessageHandler(hear)
    try:
        thread = Thread(target=lambda: printed.append(print_report(_PAGE, b"{}")))
        thread.start()
        thread.join()
    finally:
        qInstallMessageHandler(before)
    assert [one[:5] for one in printed] == [b"%PDF-"]
    assert said == []
