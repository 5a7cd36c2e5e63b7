"""The menu: all actions with their shortcuts, and those of the current page."""

from pathlib import Path

from PySide6.QtCore import QPoint, Qt
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QApplication, QMenu, QPushButton
from pytestqt.qtbot import QtBot

from tests.support.window.fakes_ui import WAIT_MS, window
from ui.core.texts import Texts
from ui.services.context import PageEntry, Services
from ui.services.page import Page
from ui.style.icons import Icon
from ui.widgets.controls import Shortcut, control
from ui.widgets.layouts import in_column


class Saver(Page):
    """A page with a button that saves, and none that exports."""

    def __init__(self, services: Services) -> None:
        super().__init__("saver")
        self.saved = 0
        self.save = control(QPushButton(), Texts(), "saver_save", "Save values…", key="Ctrl+S", slot=self._save)
        self.saving = Shortcut("saver_save_key", self, self.save)
        in_column(self.save, of=self)

    def _save(self) -> None:
        self.saved += 1


SAVER = (PageEntry("saver", "Live", Icon.LIVE, Saver),)


def entries(menu: QMenu) -> dict[str, QAction]:
    menu.aboutToShow.emit()
    return {one.objectName(): one for one in menu.actions()}


def test_the_menu_offers_what_the_page_in_sight_can_do(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with window(qapp, tmp_path, entries=SAVER) as assembly:
        main, menus = assembly.window, assembly.window.menus
        qtbot.waitUntil(lambda: main.stack.count() == 1, timeout=WAIT_MS)
        main.go_to("saver")
        page = main.stack.currentWidget()
        assert isinstance(page, Saver)
        qtbot.waitUntil(page.isVisible, timeout=WAIT_MS)
        offered = entries(menus.page)["saver_save_key"]
        assert (offered.text(), offered.shortcut().toString()) == ("Save values…", "Ctrl+S")
        offered.trigger()
        file = next(one for one in main.findChildren(QMenu) if one.objectName() == "menu_file")
        assert (entries(file)["act_save"].isEnabled(), menus["export"].isEnabled()) == (True, False)
        menus["save"].trigger()
        menus["export"].trigger()
        assert page.saved == 2
        page.save.setEnabled(False)
        assert not entries(menus.page)["saver_save_key"].isEnabled()
        menus["save"].trigger()
        assert page.saved == 2


def test_f10_opens_the_menu_and_lock_is_in_it(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with window(qapp, tmp_path, entries=SAVER) as assembly:
        main = assembly.window
        in_menu = {one.objectName() for menu in main.findChildren(QMenu) for one in menu.actions()}
        own = {one.objectName() for one in main.actions()}
        assert own <= in_menu  # no key without an entry
        bar = main.top_bar
        assert bar.menu.menu() is main.menus.main
        assert bar.menu.mapTo(main, QPoint()).x() < bar.port.mapTo(main, QPoint()).x()
        heights = {one.height() for one in (bar.menu, bar.port, bar.activation, bar.trigger, bar.cell, bar.lock)}
        assert (bar.height(), len(heights)) == (48, 1)
        main.activateWindow()
        qtbot.waitUntil(main.isActiveWindow, timeout=WAIT_MS)
        qtbot.keyClick(main, Qt.Key.Key_F10)
        qtbot.waitUntil(main.menus.main.isVisible, timeout=WAIT_MS)
        main.menus.main.close()
