"""The window by keyboard: tab order, shortcuts, and the menu that has them all."""

from pathlib import Path

import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtGui import QAction, QKeySequence
from PySide6.QtWidgets import QAbstractButton, QApplication, QLineEdit, QMenu, QPushButton, QWidget
from pytestqt.qtbot import QtBot

from app.text.i18n import tr
from tests.support.window.controls import tab_chain
from tests.support.window.fakes_ui import window
from tests.support.window.settings_bench import desk, type_into
from tests.support.window.steps import given, let_lay_out
from tests.support.window.walk import PROFILE, walking
from ui.main import PAGES
from ui.services.context import PageEntry, Services
from ui.services.page import Page
from ui.style.icons import Icon
from ui.widgets.controls import Shortcut, control, in_column

MAX_STOPS = 200
OF_MENU_AND_FOCUS = {"Ctrl+K", "Del", "End", "Enter", "Esc", "Space"}


def test_tab_reaches_everything_and_is_never_trapped(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with walking(qtbot, qapp, tmp_path) as walk:
        window = walk.window
        window.panel.hide()
        walk.connect()
        window.activateWindow()
        qtbot.waitUntil(window.isActiveWindow)
        for number, entry in enumerate(PAGES):
            if number < 9:  # there are no more digits
                qtbot.keyClick(window, Qt.Key(Qt.Key.Key_1 + number), Qt.KeyboardModifier.ControlModifier)
            else:
                window.navigation.setFocus()
                qtbot.keyClick(window.navigation, Qt.Key.Key_End)
                qtbot.keyClick(window.navigation, Qt.Key.Key_Tab)
            walk.settle()
            page, focused = window.stack.currentWidget(), QApplication.focusWidget()
            assert page is not None
            assert page.isAncestorOf(given(focused)), entry.key
            window.navigation.setFocus()
            for key in (Qt.Key.Key_Tab, Qt.Key.Key_Backtab):
                reached = pressed_through(qtbot, window, key)
                missed = {one.objectName() for one in tab_chain(window)} - reached
                assert not missed, f"{entry.key}: {key.name} does not reach {sorted(missed)}"


def pressed_through(qtbot: QtBot, window: QWidget, key: Qt.Key) -> set[str]:
    """What has the focus as the key is pressed, until it comes round to where it began."""
    first = QApplication.focusWidget()
    reached: set[str] = set()
    for _ in range(MAX_STOPS):
        now = given(QApplication.focusWidget())
        reached.add(now.objectName())
        qtbot.keyClick(now, key)
        following = QApplication.focusWidget()
        assert following is not now, f"{now.objectName()} keeps {key.name}"
        if following is first:
            return reached
    pytest.fail(f"{key.name} does not come round")


def test_keys(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    """Pages by their number, menus by their letter. What a tooltip names is a key; no key means two things on one page,
    and none that is held acts again: it would answer the question that it raised, or do the next step of a guided
    test."""
    with walking(qtbot, qapp, tmp_path) as walk:
        window = walk.window
        window.activateWindow()
        qtbot.waitUntil(window.isActiveWindow)
        everywhere = keys_of(window)
        assert len(everywhere) > 8
        for number, entry in enumerate(PAGES[:9], start=1):  # there are no more digits
            qtbot.keyClick(window, getattr(Qt.Key, f"Key_{number}"), Qt.KeyboardModifier.ControlModifier)
            assert window.navigation.chosen == entry.key
            page = given(window.stack.currentWidget())
            assert not everywhere.keys() & keys_of(page).keys(), entry.key
            told = {QKeySequence(key).toString() for one in page.findChildren(QAbstractButton)
                    if (key := one.property("key")) is not None}  # fmt: skip
            bound = {_told(key) for action in page.findChildren(QAction) for key in action.shortcuts()}
            bound |= {_told(key) for shortcut in page.findChildren(Shortcut) for key in keys_pressing(shortcut)}
            assert told - OF_MENU_AND_FOCUS <= bound, entry.key
        repeated = {action.objectName() for action in window.findChildren(QAction)
                    if action.autoRepeat() and not action.shortcut().isEmpty()}  # fmt: skip
        repeated |= {shortcut.objectName() for shortcut in window.findChildren(Shortcut) if shortcut.autoRepeat()}
        assert {name for name in repeated if not name.endswith(("_fit", "_live"))} == set()  # of plots


def test_no_key_writes_edits_that_are_not_in_sight(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with desk(qtbot, qapp, tmp_path, "settings") as one:
        type_into(one, "attitude_threshold", "75")
        path = tmp_path / "H6.toml"
        path.write_text(PROFILE, encoding="utf-8")
        one.settings.open_file(path)
        for is_written in (False, True):
            qtbot.keyClick(one.settings, Qt.Key.Key_Return, Qt.KeyboardModifier.ControlModifier)
            assert one.settings.work.job.is_running is is_written
            one.settings.on_escape()
        one.until(lambda: one.held("attitude_threshold") == 75)


def test_esc_leads_back_to_where_one_came_from(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    """From the list of ports and from a question, which are no windows of their own."""
    with desk(qtbot, qapp, tmp_path, "settings") as one:
        type_into(one, "attitude_threshold", "75")
        main = one.assembly.window
        main.activateWindow()
        qtbot.waitUntil(main.isActiveWindow)
        field = one.find(QLineEdit, "freefall_time_wanted")
        for act in ("connect", "disconnect", "connect"):
            field.setFocus()
            main.menus[act].trigger()
            opened = given(QApplication.focusWidget())
            assert opened is not field
            qtbot.keyClick(opened, Qt.Key.Key_Escape)
            assert QApplication.focusWidget() is field, act
        field.clearFocus()
        main.panel.show()
        main.panel.hide()
        assert QApplication.focusWidget() is not None  # also where it came from nowhere


def keys_of(widget: QWidget) -> dict[str, str]:
    """The shortcuts of what belongs to this widget itself, each once."""
    bound = [(action.objectName(), key) for action in widget.actions() for key in action.shortcuts()]
    if isinstance(widget, Page):
        for shortcut in widget.findChildren(Shortcut):
            if shortcut.control.isVisible():
                bound += [(shortcut.objectName(), key) for key in keys_pressing(shortcut)]
    keys: dict[str, str] = {}
    for name, key in bound:
        told = _told(key)
        assert told not in keys, f"{told} is {keys.get(told)} and {name}"
        keys[told] = name
    return keys


def keys_pressing(shortcut: Shortcut) -> list[QKeySequence]:
    return list(shortcut.keys())


def _told(key: QKeySequence | QKeySequence.StandardKey) -> str:
    return QKeySequence(key).toString()


class Saver(Page):
    """A page with a button that saves, and none that exports."""

    def __init__(self, services: Services) -> None:
        super().__init__("saver")
        self.saved = 0
        self.save = control(QPushButton(tr("Save values…")), "saver_save", keys="Ctrl+S", slot=self._save)
        self.saving = self.save
        in_column(self.save, of=self)

    def _save(self) -> None:
        self.saved += 1


SAVER = (PageEntry("saver", "Live", Icon.LIVE, Saver),)


def entries(menu: QMenu) -> dict[str, QAction]:
    menu.aboutToShow.emit()
    return {action.objectName(): action for action in menu.actions()}


def test_the_menu_offers_what_the_page_in_sight_can_do(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with window(qapp, tmp_path, entries=SAVER) as assembly:
        main, menus = assembly.window, assembly.window.menus
        qtbot.waitUntil(lambda: main.stack.count() == 1)
        main.go_to("saver")
        page = main.stack.currentWidget()
        assert isinstance(page, Saver)
        qtbot.waitUntil(page.isVisible)
        main.activateWindow()
        qtbot.waitUntil(main.isActiveWindow)
        qtbot.keyClick(page, Qt.Key.Key_S, Qt.KeyboardModifier.ControlModifier)
        file = next(menu for menu in main.findChildren(QMenu) if menu.objectName() == "menu_file")
        assert (entries(file)["act_save"].isEnabled(), menus["export"].isEnabled()) == (True, False)
        menus["save"].trigger()
        menus["export"].trigger()
        assert page.saved == 2
        page.save.setEnabled(False)
        menus["save"].trigger()
        qtbot.keyClick(page, Qt.Key.Key_S, Qt.KeyboardModifier.ControlModifier)
        assert page.saved == 2


def test_f10_opens_the_menu_and_lock_is_in_it(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with window(qapp, tmp_path, entries=SAVER) as assembly:
        main = assembly.window
        in_menu = {action.objectName() for menu in main.findChildren(QMenu) for action in menu.actions()}
        own = {action.objectName() for action in main.actions()}
        assert own <= in_menu  # no key without an entry
        assert any(main.menus["lock"] in menu.actions() for menu in main.findChildren(QMenu))
        bar = main.top_bar
        assert bar.menu.menu() is main.main_menu
        let_lay_out(main)
        assert bar.menu.mapTo(main, QPoint()).x() < bar.port.mapTo(main, QPoint()).x()
        main.activateWindow()
        qtbot.waitUntil(main.isActiveWindow)
        qtbot.keyClick(main, Qt.Key.Key_F10)
        qtbot.waitUntil(main.main_menu.isVisible)
        main.main_menu.close()
