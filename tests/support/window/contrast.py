"""Contrast of colours, and what text of a theme may stand on."""

from PySide6.QtGui import QColor

from ui.style.theme import Theme


def surfaces_of(theme: Theme) -> tuple[str, str, str, str]:
    """Everything that text may stand on."""
    return (theme.window, theme.surface, theme.sunken, theme.raised)


def contrast(one: str, other: str) -> float:
    """The contrast of two colours, 1 to 21, as WCAG 2.1 defines it (success criterion 1.4.3)."""
    brighter, darker = sorted((_luminance(one), _luminance(other)), reverse=True)
    return (brighter + 0.05) / (darker + 0.05)


def _luminance(colour: str) -> float:
    one = QColor(colour)
    red, green, blue = (
        part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4
        for part in (one.redF(), one.greenF(), one.blueF())
    )
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue
