"""Applies a theme to the application: style, palette, font and style sheet; follows the system's colour scheme."""

import re
from functools import cache, partial
from pathlib import Path
from string import Template
from typing import Final

from PySide6.QtCore import QChildEvent, QEvent, QObject, Qt, Signal
from PySide6.QtGui import QColor, QFont, QFontDatabase, QFontInfo, QPalette, QShowEvent
from PySide6.QtWidgets import QApplication, QWidget
from shiboken6 import isValid

from ui.style.icons import FILES
from ui.style.theme import DARK, LIGHT, SUNLIGHT, Choice, Meaning, Size, Theme, kept_font, scale_in_use, scaled, use

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

_STYLED_THEME: Final = "theme"
"""Property of a part of a window: the name of the theme whose style sheet it has."""
_SHEET: Final = Path(__file__).parent / "style.qss"
_SCALED: Final = re.compile(r"\b(?:font-size|padding|min-height|min-width|width|height|spacing): [^;]+;")
_PX: Final = re.compile(r"(\d+)px")


def style_sheet(theme: Theme) -> str:
    grown_px = 2 - theme.border_px
    sheet = _template().substitute(
        theme._asdict(),
        disabled_edge=theme.divider if theme.border_px == 1 else theme.disabled,
        primary_hover=theme.muted if not theme.is_dark else theme.text,
        focus=theme.information.ink,
        chosen=theme.sunken if theme.border_px == 1 else theme.selection,  # a light grey is invisible in sunlight
        danger_ink=theme.danger.ink,
        danger_fill=theme.danger.fill,
        on_danger=theme.danger.on_fill,
        danger_wash=theme.danger.wash,
        good_ink=theme.tint(Meaning.GOOD).ink,
        good_fill=theme.tint(Meaning.GOOD).fill,
        on_good=theme.tint(Meaning.GOOD).on_fill,
        information_fill=theme.information.fill,
        on_information=theme.information.on_fill,
        rehearsal=theme.information.wash,
        attention_ink=theme.attention.ink,
        attention_fill=theme.attention.fill,
        attention_wash=theme.attention.wash,
        on_attention=theme.attention.on_fill,
        calm="normal" if theme.line_px == 1 else 700,
        edge=theme.border_px,
        # A style sheet takes pictures from files only, so the arrows and check marks of each theme are files.
        check=(FILES / f"{theme.name}-check.svg").as_posix(),
        arrow_up=(FILES / f"{theme.name}-up.svg").as_posix(),
        arrow_down=(FILES / f"{theme.name}-down.svg").as_posix(),
        focus_v=4 - grown_px,
        focus_h=12 - grown_px,
        focus_s=4 - grown_px,
        field_v=3 - grown_px,
        field_h=8 - grown_px,
    )
    scale = scale_in_use()
    if scale != 1:
        sheet = _SCALED.sub(partial(_times, scale), sheet)
    return sheet.replace("@tool", f"{round(22 * scale) - 3}px")


@cache
def _template() -> Template:
    return Template(_SHEET.read_text(encoding="utf-8"))


def _times(scale: float, match: re.Match[str]) -> str:
    return _PX.sub(lambda px: f"{round(int(px[1]) * scale)}px", match[0])


def apply(app: QApplication, theme: Theme) -> None:
    use(theme)
    if app.style().name() != "fusion":
        app.setStyle("Fusion")
    app.setFont(_base_font())
    kept_font.cache_clear()
    app.setPalette(palette(theme))


def palette(theme: Theme) -> QPalette:
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
    themed = QPalette()
    for colour_role, colour in colours.items():
        themed.setColor(colour_role, QColor(colour))
    for colour_role in (role.WindowText, role.Text, role.ButtonText):
        themed.setColor(QPalette.ColorGroup.Disabled, colour_role, QColor(theme.disabled))
    return themed


def _base_font() -> QFont:
    """The system's font with Chinese to fall back on, and figures of one width where the font has them."""
    system = QFontDatabase.systemFont(QFontDatabase.SystemFont.GeneralFont)
    present = set(QFontDatabase.families())
    # The family's real name: beside a name that exists, an alias such as "Sans Serif" would be passed over.
    families = [QFontInfo(system).family(), *(name for name in _CHINESE_FAMILIES if name in present)]
    base = QFont(families)
    base.setPixelSize(scaled(Size.BODY))
    base.setFeature(QFont.Tag("tnum"), 1)
    return base


def is_system_dark(app: QApplication) -> bool:
    """The system's colours are light on dark; a system that does not say so is light."""
    return app.styleHints().colorScheme() is Qt.ColorScheme.Dark


class Appearance(QObject):
    """Applies the chosen theme, and follows the system while the choice is AUTO.

    Each part of a window has the style sheet for itself, and a page out of sight follows a change when it is shown,
    before it is painted. Set on the application it would cost a change 1.3 s of CPU instead of 0.1 s, as Qt polishes
    every widget, and the start a quarter more.
    """

    changed = Signal()
    """The theme in use is another one; ``current()`` gives it."""

    def __init__(self, app: QApplication, choice: Choice = Choice.AUTO) -> None:
        super().__init__(app)
        self._app = app
        self._choice = choice
        self._holders: tuple[QWidget, ...] = ()
        app.styleHints().colorSchemeChanged.connect(self._on_system_changed)
        self._apply()

    @property
    def choice(self) -> Choice:
        """What was chosen, which is not always what is in use."""
        return self._choice

    def apply_theme(self, window: QWidget, *holders: QWidget) -> None:
        """Set the style sheet on the parts of `window`: all that lies directly in it or in one of its `holders`, which
        have nothing to show of their own; the last one holds the pages. It ends with the window."""
        self.setParent(window)
        self._holders = (window, *holders)
        for holder in self._holders:
            holder.installEventFilter(self)
        for part in self._parts():
            self.apply_to(part)

    def apply_to(self, part: QWidget) -> None:
        """Set the style sheet of the theme in use on a part. By itself that happens when it is first shown: too late
        for one that is measured before."""
        if part.property(_STYLED_THEME) != self._applied.name:
            if part.property(_STYLED_THEME) is None:
                part.installEventFilter(self)
            part.setProperty(_STYLED_THEME, self._applied.name)
            part.setStyleSheet(self._sheet)

    def _parts(self) -> list[QWidget]:
        only_direct = Qt.FindChildOption.FindDirectChildrenOnly
        children = (holder.findChildren(QWidget, options=only_direct) for holder in self._holders if isValid(holder))
        return [part for parts in children for part in parts if part not in self._holders]

    def choose(self, choice: Choice) -> None:
        """Apply it, if that changes anything."""
        if choice is not self._choice:
            self._choice = choice
            self._apply()

    def _on_system_changed(self) -> None:
        if self._choice is Choice.AUTO and self._chosen_theme() is not self._applied:
            self._apply()

    def _chosen_theme(self) -> Theme:
        if self._choice is not Choice.AUTO:
            return _BY_CHOICE[self._choice]
        return DARK if is_system_dark(self._app) else LIGHT

    def _apply(self) -> None:
        self._applied = self._chosen_theme()
        apply(self._app, self._applied)
        self._sheet = style_sheet(self._applied)
        for part in self._parts():
            if part.isVisible() or part.parentWidget() is not self._holders[-1]:
                self.apply_to(part)
        self.changed.emit()

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """A part that came later is styled before it is first shown, one out of sight when it is shown again."""
        # By class, as `type()` would make an enumeration's member of every event.
        if isinstance(event, QShowEvent):
            if isinstance(watched, QWidget) and watched not in self._holders:
                self.apply_to(watched)
        elif isinstance(event, QChildEvent) and event.type() == QEvent.Type.ChildPolished:
            part = event.child()
            if watched in self._holders and isinstance(part, QWidget) and part not in self._holders:
                self.apply_to(part)
        return False
