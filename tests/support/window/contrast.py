"""Contrast of colours, and the theme for widgets in no window."""

from PySide6.QtGui import QColor
from PySide6.QtWidgets import QApplication

from ui.style import appearance
from ui.style.theme import SUNLIGHT, Theme

DISABLED = 3.0
"""Least contrast of disabled controls, for which WCAG requires none."""


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
    darker, brighter = sorted((_luminance(one), _luminance(other)))
    return (brighter + 0.05) / (darker + 0.05)


def _luminance(colour: str) -> float:
    one = QColor(colour)
    parts = (one.redF(), one.greenF(), one.blueF())
    linear = [part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4 for part in parts]
    return sum(share * part for share, part in zip((0.2126, 0.7152, 0.0722), linear, strict=True))
