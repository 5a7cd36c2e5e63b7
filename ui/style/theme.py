"""Colours, sizes and fonts of the window.

Three themes: light, dark, and sunlight, which is black on white with thick lines for a laptop outdoors. Surfaces and
text are neutral; colour is kept for what has a meaning, and the meanings are five. Every text colour has a contrast of
4.5:1 on every surface and on what is selected (7:1 in sunlight) and every line 3:1; `tests/window/style/test_theme.py`
computes them. Danger differs from attention also for eyes without red or green. All lengths are logical pixels, so that
200 % is only a matter of the screen.
"""

from collections.abc import Mapping
from enum import Enum, IntEnum
from functools import cache
from types import MappingProxyType
from typing import Final, NamedTuple

from PySide6.QtGui import QColor, QFont, QFontDatabase
from PySide6.QtWidgets import QApplication


class Meaning(Enum):
    """The meaning of a colour. Never colour alone: an icon and a word go with it."""

    GOOD = "good"
    ATTENTION = "attention"
    DANGER = "danger"
    INFORMATION = "information"
    UNKNOWN = "unknown"


class Choice(Enum):
    """The choice of a person; AUTO is light or dark, as the system is."""

    AUTO = "auto"
    LIGHT = "light"
    DARK = "dark"
    SUNLIGHT = "sunlight"


class Space(IntEnum):
    """Gaps, in logical pixels."""

    XS = 4
    S = 8
    M = 12
    L = 16
    XL = 24


class Size(IntEnum):
    """Text, in logical pixels."""

    SMALL = 12
    BODY = 14
    TITLE = 18
    NUMBER = 28


class IconSize(IntEnum):
    """Pictures, in logical pixels."""

    TEXT = 16
    STATE = 18
    NOTICE = 20
    BUTTON = 24
    EMPTY = 48


class RowHeight(IntEnum):
    """Rows of tables, in logical pixels."""

    DENSE = 24
    LIST = 28
    TALL = 36


class Tint(NamedTuple):
    """One meaning's colours as #rrggbb: ``ink`` for text, icons and lines on a surface; ``fill`` with
    ``on_fill`` upon it for what is loud; ``wash`` is a quiet background for text in ``ink``."""

    ink: str
    fill: str
    on_fill: str
    wash: str


class Theme(NamedTuple):
    """One appearance.  Colours are #rrggbb, ``line_px`` is the width of curves and limits.

    ``window`` is behind everything, ``surface`` is a card or a field, ``sunken`` a bar or a header,
    ``raised`` what lies under the pointer.  ``border`` bounds a control, ``divider`` only parts two areas.
    ``disabled`` is the ink of what cannot be used now: as faint as 3:1 allows.
    """

    name: str
    is_dark: bool
    window: str
    surface: str
    sunken: str
    raised: str
    text: str
    muted: str
    disabled: str
    border: str
    divider: str
    selection: str
    primary: str
    on_primary: str
    curves: tuple[str, str, str]
    meanings: Mapping[Meaning, Tint]
    line_px: int
    border_px: int

    @property
    def danger(self) -> Tint:
        """The tint of what can fire, and what went wrong."""
        return self.meanings[Meaning.DANGER]

    @property
    def attention(self) -> Tint:
        """The tint of what needs a second look."""
        return self.meanings[Meaning.ATTENTION]

    @property
    def information(self) -> Tint:
        """The tint of what is chosen, focused or linked."""
        return self.meanings[Meaning.INFORMATION]

    def tint(self, meaning: Meaning) -> Tint:
        return self.meanings[meaning]

    def ink(self, meaning: Meaning | None) -> QColor:
        """The colour of text, icon or line; None is plain text."""
        return QColor(self.text if meaning is None else self.meanings[meaning].ink)


# Light, dark, sunlight; in the order of the fields of `Theme`.
_COLOURS: Final = (
    ("#F4F5F7", "#121519", "#FFFFFF"),  # window
    ("#FFFFFF", "#1A1E23", "#FFFFFF"),  # surface
    ("#EBEDF0", "#0D0F12", "#F1F1F1"),  # sunken
    ("#F4F5F7", "#242A31", "#F1F1F1"),  # raised
    ("#15181C", "#E9ECEF", "#000000"),  # text
    ("#565E69", "#A3ABB6", "#333333"),  # muted
    ("#85898F", "#767D86", "#6E6E6E"),  # disabled
    ("#7F8792", "#737D8A", "#000000"),  # border
    ("#DCDFE4", "#2B3138", "#000000"),  # divider
    ("#DCE7F6", "#23405F", "#FFE48A"),  # selection
    ("#22272E", "#E9ECEF", "#000000"),  # primary
    ("#FFFFFF", "#15181C", "#FFFFFF"),  # on_primary
)
# Okabe and Ito's blue, bluish green and reddish purple, made darker or lighter until they have the contrast; their
# vermilion is left out, because beside it the red of danger would say nothing.
_CURVES: Final = (
    ("#0072B2", "#00805C", "#A14B7D"),
    ("#56B4E9", "#2FC69B", "#E08FBC"),
    ("#004A77", "#00543C", "#70244F"),
)
_MEANINGS: Final = {
    Meaning.GOOD: (
        Tint("#1B7449", "#1B7449", "#FFFFFF", "#E6F4EC"),
        Tint("#4FC48C", "#4FC48C", "#04150D", "#15301F"),
        Tint("#00502C", "#00502C", "#FFFFFF", "#E2F5EA"),
    ),
    Meaning.ATTENTION: (
        Tint("#855200", "#F3B434", "#1F1600", "#FDF3DC"),
        Tint("#F0B441", "#F0B441", "#1F1600", "#33290F"),
        Tint("#5C3A00", "#FFCB00", "#000000", "#FFF1C9"),
    ),
    Meaning.DANGER: (
        Tint("#B3163E", "#B3163E", "#FFFFFF", "#FCEBEA"),
        Tint("#FF8A85", "#CF3439", "#FFFFFF", "#3A1D1E"),
        Tint("#8C0030", "#8C0030", "#FFFFFF", "#FFE9E7"),
    ),
    Meaning.INFORMATION: (
        Tint("#1B5FB5", "#1B5FB5", "#FFFFFF", "#E8F0FB"),
        Tint("#74B3FA", "#74B3FA", "#04121F", "#15283E"),
        Tint("#003C8A", "#003C8A", "#FFFFFF", "#E4EEFC"),
    ),
    Meaning.UNKNOWN: (
        Tint("#565E69", "#565E69", "#FFFFFF", "#EBEDF0"),
        Tint("#A3ABB6", "#A3ABB6", "#121519", "#242A31"),
        Tint("#000000", "#000000", "#FFFFFF", "#FFFFFF"),
    ),
}


def _theme(name: str, column: int) -> Theme:
    colours = (row[column] for row in _COLOURS)
    meanings = MappingProxyType({meaning: tints[column] for meaning, tints in _MEANINGS.items()})
    thickness = 2 if name == "sunlight" else 1
    return Theme._make((name, name == "dark", *colours, _CURVES[column], meanings, thickness, thickness))


LIGHT, DARK, SUNLIGHT = THEMES = _theme("light", 0), _theme("dark", 1), _theme("sunlight", 2)

_in_use: Theme = LIGHT
_zoom = 1.0


def current() -> Theme:
    """The theme in use.  What paints itself asks at every paint and so follows a change."""
    return _in_use


def use(theme: Theme) -> None:
    """Make `theme` the current one; `ui.style.appearance` applies it to the window too."""
    global _in_use  # noqa: PLW0603  one reference, like the language: every painter asks for it
    _in_use = theme


def zoom(percent: int) -> None:
    """Text and controls made from now on are larger than usual; chosen before the first widget is made."""
    global _zoom  # noqa: PLW0603  as the theme
    _zoom = percent / 100


def scale_in_use() -> float:
    return _zoom


def is_text_large() -> bool:
    """Return whether text is so large that what lies side by side in its usual size has no room for that any more."""
    return scale_in_use() > 1.5


def scaled(px: float) -> int:
    """A length of text or of a control, in the size in use."""
    return round(px * scale_in_use())


def fixed_font(size: Size = Size.BODY) -> QFont:
    """The system's font with characters of one width, for bytes and commands."""
    fixed = QFontDatabase.systemFont(QFontDatabase.SystemFont.FixedFont)
    fixed.setPixelSize(scaled(size))
    return fixed


def font(size: Size = Size.BODY, *, is_bold: bool = False) -> QFont:
    """The application's font with figures of one width, in one of the five sizes.

    Bold is a calm medium where the font has one, and truly bold in sunlight.
    """
    return QFont(kept_font(scaled(size), is_bold, _in_use.line_px))


@cache
def kept_font(px: int, is_bold: bool, line_px: float) -> QFont:
    """Return a font that is kept, as to make one takes as long as to write a word in it. To be cleared when the
    application's font is another."""
    strong = QFont.Weight.Medium if line_px == 1 else QFont.Weight.Bold
    kept = QFont(QApplication.font())
    kept.setPixelSize(px)
    kept.setWeight(strong if is_bold else QFont.Weight.Normal)
    kept.setKerning(False)  # Arial and Liberation Sans move one 1 closer to the next
    return kept
