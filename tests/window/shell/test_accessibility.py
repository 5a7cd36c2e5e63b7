"""Finds widgets that Python's garbage collector would free although Qt still shows them.

Every control has names and descriptions; painted widgets describe what they show.
"""

import gc
from collections import Counter
from itertools import pairwise
from pathlib import Path
from typing import cast

import pytest
import shiboken6
from PySide6.QtCore import QObject, QSize
from PySide6.QtGui import QAccessible
from PySide6.QtWidgets import QAbstractButton, QApplication, QLabel, QScrollArea, QTableView, QWidget
from pytestqt.qtbot import QtBot

from app.settings.form import RowState, SettingDraft
from app.text.i18n import CHINESE, ENGLISH
from tests.support.pseudo_language import PSEUDO
from tests.support.thorough import IS_THOROUGH
from tests.support.window import screen_reader
from tests.support.window.controls import controls_in, goes_back, place, tab_chain, takes_tab
from tests.support.window.cut_off import cut_off
from tests.support.window.screen_reader import misnamed, unheard
from tests.support.window.spoken import untranslated
from tests.support.window.walk import SMALL_SCREEN, Walk, walking
from ui.core.preferences import MAX_ZOOM_PERCENT, Preferences
from ui.main import PAGES
from ui.pages.settings.page import SettingsPage
from ui.shell.main_window import SMALLEST
from ui.style.appearance import Spoken
from ui.style.theme import Choice, Space


def living_garbage(root: QObject) -> list[str]:
    """Return the descendants of `root` (according to Qt) that are garbage according to Python.

    Freeing them removes them from the window. This happens when PySide has recorded a wrong parent for an object, as
    some calls (`nextInFocusChain`) make it do.
    """
    debug = gc.get_debug()
    gc.set_debug(gc.DEBUG_SAVEALL)
    try:
        gc.collect()
        found = [one for one in gc.garbage if isinstance(one, QObject) and shiboken6.isValid(one)]
        return sorted(f"{type(one).__name__} {one.objectName()}" for one in found if _is_in(one, root))
    finally:
        gc.set_debug(debug)
        gc.garbage.clear()


def _is_in(one: QObject, root: QObject) -> bool:
    around: QObject | None = one
    while around is not None and around is not root:
        around = around.parent()
    return around is root


FULL_HD_AT_200 = QSize(960, 540)
BY_OTHER_KEYS = ("_less", "_more")
"""Beside a number field, whose arrow keys do the same: a stop of Tab would only be in the way."""
FROM_CANCEL_ON = ("ritual_", "_cancel", "_go", "_ask")
"""Cancel has the focus at every step, and one Tab leads to what comes next, wherever the two stand."""


@pytest.mark.parametrize(
    ("language", "theme", "size"),
    [
        pytest.param(ENGLISH, Choice.SUNLIGHT, SMALL_SCREEN, id="sunlight"),
        *(
            [
                pytest.param(PSEUDO, Choice.DARK, SMALL_SCREEN, id="longer"),
                pytest.param(ENGLISH, Choice.LIGHT, SMALLEST, id="smallest"),
            ]
            if IS_THOROUGH
            else []
        ),
    ],
)
def test_the_walk(qtbot: QtBot, qapp: QApplication, tmp_path: Path, language: str, theme: Choice, size: QSize) -> None:
    """All that is asked of what stands in the window: a few walks, because it is the walk that takes time."""
    faults: dict[str, str] = {}
    controls = 0
    texts: list[str] = []
    with walking(qtbot, qapp, tmp_path, language=language, theme=theme, size=size) as walk:
        for stop in walk.stops():
            assert walk.window.size() == size, stop.name
            found = faults_in(stop.root, language, texts)
            if found:  # a value that came meanwhile may not be laid out yet: what stays is a fault
                walk.settle()
                again = faults_in(stop.root, language, texts)
                found = [fault for fault in found if fault in again]
            controls += len(controls_in(stop.root))
            if theme is not Choice.DARK and stop.name in {entry.key for entry in PAGES}:
                # Tilt and charge move something each time or never; a first look on a busy machine may be too early.
                found += walk.shake() and walk.shake()
            for fault in found:
                faults.setdefault(fault, stop.name)
        for name in living_garbage(walk.window):
            faults.setdefault(f"the collector would free {name}", "the end")
        for fault in nameless(walk.window):
            faults.setdefault(fault, "out of sight")
        own = [
            button for button in walk.window.findChildren(QAbstractButton) if type(button).__module__.startswith("ui.")
        ]
    assert {type(one).__name__ for one in own} >= {"PortButton", "HoldButton"}  # they paint themselves
    assert controls > 500
    assert len(set(texts)) > 400
    assert not faults, "\n".join(f"{name}: {fault}" for fault, name in faults.items())


def test_large_text(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    """At twice the size of text each page wraps, folds and scrolls: nothing is cut off, and no list scrolls
    sideways."""
    faults: dict[str, str] = {}
    folder = tmp_path / "200"  # a part of the port's name, which cannot wrap
    folder.mkdir()
    Preferences(folder / "window.ini").zoom_percent = MAX_ZOOM_PERCENT
    with walking(qtbot, qapp, folder, theme=Choice.SUNLIGHT) as walk:  # whose letters are bold
        for stop in walk.stops():
            assert walk.window.size() == SMALL_SCREEN, stop.name
            found = [*cut_off(stop.root), *sideways(stop.root), *parted(stop.root)]
            if stop.name == "settings":
                found += cut_off_in_any_state(walk)
            for fault in found:
                faults.setdefault(fault, stop.name)
    faults = {fault: name for fault, name in faults.items() if not fault.startswith("bundle_text")}  # a file's lines
    assert not faults, "\n".join(f"{name}: {fault}" for fault, name in faults.items())


@pytest.mark.parametrize(("size", "percent"), [(FULL_HD_AT_200, 100), (SMALL_SCREEN, MAX_ZOOM_PERCENT)])
def test_in_chinese_nothing_is_cut_off_on_any_page_of_a_module(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path, size: QSize, percent: int
) -> None:
    Preferences(tmp_path / "window.ini").zoom_percent = percent
    found = []
    with walking(qtbot, qapp, tmp_path, language=CHINESE, theme=Choice.SUNLIGHT, size=size) as walk:
        next(stop for stop in walk.stops() if stop.name == PAGES[0].key)
        for entry in PAGES:
            walk.window.go_to(entry.key)
            walk.settle()
            found += [*cut_off(walk.window), *sideways(walk.window)]
    assert found == []


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


def faults_in(root: QWidget, language: str, texts: list[str]) -> list[str]:
    """What is wrong with all that is in sight. The texts that were measured are added to `texts`."""
    found = [*cut_off(root, texts), *unnamed(root), *out_of_order(root),
             *unheard(root), *sideways(root)]  # fmt: skip
    return [*found, *(untranslated(root) if language == PSEUDO else misnamed(root))]


def sideways(root: QWidget) -> list[str]:
    """Lists whose last columns are only seen by scrolling."""
    tables = (one for one in root.findChildren(QTableView) if one.isVisible())
    return [f"{table.objectName()} scrolls sideways" for table in tables if table.horizontalScrollBar().maximum() > 0]


def parted(root: QWidget) -> list[str]:
    """Captions that stand in another row than their field, and not above it either."""
    found = []
    for caption in root.findChildren(QLabel):
        field = cast("QWidget | None", caption.buddy())
        if field is not None and caption.isVisible() and field.isVisible():
            here, there = place(caption), place(field)
            is_beside = here.top() <= there.bottom() and there.top() <= here.bottom()
            is_above = here.bottom() < there.top() and here.left() < there.left() + Space.XL
            if not is_beside and not is_above:
                found.append(f"{caption.objectName()} stands apart from its field")
    return found


def unnamed(root: QWidget) -> list[str]:
    """A name of its own for whoever automates the window, and one for whoever does not see it."""
    controls = controls_in(root)
    found = [
        f"{type(control).__name__} {_spoken_name(control)!r} has no name"
        for control in controls
        if not control.objectName()
    ]
    found += [f"{control.objectName()} has no accessible name" for control in controls if not _spoken_name(control)]
    found += [f"{area.objectName()} has no accessible name" for area in root.findChildren(QScrollArea)
              if area.isVisible() and takes_tab(area) and not area.accessibleName()]  # fmt: skip
    found += [f"the name of {part.objectName()} hides its text" for part in root.findChildren(QLabel)
              if part.isVisible() and part.text() and part.accessibleName() and part.text() not in part.accessibleName()
              and not isinstance(part.parentWidget(), Spoken)]  # fmt: skip
    names = Counter(control.objectName() for control in controls)
    return found + [f"{count} controls are called {name}" for name, count in names.items() if count > 1]


def nameless(root: QWidget) -> list[str]:
    """Also the buttons that no stop has in sight."""
    return [
        f"{button.objectName()!r} with {button.text() or button.toolTip()!r} has no name"
        for button in root.findChildren(QAbstractButton)
        if (button.text() or button.toolTip()) and not (button.objectName() and screen_reader.name_of(button))
        and not button.objectName().startswith("qt_")
    ]  # fmt: skip


def _spoken_name(widget: QWidget) -> str:
    reader = QAccessible.queryAccessibleInterface(widget)
    return widget.accessibleName() or reader.text(QAccessible.Text.Name)


def out_of_order(root: QWidget) -> list[str]:
    """Everything is reached by Tab, in the order in which one reads."""
    # LOCK, added to a dialog that is shown, has its keys: Tab begins with the dialog's own controls.
    chain = list(tab_chain(root))
    found = [
        f"Tab goes from {one.objectName()} back to {other.objectName()}"
        for one, other in pairwise(chain)
        if goes_back(one, other, root) and not _is_from_cancel(one, other)
    ]
    return found + [
        f"{one.objectName()} is not reached by Tab"
        for one in controls_in(root)
        if one.isEnabled() and not takes_tab(one) and not one.objectName().endswith(BY_OTHER_KEYS)
        and not isinstance(one, QLabel)
    ]  # fmt: skip


def _is_from_cancel(one: QWidget, other: QWidget) -> bool:
    return all(any(part in widget.objectName() for part in FROM_CANCEL_ON) for widget in (one, other))
