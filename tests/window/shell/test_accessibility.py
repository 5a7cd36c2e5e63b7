"""The window by keyboard and for who does not see it: names, descriptions, tab order, shortcuts, the menu that has them
all; what is cut off in large text; and widgets that Python's collector would free although Qt still shows them.
"""

import gc
import re
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import shiboken6
from PySide6.QtCore import QObject, QSize, Qt
from PySide6.QtGui import QAccessible, QAccessibleInterface, QAction, QKeySequence
from PySide6.QtWidgets import (
    QAbstractButton,
    QApplication,
    QLabel,
    QLineEdit,
    QMenu,
    QPushButton,
    QScrollArea,
    QTableView,
    QWidget,
)
from pytestqt.qtbot import QtBot

from app.settings.form import RowState, SettingDraft
from app.text.i18n import CHINESE, read_messages
from tests.support.processes import ROOT
from tests.support.thorough import IS_THOROUGH
from tests.support.window.controls import controls_in, takes_tab
from tests.support.window.cut_off import cut_off, texts_of
from tests.support.window.desk import type_into
from tests.support.window.fakes_ui import window
from tests.support.window.rig import Rig
from tests.support.window.screen_reader import name_of
from tests.support.window.steps import given
from tests.support.window.walk import PROFILE, SMALL_SCREEN, Walk, walking
from ui.core.preferences import MAX_ZOOM_PERCENT, Preferences
from ui.main import PAGES
from ui.pages.settings.page import SettingsPage
from ui.services.page import Page
from ui.shell.main_window import SMALLEST
from ui.style.appearance import Spoken
from ui.style.theme import Choice
from ui.widgets.controls import Shortcut
from ui.widgets.step_button import is_in_sight


def living_garbage(root: QObject) -> list[str]:
    """Return the descendants of `root` (according to Qt) that are garbage according to Python.

    Freeing them removes them from the window. This happens when PySide has recorded a wrong parent for an object, as
    some calls (`nextInFocusChain`) make it do.
    """

    def is_in_root(one: QObject | None) -> bool:
        return one is root or (one is not None and is_in_root(one.parent()))

    debug = gc.get_debug()
    gc.set_debug(gc.DEBUG_SAVEALL)
    try:
        gc.collect()
        found = [one for one in gc.garbage if isinstance(one, QObject) and shiboken6.isValid(one)]
        return sorted(f"{type(one).__name__} {one.objectName()}" for one in found if is_in_root(one))
    finally:
        gc.set_debug(debug)
        gc.garbage.clear()


ENGLISH_WORD = re.compile("[A-Za-z]{3,}")
UNTRANSLATED = re.compile(r"sim:[\u200b/]+\w+|postgresql:\S+|[0-9A-Z]{4}-[0-9A-Z]{4}|（[A-Z][\w+]*）")
"""Addresses, codes and keys, which are the same in every language."""
FULL_HD_AT_200 = QSize(960, 540)
BY_OTHER_KEYS = ("_less", "_more")
"""Beside a number field, whose arrow keys do the same: a stop of Tab would only be in the way."""


@pytest.mark.parametrize("size", [SMALL_SCREEN, *([SMALLEST] if IS_THOROUGH else [])])
def test_the_walk(qtbot: QtBot, qapp: QApplication, tmp_path: Path, size: QSize) -> None:
    """All that is asked of what stands in the window: a few walks, because it is the walk that takes time."""
    faults: dict[str, str] = {}
    controls = 0
    with walking(qtbot, qapp, tmp_path, theme=Choice.SUNLIGHT, size=size) as walk:
        for stop in walk.stops():
            assert walk.window.size() == size, stop.name
            found = faults_in(stop.root)
            if found:  # a value that came meanwhile may not be laid out yet: what stays is a fault
                walk.settle()
                again = faults_in(stop.root)
                found = [fault for fault in found if fault in again]
            controls += len(controls_in(stop.root))
            if stop.name in {entry.key for entry in PAGES}:
                # Tilt and charge move something each time or never; a first look on a busy machine may be too early.
                found += walk.shake() and walk.shake()
            for fault in found:
                faults.setdefault(fault, stop.name)
        for name in living_garbage(walk.window):
            faults.setdefault(f"the collector would free {name}", "the end")
    assert controls > 500
    assert not faults, "\n".join(f"{name}: {fault}" for fault, name in faults.items())


def test_large_text(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    """At twice the size of text each page wraps, folds and scrolls: nothing is cut off, no list scrolls sideways, and
    the main button of the long pages stays in sight."""
    faults: dict[str, str] = {}
    folder = tmp_path / "200"  # a part of the port's name, which cannot wrap
    folder.mkdir()
    Preferences(folder / "window.ini").zoom_percent = MAX_ZOOM_PERCENT
    with walking(qtbot, qapp, folder, theme=Choice.SUNLIGHT) as walk:  # whose letters are bold
        for stop in walk.stops():
            assert walk.window.size() == SMALL_SCREEN, stop.name
            found = [*cut_off(stop.root), *sideways(stop.root)]
            if stop.name.startswith(("settings", "preflight", "connect")):  # where a person works down a long page
                found += main_out_of_sight(stop.root)
            if stop.name == "settings":
                found += cut_off_in_any_state(walk)
            for fault in found:
                faults.setdefault(fault, stop.name)
    faults = {fault: name for fault, name in faults.items() if not fault.startswith("bundle_text")}  # a file's lines
    assert not faults, "\n".join(f"{name}: {fault}" for fault, name in faults.items())


@pytest.mark.parametrize(("size", "percent"), [(FULL_HD_AT_200, 100), (SMALL_SCREEN, MAX_ZOOM_PERCENT)])
def test_in_chinese_nothing_is_cut_off_or_left_english_on_any_page(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path, size: QSize, percent: int
) -> None:
    Preferences(tmp_path / "window.ini").zoom_percent = percent
    found = []
    with walking(qtbot, qapp, tmp_path, language=CHINESE, theme=Choice.SUNLIGHT, size=size) as walk:
        for stop in walk.stops():
            found += untranslated(walk.window)
            if stop.name == PAGES[0].key:  # it is connected
                break
        for entry in PAGES:
            walk.window.go_to(entry.key)
            walk.settle()
            found += [*cut_off(walk.window), *sideways(walk.window), *untranslated(walk.window)]
    assert found == []


def untranslated(root: QWidget) -> list[str]:
    """All that a person sees or hears, in sight or not, in which an English word stands that no Chinese text has. Not
    an adapter's own words, and the parts of a readout, for which the whole speaks."""
    chinese = read_messages(ROOT / "app" / "locale" / f"{CHINESE}.ts").values()
    known = {word for text in chinese for word in ENGLISH_WORD.findall(text)}
    said = {(one.objectName(), text) for one in root.findChildren(QWidget) for text in texts_of(one)
            if one.objectName() != "port_list" and not isinstance(one.parentWidget(), Spoken)}  # fmt: skip
    said |= {(name, one.text()) for one in root.findChildren(QAction) if (name := one.objectName()).startswith("act_")}
    return [
        f"{name} says {text!r}"
        for name, text in sorted(said)
        if not known.issuperset(ENGLISH_WORD.findall(UNTRANSLATED.sub(" ", text)))
    ]


def cut_off_in_any_state(walk: Walk) -> list[str]:
    """With all rows of Settings in each of their states, and with a reason."""
    page, found = walk.find(SettingsPage), list[str]()
    for state in RowState:
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(SettingDraft, "state", state)
            patch.setattr(SettingDraft, "reason", "cannot be read")
            page.refresh()
            walk.settle()
            found += [*cut_off(page), *sideways(page)]
    return found


def faults_in(root: QWidget) -> list[str]:
    """What is wrong with all that is in sight."""
    return [
        *cut_off(root), *unnamed(root), *unreached(root), *unheard(root), *sideways(root), *misnamed(root),
    ]  # fmt: skip


def sideways(root: QWidget) -> list[str]:
    """Lists whose last columns are only seen by scrolling."""
    tables = (one for one in root.findChildren(QTableView) if one.isVisible())
    return [f"{table.objectName()} scrolls sideways" for table in tables if table.horizontalScrollBar().maximum() > 0]


def main_out_of_sight(root: QWidget) -> list[str]:
    buttons = (one for one in root.findChildren(QPushButton) if one.property("role") == "primary" and one.isVisible())
    return [f"{button.objectName()} is out of sight" for button in buttons if not is_in_sight(button)]


def unnamed(root: QWidget) -> list[str]:
    """A name of its own for whoever automates the window, and one for whoever does not see it."""
    controls = controls_in(root)
    found = [
        f"{type(control).__name__} {name_of(control)!r} has no name" for control in controls if not control.objectName()
    ]
    found += [f"{control.objectName()} has no accessible name" for control in controls if not name_of(control)]
    found += [f"{area.objectName()} has no accessible name" for area in root.findChildren(QScrollArea)
              if area.isVisible() and takes_tab(area) and not area.accessibleName()]  # fmt: skip
    found += [f"the name of {part.objectName()} hides its text" for part in root.findChildren(QLabel)
              if part.isVisible() and part.text() and part.accessibleName() and part.text() not in part.accessibleName()
              and not isinstance(part.parentWidget(), Spoken)]  # fmt: skip
    names = Counter(control.objectName() for control in controls)
    return found + [f"{count} controls are called {name}" for name, count in names.items() if count > 1]


_SKIPPED = frozenset({QAccessible.Role.Client, QAccessible.Role.Border, QAccessible.Role.NoRole})
"""Roles that screen readers ignore."""


def interfaces(one: QAccessibleInterface) -> Iterator[QAccessibleInterface]:
    """All that a screen reader sees below it, outermost first."""
    for index in range(one.childCount()):
        child: Any = one.child(index)  # None where Qt has none
        if child is not None and child.isValid() and not child.state().invisible:
            yield child
            yield from interfaces(child)


def unheard(root: QWidget) -> list[str]:
    """What a screen reader passes over although it has something to say, and what it cannot name."""
    found = []
    for one in interfaces(QAccessible.queryAccessibleInterface(root)):
        widget: Any = one.object()  # None for an item of a list
        name, is_focusable = one.text(QAccessible.Text.Name), bool(one.state().focusable)
        is_skipped = one.role() in _SKIPPED and widget is not None
        faults = {
            f"has a name that nobody hears: {name!r}": is_skipped and name,
            "takes the focus and has no role": is_skipped and is_focusable,
            "takes the focus and has no name": widget is not None and is_focusable and not name,
        }
        if one.role() in (QAccessible.Role.SpinBox, QAccessible.Role.Slider):
            value: Any = one.valueInterface()  # None where Qt has none
            faults["has no range"] = value is None or not value.minimumValue() < value.maximumValue()
        where = f"{widget.objectName() or type(widget).__name__} ({one.role().name})" if widget else name
        found += [f"{where} {fault}" for fault, is_there in faults.items() if is_there]
    return found


def misnamed(root: QWidget) -> list[str]:
    """Return a line for every button whose name lacks its text, which users of voice control say."""
    found = []
    for button in root.findChildren(QAbstractButton):
        words, name = button.text().replace("&", "").strip(" …"), button.accessibleName()
        if button.isVisible() and name and len(words) > 1 and words.lower() not in name.lower():
            found.append(f"{button.objectName()} is called {name!r} and says {words!r}")
    return found


def unreached(root: QWidget) -> list[str]:
    """What is enabled and not reached by Tab."""
    return [
        f"{one.objectName()} is not reached by Tab"
        for one in controls_in(root)
        if one.isEnabled() and not takes_tab(one) and not one.objectName().endswith(BY_OTHER_KEYS)
        and not isinstance(one, QLabel)
    ]  # fmt: skip


def tab_chain(window: QWidget) -> list[QWidget]:
    """Return the controls in tab order.

    PySide makes the widget whose `nextInFocusChain` is called the parent of the result. A closed ring of such parents
    would be garbage, and the collector would free visible widgets. So the loop ends before it returns to the window,
    and `findChildren` then restores the parents.
    """
    to_come = {widget for widget in window.findChildren(QWidget) if widget.window() is window}
    chain = [window]
    while to_come:
        following = chain[-1].nextInFocusChain()
        assert following is not None
        to_come.remove(following)
        chain.append(following)
    window.findChildren(QWidget)
    return [
        one
        for one in chain[1:]
        if one.isVisible() and one.isEnabled() and takes_tab(one)
        and one.focusProxy() is None and not one.objectName().startswith("qt_")
    ]  # fmt: skip


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


@pytest.mark.module("settings")
def test_no_key_writes_edits_that_are_not_in_sight(qtbot: QtBot, tmp_path: Path, one: Rig) -> None:
    type_into(one, "attitude_threshold", "75")
    path = tmp_path / "H6.toml"
    path.write_text(PROFILE, encoding="utf-8")
    one.settings.open_file(path)
    for is_written in (False, True):
        qtbot.keyClick(one.settings, Qt.Key.Key_Return, Qt.KeyboardModifier.ControlModifier)
        assert one.settings.work.job.is_running is is_written
        one.settings.on_escape()
    one.until(lambda: one.held("attitude_threshold") == 75)


@pytest.mark.module("settings")
def test_esc_leads_back_to_where_one_came_from(qtbot: QtBot, one: Rig) -> None:
    """From the list of ports and from a question, which are no windows of their own."""
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


def test_the_menu_has_every_key(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with window(qapp, tmp_path) as assembly:
        main = assembly.window
        qtbot.waitUntil(lambda: main.has_pages)
        main.activateWindow()
        qtbot.waitUntil(main.isActiveWindow)
        in_menu = {action for menu in main.findChildren(QMenu) for action in menu.actions()}
        assert main.menus["lock"] in in_menu
        assert in_menu.issuperset(main.actions()), "no key without an entry"
        qtbot.keyClick(main, Qt.Key.Key_F10)
        qtbot.waitUntil(main.main_menu.isVisible)
        main.main_menu.close()
