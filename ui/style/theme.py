"""Colours, sizes and type of the window, in one place.

Three themes: light, dark, and sunlight, which is black on white with thick lines for a laptop outdoors.
Surfaces and text are neutral; colour is kept for what has a meaning, and the meanings are five.  Every text
colour has a contrast of 4.5:1 on every surface (7:1 in sunlight) and every line 3:1; ``tests/ui/style/test_theme.py``
computes it.  All lengths are logical pixels, so that 200 % is only a matter of the screen.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum, IntEnum
from types import MappingProxyType
from typing import Final

from PySide6.QtCore import QObject, Qt, Signal
from PySide6.QtGui import QColor, QFont, QFontDatabase, QFontInfo, QPalette
from PySide6.QtWidgets import QApplication, QWidget
from shiboken6 import isValid

from ui.style.style_sheet import style_sheet


class Meaning(Enum):
    """What a colour says.  Never colour alone: an icon and a word go with it."""

    GOOD = "good"
    ATTENTION = "attention"
    DANGER = "danger"
    INFORMATION = "information"
    UNKNOWN = "unknown"


class Choice(Enum):
    """What a person chooses; AUTO is light or dark, as the system is."""

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
    HERO = 48


@dataclass(frozen=True, slots=True)
class Tint:
    """One meaning's colours as #rrggbb: ``ink`` for text, icons and lines on a surface; ``fill`` with
    ``on_fill`` upon it for what is loud; ``wash`` is a quiet background for text in ``ink``."""

    ink: str
    fill: str
    on_fill: str
    wash: str


@dataclass(frozen=True, slots=True)
class Theme:
    """One appearance.  Colours are #rrggbb, ``line_px`` is the width of curves and limits.

    ``window`` is behind everything, ``surface`` is a card or a field, ``sunken`` a bar or a header,
    ``raised`` what lies under the pointer.  ``border`` bounds a control, ``divider`` only parts two areas.
    """

    name: str
    is_dark: bool
    window: str
    surface: str
    sunken: str
    raised: str
    text: str
    muted: str
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
    def surfaces(self) -> tuple[str, str, str, str]:
        """Everything that text may stand on."""
        return (self.window, self.surface, self.sunken, self.raised)

    @property
    def danger(self) -> Tint:
        """What can fire, and what went wrong."""
        return self.meanings[Meaning.DANGER]

    @property
    def attention(self) -> Tint:
        """What needs a second look."""
        return self.meanings[Meaning.ATTENTION]

    @property
    def information(self) -> Tint:
        """What is chosen, focused or linked."""
        return self.meanings[Meaning.INFORMATION]

    def tint(self, meaning: Meaning) -> Tint:
        """The colours of a meaning."""
        return self.meanings[meaning]

    def ink(self, meaning: Meaning | None) -> QColor:
        """The colour of text, icon or line; None is plain text."""
        return QColor(self.text if meaning is None else self.meanings[meaning].ink)


# The curves are Okabe and Ito's blue, bluish green and reddish purple, made darker or lighter until they have
# the contrast; their vermilion is left out, because beside it the red of danger would say nothing.
LIGHT: Final = Theme(
    name="light",
    is_dark=False,
    window="#F4F5F7",
    surface="#FFFFFF",
    sunken="#EBEDF0",
    raised="#F4F5F7",
    text="#15181C",
    muted="#565E69",
    border="#7F8792",
    divider="#DCDFE4",
    selection="#DCE7F6",
    primary="#22272E",
    on_primary="#FFFFFF",
    curves=("#0072B2", "#00805C", "#A14B7D"),
    meanings=MappingProxyType(
        {
            Meaning.GOOD: Tint("#1B7449", "#1B7449", "#FFFFFF", "#E6F4EC"),
            Meaning.ATTENTION: Tint("#855200", "#F3B434", "#1F1600", "#FDF3DC"),
            Meaning.DANGER: Tint("#BE2A2A", "#C42B2B", "#FFFFFF", "#FCEBEA"),
            Meaning.INFORMATION: Tint("#1B5FB5", "#1B5FB5", "#FFFFFF", "#E8F0FB"),
            Meaning.UNKNOWN: Tint("#565E69", "#565E69", "#FFFFFF", "#EBEDF0"),
        }
    ),
    line_px=1,
    border_px=1,
)
DARK: Final = Theme(
    name="dark",
    is_dark=True,
    window="#121519",
    surface="#1A1E23",
    sunken="#0D0F12",
    raised="#242A31",
    text="#E9ECEF",
    muted="#A3ABB6",
    border="#737D8A",
    divider="#2B3138",
    selection="#23405F",
    primary="#E9ECEF",
    on_primary="#15181C",
    curves=("#56B4E9", "#2FC69B", "#E08FBC"),
    meanings=MappingProxyType(
        {
            Meaning.GOOD: Tint("#4FC48C", "#4FC48C", "#04150D", "#15301F"),
            Meaning.ATTENTION: Tint("#F0B441", "#F0B441", "#1F1600", "#33290F"),
            Meaning.DANGER: Tint("#FF7B75", "#CF3439", "#FFFFFF", "#3A1D1E"),
            Meaning.INFORMATION: Tint("#74B3FA", "#74B3FA", "#04121F", "#15283E"),
            Meaning.UNKNOWN: Tint("#A3ABB6", "#A3ABB6", "#121519", "#242A31"),
        }
    ),
    line_px=1,
    border_px=1,
)
SUNLIGHT: Final = Theme(
    name="sunlight",
    is_dark=False,
    window="#FFFFFF",
    surface="#FFFFFF",
    sunken="#F1F1F1",
    raised="#F1F1F1",
    text="#000000",
    muted="#333333",
    border="#000000",
    divider="#000000",
    selection="#FFE48A",
    primary="#000000",
    on_primary="#FFFFFF",
    curves=("#004A77", "#00543C", "#70244F"),
    meanings=MappingProxyType(
        {
            Meaning.GOOD: Tint("#00502C", "#00502C", "#FFFFFF", "#E2F5EA"),
            Meaning.ATTENTION: Tint("#5C3A00", "#FFCB00", "#000000", "#FFF1C9"),
            Meaning.DANGER: Tint("#960000", "#960000", "#FFFFFF", "#FFE9E7"),
            Meaning.INFORMATION: Tint("#003C8A", "#003C8A", "#FFFFFF", "#E4EEFC"),
            Meaning.UNKNOWN: Tint("#000000", "#000000", "#FFFFFF", "#FFFFFF"),
        }
    ),
    line_px=2,
    border_px=2,
)
THEMES: Final = (LIGHT, DARK, SUNLIGHT)
_BY_CHOICE: Final = {Choice.LIGHT: LIGHT, Choice.DARK: DARK, Choice.SUNLIGHT: SUNLIGHT}
# Simplified Chinese shapes, best first; the system's own font stays the first of all.
_CHINESE_FAMILIES: Final = (
    "PingFang SC",
    "Microsoft YaHei UI",
    "Microsoft YaHei",
    "Noto Sans CJK SC",
    "Noto Sans SC",
    "Source Han Sans SC",
    "WenQuanYi Micro Hei",
)

_in_use: Theme = LIGHT


def current() -> Theme:
    """The theme in use.  What paints itself asks at every paint and so follows a change."""
    return _in_use


def font(size: Size = Size.BODY, *, is_bold: bool = False) -> QFont:
    """The application's font with figures of one width, in one of the five sizes.

    Bold is a calm medium where the font has one, and truly bold in sunlight.
    """
    one = QFont(QApplication.font())
    one.setPixelSize(size)
    strong = QFont.Weight.Medium if _in_use.line_px == 1 else QFont.Weight.Bold
    one.setWeight(strong if is_bold else QFont.Weight.Normal)
    return one


def apply(app: QApplication, theme: Theme, window: QWidget | None = None) -> None:
    """Dress the whole application: style, palette, font, style sheet.

    `window` wears the sheet, and all that is in it or belongs to it, in place of the application: with a sheet of the
    application's, Qt dresses each widget again at every step into a layout, which doubles the time that a page takes.
    """
    global _in_use  # noqa: PLW0603  one reference, like the language: every painter asks for it
    _in_use = theme
    if app.style().name() != "fusion":
        app.setStyle("Fusion")
    app.setFont(_base_font())
    app.setPalette(palette(theme))
    (app if window is None else window).setStyleSheet(style_sheet(theme))


def palette(theme: Theme) -> QPalette:
    """Qt's roles from the theme."""
    role = QPalette.ColorRole
    colours = {
        role.Window: theme.window,
        role.WindowText: theme.text,
        role.Base: theme.surface,
        role.AlternateBase: theme.window,
        role.Text: theme.text,
        role.Button: theme.surface,
        role.ButtonText: theme.text,
        role.BrightText: theme.text,
        role.ToolTipBase: theme.text,
        role.ToolTipText: theme.window,
        role.PlaceholderText: theme.muted,
        role.Highlight: theme.selection,
        role.HighlightedText: theme.text,
        role.Accent: theme.information.ink,
        role.Link: theme.information.ink,
        role.LinkVisited: theme.information.ink,
        role.Light: theme.surface,
        role.Midlight: theme.sunken,
        role.Mid: theme.divider,
        role.Dark: theme.border,
        role.Shadow: theme.border,
    }
    one = QPalette()
    for colour_role, colour in colours.items():
        one.setColor(colour_role, QColor(colour))
    for colour_role in (role.WindowText, role.Text, role.ButtonText):
        one.setColor(QPalette.ColorGroup.Disabled, colour_role, QColor(theme.muted))
    return one


def _base_font() -> QFont:
    """The system's font with Chinese to fall back on, and figures of one width where the font has them."""
    system = QFontDatabase.systemFont(QFontDatabase.SystemFont.GeneralFont)
    present = set(QFontDatabase.families())
    # The family's real name: beside a name that exists, an alias such as "Sans Serif" would be passed over.
    families = [QFontInfo(system).family(), *(name for name in _CHINESE_FAMILIES if name in present)]
    one = QFont(families)
    one.setPixelSize(Size.BODY)
    one.setFeature(QFont.Tag("tnum"), 1)
    return one


def is_system_dark(app: QApplication) -> bool:
    """The system's colours are light on dark; a system that does not say so is light."""
    return app.styleHints().colorScheme() is Qt.ColorScheme.Dark


class Appearance(QObject):
    """Keeps the application dressed as chosen, and follows the system while the choice is AUTO."""

    changed = Signal()
    """The theme in use is another one; ``current()`` gives it."""

    def __init__(self, app: QApplication, choice: Choice = Choice.AUTO) -> None:
        super().__init__(app)
        self._app = app
        self._choice = choice
        self._window: QWidget | None = None
        app.styleHints().colorSchemeChanged.connect(self._follow)
        self._apply()

    @property
    def choice(self) -> Choice:
        """What was chosen, which is not always what is in use."""
        return self._choice

    def apply_theme(self, window: QWidget) -> None:
        """Let `window` wear the style sheet in place of the application; see `apply`. It ends with the window."""
        self.setParent(window)
        self._window = window
        self._app.setStyleSheet("")
        window.setStyleSheet(style_sheet(self._applied))

    def choose(self, choice: Choice) -> None:
        """Dress the window again, if that changes anything."""
        if choice is not self._choice:
            self._choice = choice
            self._apply()

    def _follow(self) -> None:
        if self._choice is Choice.AUTO and self._wanted() is not self._applied:
            self._apply()

    def _wanted(self) -> Theme:
        if self._choice is not Choice.AUTO:
            return _BY_CHOICE[self._choice]
        return DARK if is_system_dark(self._app) else LIGHT

    def _apply(self) -> None:
        self._applied = self._wanted()
        window = self._window if self._window is not None and isValid(self._window) else None
        apply(self._app, self._applied, window)
        self.changed.emit()


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
