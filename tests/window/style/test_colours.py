"""What is out of sight follows a change of theme when it is shown, before it is painted; contrast of the colours."""

import re
from collections.abc import Mapping
from pathlib import Path

import pytest
from PySide6.QtGui import QPalette
from PySide6.QtWidgets import QApplication, QDialog, QLabel, QPushButton, QVBoxLayout
from pytestqt.qtbot import QtBot

from tests.support.window.contrast import DISABLED, contrast, wanted
from tests.support.window.fakes_ui import window
from ui.style.appearance import style_sheet
from ui.style.theme import DARK, LIGHT, THEMES, Choice, Theme

_INK = QPalette.ColorRole.ButtonText


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
