"""What the notice says next, which button is the main one, and that none comes to lie where another was."""

from functools import partial
from pathlib import Path
from typing import cast

import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtWidgets import QApplication, QPushButton, QWidget
from pytestqt.qtbot import QtBot

from app.diagnosis.link_state import LinkState, NextStep, Phase
from app.engine.target import Target
from app.engine.transport import PortError, PortTrouble
from app.procedures.greet import Silence
from tests.support.window.fakes_ui import WAIT_MS, simulated, wait_online, window
from tests.support.window.moved import covered, moved, places
from ui.core.texts import Texts
from ui.main import PAGES
from ui.shell.notices import link_notice
from ui.shell.page_area import PageArea
from ui.style.theme import Meaning
from ui.widgets.controls import IS_LOCK
from ui.widgets.layouts import in_column
from ui.widgets.notice_bar import Choice, Notice, NoticeBar
from ui.widgets.step_button import StepButton

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
def test_in_trouble_the_main_button_is_the_one_that_helps(state: LinkState, main: NextStep) -> None:
    notice = link_notice(state, 0.0, ACTS, was_active=False)
    assert notice is not None
    assert [one.key for one in notice.choices if one.is_main] == [main.value]


def test_the_cross_never_lies_where_a_button_was(qtbot: QtBot) -> None:
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


def test_after_a_trigger_and_a_restart_it_says_what_comes_next(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path
) -> None:
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


def test_a_click_meant_for_what_a_notice_has_moved_does_nothing(qtbot: QtBot) -> None:
    main, bar, area, page = QWidget(), NoticeBar(Texts()), PageArea(), QWidget()
    qtbot.addWidget(main)
    pressed: list[str] = []
    others = [QPushButton(name) for name in ("one", "two", "three", "four")]
    lock, step = QPushButton("LOCK"), StepButton(is_safe=True)
    lock.setProperty(IS_LOCK, True)
    for button in (*others, lock):
        button.clicked.connect(partial(pressed.append, button.text()))
    step.chosen.connect(partial(pressed.append, "step"))
    in_column(*others, 1, lock, step, of=page)
    area.stack.addWidget(page)
    in_column(bar, (area, 1), of=main)
    main.resize(600, 500)
    main.show()
    qtbot.waitExposed(main)
    qtbot.waitUntil(area.shield.isHidden)

    def click(button: QWidget) -> None:
        where = button.mapTo(main, button.rect().center())
        hit = cast("QWidget", main.childAt(where))
        qtbot.mouseClick(hit, Qt.MouseButton.LeftButton, pos=hit.mapFrom(main, where))

    click(others[1])
    was = others[1].mapTo(main, QPoint())
    bar.show_notice(Notice(Meaning.ATTENTION, "Something"))
    qtbot.waitUntil(lambda: others[1].mapTo(main, QPoint()) != was)
    for button in (*others, lock, step):
        click(button)
    assert pressed == ["two", "LOCK", "step"]
    qtbot.waitUntil(area.shield.isHidden)
    click(others[0])
    assert pressed[3:] == ["one"]
    bar.show_notice(None)
    qtbot.waitUntil(area.shield.isVisible)
    click(others[2])
    assert len(pressed) == 4
