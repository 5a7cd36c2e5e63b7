"""The contrast of every text as it stands in the window, in every theme: measured on the picture, not on the plan."""

import re
from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np
import pytest
from PySide6.QtCore import QPoint, QRect
from PySide6.QtWidgets import QAbstractButton, QApplication, QComboBox, QLabel, QLineEdit, QWidget
from pytestqt.qtbot import QtBot

from tests.support.window.contrast import contrast, surfaces_of
from tests.support.window.painted_text import Drawn, Pixels, colours_in, picture_of, watching
from tests.support.window.walk import walking
from ui.style.style_sheet import style_sheet
from ui.style.theme import SUNLIGHT, THEMES, Choice, Theme, current
from ui.widgets.step_button import StepButton

DISABLED = 3.0
"""WCAG asks nothing of what cannot be used now; it should still be read."""
_FRAME_PX = 4
_ROUNDING = 0.01


def wanted(theme: Theme) -> float:
    return 7.0 if theme is SUNLIGHT else 4.5


@pytest.mark.parametrize("choice", [Choice.LIGHT, Choice.DARK, Choice.SUNLIGHT])
def test_every_text_in_the_window_is_readable(qtbot: QtBot, qapp: QApplication, tmp_path: Path, choice: Choice) -> None:
    weak: set[str] = set()
    seen = 0
    with walking(qtbot, qapp, tmp_path, theme=choice) as walk:
        for stop in walk.stops():
            unusable = unusable_in(stop.root)
            with watching() as drawn:
                picture = picture_of(stop.root)
            found = [*weak_in_style(stop.root, picture, unusable), *weak_in_paint(stop.root, picture, drawn)]
            weak |= {f"{stop.name}: {one}" for one in found}
            seen += len(drawn)
    assert seen > 300
    assert not weak, "\n".join(sorted(weak))


def unusable_in(root: QWidget) -> set[QWidget]:
    """When the picture is taken: half a second later a dead step is live."""
    return {one for one in root.findChildren(QWidget) if not _is_usable(one)}


def weak_in_style(root: QWidget, picture: Pixels, unusable: set[QWidget]) -> Iterator[str]:
    """Labels, buttons and fields: what Qt's style draws from the style sheet."""
    for widget in root.findChildren(QWidget):
        if not widget.isVisible() or not _text_of(widget):
            continue
        place = _in_sight(widget, root)
        if place.width() < 12 or place.height() < 10 or place.height() < widget.height() / 2:
            continue  # scrolled out of sight, all but a strip without letters
        colour, ratio = colours_in(picture, place).strongest_ink()
        least = DISABLED if widget in unusable else wanted(current())
        if ratio < least - _ROUNDING:
            yield f"{widget.objectName()} {_text_of(widget)!r}: {colour} has {ratio:.2f}"


def weak_in_paint(root: QWidget, picture: Pixels, drawn: list[Drawn]) -> Iterator[str]:
    """Numbers, chips, gauges, plots and table cells."""
    for one in drawn:
        if not root.isAncestorOf(one.widget):
            continue
        corner = one.widget.mapTo(root, QPoint(0, 0))
        place = one.place.translated(corner.x(), corner.y()).toAlignedRect()
        place = place.intersected(_in_sight(one.widget, root, frame_px=0))
        if place.width() < 4 or place.height() < 6:
            continue
        ground = colours_in(picture, place.adjusted(-1, -1, 1, 1)).ground
        ratio = contrast(one.colour.name(), ground)
        least = wanted(current()) if one.widget.isEnabled() else DISABLED
        if ratio < least - _ROUNDING:
            name = one.widget.objectName() or type(one.widget).__name__
            yield f"{name} draws {one.text!r}: {one.colour.name()} on {ground} has {ratio:.2f}"
        if one.colour.alpha() != 255:
            yield f"{one.text!r} is drawn with a colour that lets the ground through"


def _is_usable(widget: QWidget) -> bool:
    """A step of an act is dead for half a second after it appeared."""
    return widget.isEnabled() and (not isinstance(widget, StepButton) or widget.is_live)


def _text_of(widget: QWidget) -> str:
    match widget:
        case QLabel():
            return widget.text() if widget.pixmap().isNull() else ""
        case QAbstractButton():
            return widget.text()
        case QComboBox():
            return widget.currentText() or widget.placeholderText()
        case QLineEdit():
            return widget.text() or widget.placeholderText()
    return ""


def _in_sight(widget: QWidget, root: QWidget, *, frame_px: int = _FRAME_PX) -> QRect:
    """Where the widget's text may stand, in `root`; without the frame, which would pass for text."""
    frame = 0 if isinstance(widget, QLabel) else frame_px
    region = widget.visibleRegion().boundingRect().adjusted(frame, frame, -frame, -frame)
    return region.translated(widget.mapTo(root, QPoint(0, 0)))


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
        if not any(part in selector for part in ("::indicator", "::chunk", "::handle", "::separator", "QProgressBar")):
            weak += [f"{selector}: {one} on {other}" for one, other in pairs if contrast(one, other) < least]
    assert not weak, "\n".join(weak)


@pytest.mark.parametrize("theme", THEMES, ids=lambda theme: theme.name)
def test_what_has_the_focus_or_is_ticked_stands_out(theme: Theme) -> None:
    """Graphics that say something: 3:1 against what is beside them (WCAG 1.4.11)."""
    for ground in surfaces_of(theme):
        for graphic in (theme.information.ink, theme.border, theme.primary):
            assert contrast(graphic, ground) >= 3, (graphic, ground)
    assert contrast(theme.on_primary, theme.primary) >= 3  # the tick in its box
    assert contrast(theme.information.ink, theme.selection) >= 3  # the end of a progress bar
