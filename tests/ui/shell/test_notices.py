"""Notices: texts, main buttons, and that no button takes the place of another."""

from pathlib import Path

import pytest
from PySide6.QtWidgets import QApplication, QToolButton
from pytestqt.qtbot import QtBot

from app.diagnosis.link_state import LinkState, NextStep, Phase
from app.engine.target import Target
from app.engine.transport import PortError, PortTrouble
from app.procedures.handshake import Silence
from tests.support.window.fakes_ui import WAIT_MS, simulated, wait_online, window
from tests.support.window.moved import covered, moved, places
from ui.core.texts import Texts
from ui.main import PAGES
from ui.shell.notices import link_notice
from ui.style.theme import Meaning
from ui.widgets.notice_bar import Choice, Notice, NoticeBar

ACTS = {step: lambda: None for step in NextStep}


@pytest.mark.parametrize(
    ("state", "main"),
    [
        (LinkState(Phase.SILENT, "ttyUSB0", 115200, silence=Silence.GARBAGE), NextStep.FIND_RATE),
        (LinkState(Phase.SILENT, "ttyUSB0", 115200, silence=Silence.NOTHING), NextStep.FIND_RATE),
        (
            LinkState(Phase.FAILED, "ttyUSB0", 115200, trouble=PortError(PortTrouble.BUSY, "ttyUSB0", "")),
            NextStep.CONNECT_AGAIN,
        ),
    ],
)
def test_the_main_button_of_a_link_notice_is_the_one_that_helps(state: LinkState, main: NextStep) -> None:
    notice = link_notice(state, 0.0, ACTS, was_active=False)
    assert notice is not None
    assert [one.key for one in notice.choices if one.is_main] == [main.value]


def test_the_close_button_never_takes_the_place_of_another(qtbot: QtBot) -> None:
    bar = NoticeBar(Texts())
    qtbot.addWidget(bar)
    bar.setFixedWidth(800)
    buttons = tuple(Choice(key, key, lambda: None) for key in ("one", "two"))
    shown = []
    for choices, dismiss in ((buttons, None), ((), bar.hide), (buttons[:1], bar.hide), (buttons[:1], None)):
        bar.show_notice(Notice(Meaning.ATTENTION, "Something", choices, dismiss))
        QApplication.processEvents()
        shown.append(places(bar))
    assert "notice_dismiss" in shown[1]
    for before in shown:
        for after in shown:
            assert [one for one in covered(before, after) if one.startswith("notice_dismiss")] == []
    assert moved(shown[2], shown[3]) == []


def test_an_equal_notice_that_can_be_closed_gets_its_close_button(qtbot: QtBot) -> None:
    bar = NoticeBar(Texts())
    qtbot.addWidget(bar)
    close = bar.findChild(QToolButton, "notice_dismiss")
    assert close is not None
    for dismiss in (None, bar.hide, None):
        bar.show_notice(Notice(Meaning.ATTENTION, "Something", dismiss=dismiss))
        assert close.isVisibleTo(bar) == (dismiss is not None)


def test_notices_after_a_trigger_and_a_restart(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    pages = tuple(entry for entry in PAGES if entry.key in ("triggers", "preflight"))
    with simulated("next") as bench, window(qapp, tmp_path, entries=pages) as assembly:
        main = assembly.window
        bench.module.activate(is_active=True)
        assembly.connector.connect_to(Target("sim://next", 115200))
        wait_online(qtbot, assembly)
        bench.pulse_pwm()
        qtbot.waitUntil(lambda: main.notice_bar.button("after_trigger") is not None, timeout=WAIT_MS)
        notice = main.notice_bar.notice
        assert notice is not None
        assert notice.meaning is Meaning.DANGER
        main.go_to("preflight")
        notice.choices[0].act()
        assert main.navigation.chosen == "triggers"
        assert notice.dismiss is not None
        notice.dismiss()
        assert main.notice_bar.notice is None  # it was read; the top bar still says TRIGGERED
        qtbot.waitUntil(lambda: assembly.connector.device.fresh("boot_count", assembly.connector.clock()) is not None,
                        timeout=WAIT_MS)  # fmt: skip
        main.refresh()
        bench.restart()
        qtbot.waitUntil(lambda: main.notice_bar.button("after_restart") is not None, timeout=WAIT_MS)
        notice = main.notice_bar.notice
        assert notice is not None
        notice.choices[0].act()
        assert main.navigation.chosen == "preflight"
