"""Themes applied to the application, and the roles and names that screen readers are told.

Qt gives a widget of our own the role of a container, which screen readers skip. Here it has the role that its class
names in `accessible_role`; a container with a name is a group.

The name is asked for when somebody wants to know it, so it may hold a measured value or an age. A change of it is told
only where Qt's own property changes: see `Spoken`.
"""

import re
from functools import cache
from pathlib import Path
from string import Template
from typing import Final, cast

from PySide6.QtCore import QObject, Qt, Signal
from PySide6.QtGui import (
    QAccessible,
    QAccessibleAnnouncementEvent,
    QAccessibleInterface,
    QColor,
    QFont,
    QFontDatabase,
    QFontInfo,
    QPalette,
)
from PySide6.QtWidgets import QAccessibleWidget, QApplication, QFrame, QScrollArea, QWidget

from ui.style.icons import FILES
from ui.style.theme import DARK, LIGHT, SUNLIGHT, Choice, Size, Theme, current, kept_font, scale_in_use, scaled, use

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

_SHEET: Final = Path(__file__).parent / "style.qss"
_SCALED: Final = re.compile(r"\b(?:font-size|padding|min-height|min-width|width|height|spacing): [^;]+;")
_PX: Final = re.compile(r"(\d+)px")


def style_sheet(theme: Theme) -> str:
    grown_px = 2 - theme.border_px  # by which a border grows with the focus
    tints = {
        f"{meaning.value}_{part}": colour
        for meaning, tint in theme.meanings.items()
        for part, colour in tint._asdict().items()
    }
    sheet = Template(_SHEET.read_text(encoding="utf-8")).substitute(
        theme._asdict() | tints,
        disabled_edge=theme.divider if theme.border_px == 1 else theme.disabled,
        primary_hover=theme.muted if not theme.is_dark else theme.text,
        focus=theme.information.ink,
        chosen=theme.sunken if theme.border_px == 1 else theme.selection,  # a light grey is invisible in sunlight
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

    def grow(lengths: re.Match[str]) -> str:
        return _PX.sub(lambda px: f"{round(int(px[1]) * scale)}px", lengths[0])

    return _SCALED.sub(grow, sheet).replace("@tool", f"{round(22 * scale) - 3}px")


def apply(app: QApplication, theme: Theme) -> None:
    use(theme)
    # The system's font with Chinese to fall back on, and figures of one width where the font has them.
    system = QFontDatabase.systemFont(QFontDatabase.SystemFont.GeneralFont)
    present = set(QFontDatabase.families())
    # The family's real name: beside a name that exists, an alias such as "Sans Serif" would be passed over.
    base = QFont([QFontInfo(system).family(), *(name for name in _CHINESE_FAMILIES if name in present)])
    base.setPixelSize(scaled(Size.BODY))
    base.setFeature(QFont.Tag("tnum"), 1)
    app.setFont(base)
    kept_font.cache_clear()
    role, themed = QPalette.ColorRole, QPalette()
    text = (role.WindowText, role.Text, role.ButtonText)
    colours = (
        (theme.window, (role.Window, role.AlternateBase, role.ToolTipText)),
        (theme.surface, (role.Base, role.Button, role.Light)),
        (theme.text, (*text, role.BrightText, role.ToolTipBase, role.HighlightedText)),
        (theme.muted, (role.PlaceholderText,)),
        (theme.selection, (role.Highlight,)),
        (theme.information.ink, (role.Accent, role.Link, role.LinkVisited)),
        (theme.sunken, (role.Midlight,)),
        (theme.divider, (role.Mid,)),
        (theme.border, (role.Dark, role.Shadow)),
    )
    for colour, roles in colours:
        for one in roles:
            themed.setColor(one, QColor(colour))
    for one in text:
        themed.setColor(QPalette.ColorGroup.Disabled, one, QColor(theme.disabled))
    app.setPalette(themed)


def is_system_dark(app: QApplication) -> bool:
    """The system's colours are light on dark; a system that does not say so is light."""
    return app.styleHints().colorScheme() is Qt.ColorScheme.Dark


class Appearance(QObject):
    """Applies the chosen theme, and follows the system while the choice is AUTO."""

    changed = Signal()  # The theme in use is another one; ``current()`` gives it

    def __init__(self, app: QApplication, choice: Choice = Choice.AUTO) -> None:
        super().__init__(app)
        self._app = app
        # What was chosen, which is not always what is in use.
        self.choice = choice
        self._window: QWidget | None = None
        app.styleHints().colorSchemeChanged.connect(self._follow)
        self._apply()

    def style(self, window: QWidget) -> None:
        """Set the style sheet of the theme in use on `window`, now and at each change. It ends with the window.

        A change of the application's own sheet would take five times as long.
        """
        self.setParent(window)
        self._window = window
        window.setStyleSheet(style_sheet(current()))

    def choose(self, choice: Choice) -> None:
        """Apply it, if that changes anything."""
        if choice is not self.choice:
            self.choice = choice
            self._apply()

    def _follow(self) -> None:
        if self._wanted is not current():
            self._apply()

    @property
    def _wanted(self) -> Theme:
        if self.choice is not Choice.AUTO:
            return _BY_CHOICE[self.choice]
        return DARK if is_system_dark(self._app) else LIGHT

    def _apply(self) -> None:
        apply(self._app, self._wanted)
        if self._window is not None:
            self._window.setStyleSheet(style_sheet(current()))
        self.changed.emit()


# Screen readers


_CONTAINERS: Final = (QWidget, QFrame, QScrollArea)  # What Qt's own role says nothing of


class _Accessible(QAccessibleWidget):
    def text(self, kind: QAccessible.Text) -> str:
        widget: QWidget | None = self.widget()
        name = widget.accessibleName() if kind is QAccessible.Text.Name and widget is not None else ""
        return name or super().text(kind)


class _Leaf(_Accessible):
    """A picture or a value: its parts are nothing of their own."""

    def childCount(self) -> int:
        return 0


class _Container(_Accessible):
    """A group as soon as it has a name. What is scrolled is a section: of a group all labels are read at once."""

    def role(self) -> QAccessible.Role:
        if isinstance(self.widget(), QScrollArea):
            return QAccessible.Role.Section
        return QAccessible.Role.Grouping if self.text(QAccessible.Text.Name) else QAccessible.Role.Client


def _make(class_name: str, widget: QObject) -> QAccessibleInterface | None:
    """Called by Qt for the class of `widget` and all those above it, until it gets an answer."""
    if not isinstance(widget, QWidget) or type(widget).__name__ != class_name:
        return None
    role: QAccessible.Role | None = getattr(widget, "accessible_role", None)
    if role is not None:
        return (_Accessible if role is QAccessible.Role.Section else _Leaf)(widget, role)
    of_qt = next(kind for kind in type(widget).__mro__ if kind.__module__.startswith("PySide6."))
    return _Container(widget) if of_qt in _CONTAINERS else None


class Spoken:
    """A part of a widget's class: what it says may tick or be measured."""

    _spoken = ""

    def say(self, text: str, *, name: str = "") -> None:
        """Lets screen readers say `text`. `name` is the part of it that neither ticks nor is measured: they learn at
        once when that changes, of the rest when they ask."""
        self._spoken = text
        widget = cast("QWidget", self)
        if QWidget.accessibleName(widget) != (name or text):
            widget.setAccessibleName(name or text)

    def accessibleName(self) -> str:
        """Whole, as a screen reader gets it."""
        return self._spoken or QWidget.accessibleName(cast("QWidget", self))


@cache
def install_accessible_roles() -> None:
    """Install the roles once for the application, before anybody asks."""
    QAccessible.installFactory(_make)


_POLITENESS = QAccessible.AnnouncementPoliteness


def announce(text: str, *, is_urgent: bool = False) -> None:
    """Announce an event, not a value that changes all the time. `text` is in the language in use. `is_urgent`: it
    interrupts what is being read."""
    visible = (window for window in QApplication.topLevelWidgets() if window.isVisible())
    speaker = QApplication.activeWindow() or next(visible, None)
    if text and speaker is not None:
        event = QAccessibleAnnouncementEvent(speaker, text)
        event.setPoliteness(_POLITENESS.Assertive if is_urgent else _POLITENESS.Polite)
        QAccessible.updateAccessibility(event)
