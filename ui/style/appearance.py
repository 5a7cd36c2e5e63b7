"""Applies a theme to the application: style, palette, font and style sheet; follows the system's colour scheme."""

from typing import Final

from PySide6.QtCore import QObject, Qt, Signal
from PySide6.QtGui import QColor, QFont, QFontDatabase, QFontInfo, QPalette
from PySide6.QtWidgets import QApplication, QWidget
from shiboken6 import isValid

from ui.style.style_sheet import style_sheet
from ui.style.theme import DARK, LIGHT, SUNLIGHT, Choice, Size, Theme, use

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


def apply(app: QApplication, theme: Theme, window: QWidget | None = None) -> None:
    """Dress the whole application: style, palette, font, style sheet.

    `window` wears the sheet, and all that is in it or belongs to it, in place of the application: with a sheet of the
    application's, Qt dresses each widget again at every step into a layout, which doubles the time that a page takes.
    """
    use(theme)
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
