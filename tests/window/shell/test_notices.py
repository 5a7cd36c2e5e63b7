"""Notices: texts, main buttons, and that no button takes the place of another."""

from pathlib import Path

import pytest
from PySide6.QtCore import QPoint, QRect, QSize
from PySide6.QtWidgets import QApplication, QLabel, QWidget
from pytestqt.qtbot import QtBot

from tests.support.thorough import some
from tests.support.window import screen_reader
from tests.support.window.controls import covered, moved, places, visible_in
from tests.support.window.cut_off import cut_off
from tests.support.window.fake_ports import fake_window
from tests.support.window.fakes_ui import connect, page_entries, simulated, window
from tests.support.window.steps import given, let_lay_out, notice_text
from ui.main import PAGES, WindowOptions
from ui.shell.main_window import MainWindow
from ui.style.theme import Choice as Theme
from ui.style.theme import Meaning
from ui.widgets.notice_bar import Choice, Notice, NoticeBar


def test_a_name_on_a_button_is_whole(qtbot: QtBot) -> None:
    """Qt takes "&" for the mark of a key: R&D-1 would read as RD-1, which may be another module."""
    bar = NoticeBar()
    qtbot.addWidget(bar)
    bar.show_notice(Notice(Meaning.ATTENTION, "", (Choice("same_module", "It is R&D-1", bar.hide),)))
    button = given(bar.button("same_module"))
    assert (button.text(), screen_reader.name_of(button)) == ("It is R&&D-1", "It is R&D-1")
    assert button.shortcut().isEmpty()


def test_the_close_button_never_takes_the_place_of_another(qtbot: QtBot) -> None:
    bar = NoticeBar()
    qtbot.addWidget(bar)
    bar.setFixedWidth(800)
    buttons = tuple(Choice(key, key, lambda: None) for key in ("one", "two"))
    shown = []
    for choices, dismiss in ((buttons, None), ((), bar.hide), (buttons[:1], bar.hide), (buttons[:1], None)):
        bar.show_notice(Notice(Meaning.ATTENTION, "Something", choices, dismiss))
        let_lay_out(bar)
        shown.append(places(bar))
    assert "notice_dismiss" in shown[1]
    for before in shown:
        for after in shown:
            assert [one for one in covered(before, after) if one.startswith("notice_dismiss")] == []
    assert moved(shown[2], shown[3]) == []


def test_notices_after_a_trigger_and_a_restart(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with (
        simulated("next", active=True) as bench,
        window(qapp, tmp_path, entries=page_entries("triggers", "preflight")) as assembly,
    ):
        main = assembly.window
        connect(qtbot, assembly, "sim://next")
        main.go_to("preflight")
        bench.pulse_pwm()
        qtbot.waitUntil(lambda: main.notice_bar.button("after_trigger") is not None)
        notice = given(main.notice_bar.notice)
        assert notice.meaning is Meaning.DANGER
        notice.choices[0].act()
        assert main.navigation.chosen == "triggers"
        assert main.notice_bar.button("after_trigger") is None  # it leads to the page that is shown
        given(notice.dismiss)()
        assert main.notice_bar.notice is None  # it was read; the top bar still says TRIGGERED
        port = assembly.ports.current
        qtbot.waitUntil(lambda: port.module.is_read)
        main.go_to("preflight")
        bench.restart()
        qtbot.waitUntil(lambda: "reported TRIGGERED before" in notice_text(main.notice_bar))
        notice = given(main.notice_bar.notice)
        assert notice.meaning is Meaning.DANGER
        given(notice.dismiss)()
        qtbot.waitUntil(lambda: given(main.notice_bar.notice).cause == "interruptions")  # once it answers again
        assert "The module restarted." in notice_text(main.notice_bar)
        given(given(main.notice_bar.notice).dismiss)()
        assert main.notice_bar.notice is None


NOTICES = (
    Notice(Meaning.ATTENTION, "Short."),
    Notice(Meaning.DANGER, "Long enough for a second line. " * 5, (Choice("one", "One", lambda: None),), lambda: None),
    Notice(
        Meaning.ATTENTION,
        "With the most buttons that a notice has.",
        tuple(Choice(key, "Leave it ACTIVE", lambda: None, is_main=key == "a") for key in "abc"),
    ),
)


LOOKS = (
    ("en", Theme.SUNLIGHT, QSize(960, 540)),
    ("zh_CN", Theme.SUNLIGHT, QSize(1024, 600)),
    ("zh_CN", Theme.DARK, QSize(960, 540)),
    ("en", Theme.LIGHT, QSize(1366, 768)),
)


@pytest.mark.promise("d")
def test_nothing_moves_on_any_page_when_a_notice_comes_and_goes(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    shown: list[Notice | None] = [None]
    for language, theme, size in some(LOOKS, one_in=2):
        with window(qapp, tmp_path, options=WindowOptions(language=language), entries=PAGES) as assembly:
            main = assembly.window
            qtbot.waitSignal(main.pages_made).wait()
            monkeypatch.setattr(main.attention, "_notices", lambda: [] if shown[0] is None else [shown[0]])
            assembly.appearance.choose(theme)
            main.resize(size)
            for entry in PAGES:
                main.go_to(entry.key)
                before = laid_out(main, entry.key)
                for shown[0] in (*NOTICES, None):
                    after = laid_out(main, entry.key)
                    assert after == before, (language, theme, entry.key, shown[0])
                    assert cut_off(main.status_bar) == []
            assembly.appearance.choose(Theme.LIGHT)


def laid_out(main: MainWindow, page: str) -> dict[QWidget, QRect]:
    """The exact places of everything but the status bar."""
    let_lay_out(main)
    assert main.navigation.chosen == page
    return {
        one: QRect(one.mapTo(main, QPoint()), one.size())
        for one in visible_in(main)
        if not one.isWindow() and not main.status_bar.isAncestorOf(one)
    }


def test_several_notices_stand_at_once_and_the_graver_one_is_whole(qtbot: QtBot) -> None:
    calm = Notice(Meaning.INFORMATION, "Advice.", (Choice("advice", "Do it", lambda: None),))
    grave = Notice(Meaning.DANGER, "Silent for 1 s", cause="link")
    bar = NoticeBar(is_foot=True)
    qtbot.addWidget(bar)
    bar.show_notices([calm])
    assert not bar.more.isVisibleTo(bar)
    bar.show_notices([grave, calm])
    assert notice_text(bar) == "Silent for 1 s"
    assert bar.more.isVisibleTo(bar)
    bar.more.click()
    assert bar.button("advice") is not None
    later = grave._replace(text="Silent for 2 s")
    bar.show_notices([later, calm])
    assert notice_text(bar) == "Advice.", "a text that ticks is no new notice"
    bar.show_notices([Notice(Meaning.DANGER, "It fired."), later, calm])
    assert notice_text(bar) == "It fired."
    bar.show_note("The module reports LOCKED.")
    bar.show_notices([grave])
    shown = given(bar.findChild(QLabel, "notice_text")).text()
    assert shown == "Silent for 1 s · The module reports LOCKED.", "it is none of what the notice says"


def test_a_notice_that_was_closed_comes_again_with_its_cause(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with fake_window(qapp, tmp_path) as (ports, assembly):
        bar = assembly.window.notice_bar
        _port, worker = ports.plug_in("ttyUSB0")
        for is_triggered in (True, False, True):
            worker.say(triggered=is_triggered)
            QApplication.processEvents()
            qtbot.waitUntil(lambda wanted=is_triggered: ("has triggered" in notice_text(bar)) is wanted)  # type: ignore[misc]
            if is_triggered:
                given(given(bar.notice).dismiss)()
                assert "has triggered" not in notice_text(bar)


@pytest.mark.promise("l")
def test_closing_asks_while_a_lock_is_not_reported(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with fake_window(qapp, tmp_path) as (ports, assembly):
        port, _worker = ports.plug_in("ttyUSB0")
        qtbot.waitUntil(lambda: port.is_open)
        port.lock.press()
        assembly.window.close()
        assert assembly.window.isVisible()
        assert "it does not report LOCKED" in notice_text(assembly.window.notice_bar)
