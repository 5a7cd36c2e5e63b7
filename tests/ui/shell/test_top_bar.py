"""The top bar: it names what is unknown, and the module that is connected."""

from pathlib import Path

from PySide6.QtCore import QPoint
from PySide6.QtGui import QColor
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from app.engine.target import Target
from tests.support.window.fakes_ui import simulated, wait_online, window
from tests.support.window.painted_text import watching
from ui.core.texts import Texts
from ui.services.lock import LockControl
from ui.services.module_name import ModuleName
from ui.shell.top_bar import TopBar
from ui.style.theme import current
from ui.widgets.readout import StateChip


def test_what_is_unknown_is_named(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with window(qapp, tmp_path) as assembly:
        with watching() as drawn:
            assembly.window.top_bar.grab()
        said = [one.text for one in drawn if isinstance(one.widget, StateChip)]
        assert said == ["Activation", "unknown", "Trigger", "unknown", "Cell", "unknown"]


def test_the_name_of_the_module_that_is_connected_stands_at_the_top(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path
) -> None:
    with simulated("named"), window(qapp, tmp_path) as assembly:
        naming = ModuleName()
        naming.choose("M-07")
        top = TopBar(
            assembly.connector, Texts(), LockControl(assembly.connector, assembly.storage.journal), naming=naming
        )
        qtbot.addWidget(top)
        assert (top.port.title, top.name.text()) == ("Not connected", "")
        assembly.connector.connect_to(Target("sim://named", 115200))
        wait_online(qtbot, assembly)
        top.refresh()
        assert (top.port.title, top.name.text()) == ("Simulated module", "M-07")
        naming.choose("")
        top.refresh()
        assert top.name.text() == ""


def test_the_bars_are_parted_from_the_page_over_the_whole_width(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path
) -> None:
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
