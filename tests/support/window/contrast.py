"""Finds texts of a window whose contrast is too low, measured on a picture of it."""

from collections.abc import Iterator

import numpy as np
from PySide6.QtCore import QPoint, QRect
from PySide6.QtGui import QColor
from PySide6.QtWidgets import QAbstractButton, QApplication, QComboBox, QLabel, QLineEdit, QWidget

from tests.support.window.controls import visible_in
from tests.support.window.painted_text import Drawn, Pixels, colours_in, luminance
from ui.style import appearance
from ui.style.theme import SUNLIGHT, Theme, current
from ui.widgets.step_button import StepButton

DISABLED = 3.0
"""Least contrast of disabled controls, for which WCAG requires none."""
_FRAME_PX = 4
_ROUNDING = 0.01


def style_all(app: QApplication, theme: Theme) -> None:
    """Style all widgets, for those in no window; the sheet is taken away after the test."""
    appearance.apply(app, theme)
    app.setStyleSheet(appearance.style_sheet(theme))


def wanted(theme: Theme) -> float:
    """Return the least contrast of text in a theme."""
    return 7.0 if theme is SUNLIGHT else 4.5


def surfaces_of(theme: Theme) -> tuple[str, str, str, str]:
    """Return the colours behind text."""
    return (theme.window, theme.surface, theme.sunken, theme.raised)


def contrast(one: str, other: str) -> float:
    """Return the contrast of two colours, 1 to 21, as WCAG 2.1 defines it (success criterion 1.4.3)."""
    darker, brighter = sorted(luminance(np.array([QColor(one).rgb(), QColor(other).rgb()], np.uint32)).tolist())
    return float((brighter + 0.05) / (darker + 0.05))


def unusable_in(root: QWidget) -> set[QWidget]:
    """Return the widgets that cannot be used now; call it when the picture is taken."""
    return {one for one in visible_in(root) if not _is_usable(one)}


def weak_in_style(root: QWidget, picture: Pixels, unusable: set[QWidget]) -> Iterator[str]:
    """Yield labels, buttons and fields, drawn by Qt's style, whose contrast is too low."""
    for widget in visible_in(root):
        if not _text_of(widget):
            continue
        place = _in_sight(widget, root)
        whole_px = widget.height() - (0 if isinstance(widget, QLabel) else 2 * _FRAME_PX)
        least_px = max(10, min(whole_px, 2 * widget.fontMetrics().height()))
        if place.width() < 12 or place.height() < least_px:
            continue  # scrolled so far that perhaps no line of it is whole: of a "°" only the top has ink
        colour, ratio = colours_in(picture, place).strongest_ink()
        least = DISABLED if widget in unusable else wanted(current())
        if ratio < least - _ROUNDING:
            yield f"{widget.objectName()} {_text_of(widget)!r}: {colour} has {ratio:.2f}"


def weak_in_paint(root: QWidget, picture: Pixels, drawn: list[Drawn]) -> Iterator[str]:
    """Yield texts painted by the window's own widgets whose contrast is too low."""
    for number, one in enumerate(drawn):
        if not root.isAncestorOf(one.widget) or any(_covers(later, one) for later in drawn[number + 1 :]):
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


def _covers(later: Drawn, one: Drawn) -> bool:
    """Return whether a later text lies over it, as the time at the cursor does over the axis."""
    return later.widget is one.widget and later.place.contains(one.place.center())


def _is_usable(widget: QWidget) -> bool:
    """Return whether it is enabled; a step of an act stays disabled for 0.5 s after it appears."""
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
    """Return the visible area of a widget in `root`, without its frame, which would be taken for text."""
    frame = 0 if isinstance(widget, QLabel) else frame_px
    region = widget.visibleRegion().boundingRect().adjusted(frame, frame, -frame, -frame)
    return region.translated(widget.mapTo(root, QPoint(0, 0)))
