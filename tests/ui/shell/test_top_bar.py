"""The top bar: unknown states, the name of the module, and a stable layout."""

from pathlib import Path

from PySide6.QtCore import QEvent, QPoint
from PySide6.QtGui import QColor
from PySide6.QtWidgets import QApplication, QWidget
from pytestqt.qtbot import QtBot

from app.limits.out_of_limits import LimitsInUse
from tests.support.window.cut_off import cut_off
from tests.support.window.fakes_ui import WAIT_MS, connect, simulated, window
from tests.support.window.moved import moved, places
from tests.support.window.painted_text import watching
from ui.core.texts import Texts
from ui.services.lock import LockControl
from ui.services.module_name import ModuleName
from ui.shell.top_bar import TopBar
from ui.style.theme import Choice, current
from ui.widgets.readout import StateChip, parts_of


def test_unknown_states_are_named(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with window(qapp, tmp_path) as assembly:
        with watching() as drawn:
            assembly.window.top_bar.grab()
        said = [one.text for one in drawn if isinstance(one.widget, StateChip)]
        assert said == ["Activation", "unknown", "Trigger", "unknown", "Cell", "unknown"]


def test_the_top_bar_shows_the_name_of_the_connected_module(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with simulated("named"), window(qapp, tmp_path) as assembly:
        naming = ModuleName()
        naming.choose("M-07")
        lock = LockControl(assembly.connector, assembly.storage.journal)
        top = TopBar(assembly.connector, Texts(), lock, naming, LimitsInUse())
        qtbot.addWidget(top)
        assert (top.port.title, top.name.text()) == ("Not connected", "")
        connect(qtbot, assembly, "sim://named")
        top.refresh()
        assert (top.port.title, top.name.text()) == ("Simulated module", "M-07")
        naming.choose("")
        top.refresh()
        assert top.name.text() == ""


def test_the_bars_have_a_line_over_the_whole_width(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with window(qapp, tmp_path) as assembly:
        main = assembly.window
        main.panel.hide()
        QApplication.processEvents()
        picture, line = main.grab().toImage(), QColor(current().divider)
        ends = (
            main.top_bar.mapTo(main, QPoint(0, main.top_bar.height() - 1)).y(),
            main.status_bar.mapTo(main, QPoint()).y(),
        )
        for y in ends:
            assert {picture.pixelColor(x, y).name() for x in range(picture.width())} == {line.name()}


def test_nothing_is_cut_off_or_moves_when_the_language_or_the_theme_is_switched(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path
) -> None:
    with simulated("switched") as bench, window(qapp, tmp_path) as assembly:
        main = assembly.window
        main.resize(1024, 600)
        connect(qtbot, assembly, "sim://switched")
        qtbot.waitUntil(lambda: main.top_bar.cell.word.endswith(" V"), timeout=WAIT_MS)
        cell = main.top_bar.cell
        switched = (("zh_CN", Choice.SUNLIGHT), ("en", Choice.SUNLIGHT), ("zh_CN", Choice.LIGHT), ("en", Choice.LIGHT))
        for number, (language, theme) in enumerate(switched):
            main.choices.use_language(language)
            assembly.appearance.choose(theme)
            laid_out(main)
            before, is_charged = places(main.top_bar), number % 2 == 0
            bench.set_charger(is_plugged_in=is_charged)
            qtbot.waitUntil(lambda wanted=is_charged: bool(parts_of(cell.word)[1]) is wanted, timeout=WAIT_MS)  # type: ignore[misc]
            laid_out(main)
            assert moved(before, places(main.top_bar)) == []
            for bar in (main.top_bar, main.status_bar, main.navigation):
                assert cut_off(bar) == [], (language, theme)


def test_the_port_is_named_whole_in_sunlight_on_a_narrow_window(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path
) -> None:
    with simulated("narrow"), window(qapp, tmp_path) as assembly:
        main = assembly.window
        assembly.appearance.choose(Choice.SUNLIGHT)
        main.resize(960, 540)
        connect(qtbot, assembly, "sim://narrow")
        main.refresh()
        laid_out(main)
        with watching() as drawn:
            main.top_bar.port.grab()
        assert [one.text for one in drawn] == ["Simulator", "Connected"]
        assembly.appearance.choose(Choice.LIGHT)


def laid_out(widget: QWidget) -> None:
    """What would be laid out in the next turns of the event loop is laid out now."""
    for _ in range(4):
        QApplication.processEvents()
        QApplication.sendPostedEvents(None, QEvent.Type.LayoutRequest.value)
    widget.grab()
