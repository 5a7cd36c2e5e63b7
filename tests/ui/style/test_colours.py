"""What is out of sight follows a change of theme when it is shown, before it is painted; contrast of the colours."""

import re
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest
from PySide6.QtCore import QEvent, QObject, QRect
from PySide6.QtGui import QImage, QPalette
from PySide6.QtWidgets import QApplication, QDialog, QLabel, QPushButton, QVBoxLayout, QWidget
from pytestqt.qtbot import QtBot

from tests.support.window.contrast import DISABLED, contrast, wanted
from tests.support.window.fakes_ui import page_entries, window
from tests.support.window.painted_text import colours_in
from tests.support.window.steps import find
from ui.style.appearance import style_sheet
from ui.style.theme import DARK, LIGHT, THEMES, Choice, Theme

_PLAIN = page_entries("settings", "triggers", "commands")
_INK = QPalette.ColorRole.ButtonText


class _Paints(QObject):
    """The colours in which buttons were painted, from its making on; and how often they were dressed."""

    def __init__(self, root: QWidget) -> None:
        super().__init__(root)
        self.inks: set[str] = set()
        self.dressed = 0
        for button in root.findChildren(QPushButton):
            button.installEventFilter(self)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        if isinstance(watched, QPushButton):
            if event.type() == QEvent.Type.Paint:
                self.inks.add(watched.palette().color(_INK).name())
            self.dressed += event.type() == QEvent.Type.StyleChange
        return False


def _settled(page: QWidget, qtbot: QtBot) -> QImage:
    """The page once what it polls has been shown."""
    seen = [QImage()]

    def is_settled() -> bool:
        qtbot.wait(300)
        seen.append(page.grab().toImage())
        return seen[-1] == seen[-2]

    qtbot.waitUntil(is_settled)
    return seen[-1]


def test_a_page_out_of_sight_is_dressed_when_it_is_shown(qapp: QApplication, qtbot: QtBot, tmp_path: Path) -> None:
    with window(qapp, tmp_path, entries=_PLAIN) as assembly:
        main = assembly.window
        qtbot.waitUntil(lambda: main.stack.count() == len(_PLAIN))
        assembly.appearance.choose(Choice.LIGHT)
        main.panel.hide()
        for entry in _PLAIN:
            main.go_to(entry.key)
            QApplication.processEvents()
        main.go_to("commands")
        page = find(main, QWidget, "settings_page")
        paints = _Paints(page)
        assembly.appearance.choose(Choice.DARK)
        QApplication.processEvents()
        assert (paints.dressed, paints.inks) == (0, set())
        main.go_to("settings")
        QApplication.processEvents()
        assert paints.dressed > 0
        assert paints.inks
        assert {ink.upper() for ink in paints.inks} <= {
            DARK.text,
            DARK.muted,
            DARK.disabled,
            DARK.on_primary,
            DARK.danger.ink,
        }
        followed = _settled(page, qtbot)
        assembly.appearance.choose(Choice.LIGHT)
        QApplication.processEvents()
        assert page.grab().toImage() != followed
        assembly.appearance.choose(Choice.DARK)
        qtbot.waitUntil(lambda: page.grab().toImage() == followed)
        assembly.appearance.choose(Choice.LIGHT)


def test_a_dialog_that_comes_later_or_was_closed_wears_the_theme(
    qapp: QApplication, qtbot: QtBot, tmp_path: Path
) -> None:
    with window(qapp, tmp_path, entries=()) as assembly:
        assembly.appearance.choose(Choice.DARK)
        dialog = QDialog(assembly.window)
        column = QVBoxLayout(dialog)
        button, label = QPushButton("Close"), QLabel("muted")
        label.setProperty("role", "muted")
        column.addWidget(button)
        column.addWidget(label)
        for choice, theme in ((Choice.DARK, DARK), (Choice.LIGHT, LIGHT), (Choice.DARK, DARK)):
            assembly.appearance.choose(choice)
            dialog.show()
            qtbot.waitExposed(dialog)
            assert button.palette().color(_INK).name().upper() == theme.text
            assert label.palette().color(QPalette.ColorRole.WindowText).name().upper() == theme.muted
            dialog.hide()
        assembly.appearance.choose(Choice.LIGHT)


def test_pictures_are_measured_as_colours_are() -> None:
    place = QRect(0, 0, 4, 1)
    row = np.array([[0xFFFFFFFF] * 6 + [0xFF767676] * 2], np.uint32).repeat(2, axis=0)
    colours = colours_in(row, place)
    assert colours.ground == "#ffffff"
    colour, ratio = colours.strongest_ink()
    assert (colour, ratio) == ("#767676", pytest.approx(contrast("#767676", "#ffffff")))


# The states that no walk sees: under the pointer, pressed, chosen, switched off.

_PARTS = ("background", "background-color", "color", "selection-background-color", "selection-color")


def rules_of(theme: Theme) -> dict[str, dict[str, str]]:
    """What the style sheet says of each selector: colours only."""
    rules: dict[str, dict[str, str]] = {}
    for selectors, body in re.findall(r"([^{}]+)\{([^{}]*)\}", style_sheet(theme)):
        colours = {
            name.strip(): value.strip()
            for name, _, value in (line.partition(":") for line in body.split(";"))
            if name.strip() in _PARTS and re.fullmatch(r"#[0-9A-Fa-f]{6}", value.strip())
        }
        for selector in selectors.split(","):
            rules.setdefault(selector.strip(), {}).update(colours)
    return rules


def cascaded(rules: Mapping[str, dict[str, str]], selector: str, theme: Theme) -> dict[str, str]:
    """With what the selector takes over from the control without state, and without role."""
    whole = {"color": theme.text, "background": theme.surface}
    control = re.split(r"[\[:]", selector, maxsplit=1)[0]
    role = re.match(r"[^:]*\[[^]]*\]", selector)
    for one in (control, "" if role is None else role[0], selector):
        whole |= rules.get(one, {})
    return whole


@pytest.mark.parametrize("theme", THEMES, ids=lambda theme: theme.name)
def test_every_state_in_the_style_sheet_is_readable(theme: Theme) -> None:
    rules = rules_of(theme)
    assert 'QPushButton[role="danger"]:pressed' in rules
    weak = []
    for selector in rules:
        whole = cascaded(rules, selector, theme)
        least = DISABLED if ":disabled" in selector else wanted(theme)
        pairs = [(whole["color"], whole["background"])]
        if "selection-background-color" in whole:
            pairs.append((whole.get("selection-color", whole["color"]), whole["selection-background-color"]))
        if not any(
            part in selector
            for part in ("::indicator", "::chunk", "::handle", "::separator", "QProgressBar", 'role="line"')
        ):
            weak += [f"{selector}: {one} on {other}" for one, other in pairs if contrast(one, other) < least]
    assert not weak, "\n".join(weak)
