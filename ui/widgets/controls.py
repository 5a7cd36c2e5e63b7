"""Controls, labels and layouts made in one call, and what they look like."""

from collections.abc import Callable
from typing import ClassVar, Final, TypeVar

from PySide6.QtCore import QEvent, QObject, QRect, Qt
from PySide6.QtGui import QAccessible, QColor, QFocusEvent, QFontMetrics, QKeySequence, QPainter, QPaintEvent, QShortcut
from PySide6.QtWidgets import (
    QAbstractButton,
    QBoxLayout,
    QGridLayout,
    QHBoxLayout,
    QLabel,
    QLayout,
    QScrollArea,
    QSizePolicy,
    QStackedLayout,
    QStackedWidget,
    QTabWidget,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from app.text.messages import in_brackets
from ui.style.icons import Icon, icon, pixmap, set_icon_size
from ui.style.theme import IconSize, Meaning, Space, current, is_text_large, scaled
from ui.widgets.step_button import StepButton

Named = TypeVar("Named", bound=QObject)
Button = TypeVar("Button", bound=QAbstractButton)
Box = TypeVar("Box", bound=QBoxLayout)
Stack = TypeVar("Stack", QStackedLayout, QStackedWidget)
# A number is a stretch; a pair is a widget or layout with its stretch, or a widget with its alignment.
Item = QWidget | QLayout | int | tuple[QWidget | QLayout, int] | tuple[QWidget, Qt.AlignmentFlag]
# One for all sides, (horizontal, vertical), or (left, top, right, bottom).
Margins = int | tuple[int, int] | tuple[int, int, int, int]
SELECTABLE: Final = Qt.TextInteractionFlag.TextSelectableByMouse | Qt.TextInteractionFlag.TextSelectableByKeyboard
_REDRAWN_AT: Final = (QEvent.Type.PaletteChange, QEvent.Type.StyleChange, QEvent.Type.DevicePixelRatioChange)


def named(widget: Named, name: str, role: str = "", *, says: str = "", tip: str = "") -> Named:
    """Sets the object name of `widget` and its role in the style sheet; returns it. `says`: what screen readers call a
    field, a list or a table, and `tip` its tooltip, in the language in use."""
    widget.setObjectName(name)
    if role:
        widget.setProperty("role", role)
    if isinstance(widget, QWidget):
        if says:
            widget.setAccessibleName(says)
        if tip:
            widget.setToolTip(tip)
    return widget


def set_role(widget: QWidget, role: str) -> None:
    """Changes the role of `widget` in the style sheet, and the colour of a button's picture with it."""
    if (widget.property("role") or "") != role:
        widget.setProperty("role", role)
        picture = widget.property("picture")
        if isinstance(widget, QAbstractButton) and picture is not None:
            widget.setIcon(icon(picture, is_on_primary=role == "primary"))
        _polish(widget)


def set_look(look: str, *widgets: QWidget) -> None:
    """Changes what the style sheet makes of a value or a state: "danger", "stale", …; "" is plain."""
    for widget in widgets:
        if (widget.property("look") or "") != look:
            widget.setProperty("look", look)
            _polish(widget)


def _polish(widget: QWidget) -> None:
    """Has it drawn again by the style sheet; what was not drawn by it yet will be."""
    if widget.testAttribute(Qt.WidgetAttribute.WA_StyleSheet):
        widget.style().polish(widget)


def control(
    button: Button,
    name: str,
    *,
    text: str = "",
    says: str = "",
    tip: str = "",
    key: str = "",
    keys: str = "",
    picture: Icon | None = None,
    role: str = "",
    slot: object = None,
) -> Button:
    """Sets up a button and returns it. All texts are in the language in use.

    `text` is for a tool button, whose constructor takes none. `says` is the accessible name; a button with a text has
    that text as its name, which is what users of voice control say, and `says` describes it. `tip` is needed only where
    it adds something. `keys`, such as "F5; Ctrl+R" press it; the tooltip names the first, or a `key` that something
    else handles. `slot` is called at a click, or when the press of a `StepButton` counted.
    """
    text = text or button.text()
    named(button, name, role)
    button.setText(text)
    if text:
        button.setAccessibleDescription(says)
    else:
        button.setAccessibleName(says)
        tip = tip or says
    if picture is not None:
        button.setProperty("picture", picture)
        button.setIcon(icon(picture, is_on_primary=role == "primary"))
        set_icon_size(button, IconSize.TEXT)
        if text and isinstance(button, QToolButton):
            button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
    if slot is not None:
        (button.chosen if isinstance(button, StepButton) else button.clicked).connect(slot)
    button.setToolTip(tip)
    if keys:
        Shortcut(button, keys)
        key = keys.partition(";")[0]
    if key:
        name_key(button, key)
    return button


def name_key(widget: QWidget, key: str) -> None:
    """Says in its tooltip which key presses it."""
    text = widget.text() if isinstance(widget, QAbstractButton) else ""
    widget.setProperty("key", key)
    widget.setToolTip((widget.toolTip() or text or widget.accessibleName()) + in_brackets(key))


def without_key(text: str) -> str:
    """Return it for a button or an action, which takes "&" for the mark of a key."""
    return text.replace("&", "&&")


class Shortcut(QShortcut):
    """Clicks a control that is in sight and enabled, or gives a field the focus, by its keys; or calls `slot` while
    `holder` is in sight."""

    def __init__(
        self, of: QWidget, keys: str, slot: Callable[[], object] | None = None, *, holder: QWidget | None = None
    ) -> None:
        super().__init__(holder or of)
        self.setObjectName(f"{of.objectName()}_key")
        self.control, self._slot = of, slot
        self.setAutoRepeat(False)  # the next step needs another press
        self.setKeys(QKeySequence.listFromString(keys))
        self.activated.connect(self._press)

    def _press(self) -> None:
        if not self.control.isEnabled():
            return
        if self._slot is not None:
            self._slot()
        elif isinstance(self.control, QAbstractButton):
            self.control.click()
        else:
            self.control.setFocus(Qt.FocusReason.ShortcutFocusReason)


# Layouts


def in_row(
    *items: Item, of: QWidget | None = None, spacing: int | None = None, margins: Margins | None = None
) -> QHBoxLayout:
    """`items` from left to right, as the layout `of` that widget. Spacing and margins default to the style's."""
    return _filled(QHBoxLayout(), items, of, spacing, margins)


def in_column(
    *items: Item, of: QWidget | None = None, spacing: int | None = None, margins: Margins | None = None
) -> QVBoxLayout:
    """Like `in_row`, from top to bottom."""
    return _filled(QVBoxLayout(), items, of, spacing, margins)


def _filled(
    layout: Box, items: tuple[Item, ...], of: QWidget | None, spacing: int | None, margins: Margins | None
) -> Box:
    if of is not None:
        of.setLayout(layout)
    if margins is not None:
        sides = (margins, margins) if isinstance(margins, int) else margins
        layout.setContentsMargins(*sides, *sides) if len(sides) == 2 else layout.setContentsMargins(*sides)
    if spacing is not None:
        layout.setSpacing(spacing)
    for item in items:
        match item:
            case int():
                layout.addStretch(item)
            case QWidget():
                layout.addWidget(item)
            case QLayout():
                layout.addLayout(item)
            case (QLayout() as inner, int() as share):
                layout.addLayout(inner, share)
            case (QWidget() as widget, Qt.AlignmentFlag() as side):
                layout.addWidget(widget, 0, side)
            case (QWidget() as widget, int() as share):
                layout.addWidget(widget, share)
    return layout


def stacked(stack: Stack, *views: QWidget) -> Stack:
    """Adds `views` to `stack`, which shows the first; returns it."""
    for view in views:
        stack.addWidget(view)
    return stack


def tabbed(page: str, says: str) -> QTabWidget:
    """Views of a page, chosen by tabs; `says` is the accessible name of these."""
    tabs = named(QTabWidget(), f"{page}_views")
    tabs.setDocumentMode(True)
    tabs.setFocusPolicy(Qt.FocusPolicy.NoFocus)  # also of the bar, to which it passes the focus
    tabs.setUsesScrollButtons(False)
    named(tabs.tabBar(), f"{page}_tabs", says=says).setFocusPolicy(Qt.FocusPolicy.TabFocus)
    return tabs


def captioned_row(*fields: tuple[str, QWidget]) -> QGridLayout:
    """Fields of equal width, each below its caption; large text has room for two in a row."""
    grid = QGridLayout()
    grid.setContentsMargins(0, 0, 0, 0)
    columns = 2 if is_text_large() else len(fields)
    for number, (caption, field) in enumerate(fields):
        label = named(QLabel(caption), f"{field.objectName()}_caption", "small")
        label.setBuddy(field)
        row, column = 2 * (number // columns), number % columns
        grid.addWidget(label, row, column)
        grid.addWidget(field, row + 1, column)
        grid.setColumnStretch(column, 1)
    return grid


class ScrollArea(QScrollArea):
    """Takes what room remains. Takes the focus only while it scrolls, and shows it by its bars."""

    def __init__(self) -> None:
        super().__init__()
        self.setWidgetResizable(True)
        # Qt would ask for up to 24 lines, so that the page around it would scroll, too.
        self.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Ignored)
        self.setMinimumSize(1, scaled(60))
        self._bars = (self.verticalScrollBar(), self.horizontalScrollBar())
        for bar in self._bars:
            bar.rangeChanged.connect(self._offer_focus)
        self._offer_focus()

    def _offer_focus(self) -> None:
        scrolls = any(bar.maximum() > bar.minimum() for bar in self._bars)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus if scrolls else Qt.FocusPolicy.NoFocus)

    def event(self, event: QEvent) -> bool:
        if isinstance(event, QFocusEvent):
            for bar in self._bars:
                set_role(bar, "focus" if event.gotFocus() else "")
        return super().event(event)


def scroll_area(content: QWidget, name: str, says: str, *, is_vertical: bool = False) -> ScrollArea:
    """Scrolls `content`, never sideways where it `is_vertical`; `says` is its accessible name."""
    area = named(ScrollArea(), name, says=says)
    area.setWidget(content)
    if is_vertical:
        area.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
    return area


def retain_size(widget: QWidget, *, is_kept: bool = True) -> None:
    """Keeps the room of `widget` in its layout while it is hidden."""
    policy = widget.sizePolicy()
    policy.setRetainSizeWhenHidden(is_kept)
    widget.setSizePolicy(policy)


# Labels


def text_label(name: str, role: str = "", text: str = "", *, is_selectable: bool = False) -> QLabel:
    """A label that wraps; `role` is one of the style sheet's."""
    label = named(QLabel(text), name, role)
    label.setWordWrap(True)
    if is_selectable:
        label.setTextInteractionFlags(SELECTABLE)
    return label


class ElidedLabel(QLabel):
    """Plain text that ends in "…" where it has no room, and is then whole in the tooltip. `text()` is always whole.

    It is one line; with word wrap it takes the height that the layout gives.
    """

    def __init__(self) -> None:
        super().__init__()
        self.setMinimumWidth(1)  # less than its text

    def paintEvent(self, _event: QPaintEvent) -> None:
        metrics, room, text = QFontMetrics(self.font()), self.contentsRect(), self.text()
        if self.wordWrap():
            wide, wrap = QRect(0, 0, room.width(), 0), Qt.TextFlag.TextWordWrap.value

            def fits(part: str) -> bool:
                """Whether it is neither too high nor, as a long word is, too wide."""
                needed = metrics.boundingRect(wide, wrap, part)
                return needed.height() <= room.height() and needed.width() <= room.width()

            shown, end = text, len(text)
            while end and not fits(shown):
                end -= 1
                shown = f"{text[:end].rstrip()}…"
        else:
            wrap, shown = 0, metrics.elidedText(text, Qt.TextElideMode.ElideRight, room.width())
        self.setToolTip("" if shown == text else text)
        painter = QPainter(self)
        painter.setPen(self.palette().color(self.foregroundRole()))
        painter.drawText(room, self.alignment().value | wrap, shown)
        painter.end()


class TickingLabel(QLabel):
    """A figure or an age that changes all the time. Its accessible name says what it is; screen readers get the text
    when they ask, and no event for each change."""

    accessible_role: ClassVar = QAccessible.Role.StaticText

    def accessibleName(self) -> str:
        """The whole text, as screen readers get it."""
        subject = super().accessibleName()
        return f"{subject}: {self.text()}" if self.text() else subject


class IconLabel(QLabel):
    """An icon beside a text, `size_px` at the usual size of text; empty at first, and then as large if it
    `keeps_place`."""

    def __init__(self, name: str, size_px: int, *, keeps_place: bool = False) -> None:
        self._size_px = scaled(size_px)
        self._shown: tuple[Icon, Meaning | None, bool, bool] | None = None
        super().__init__()
        named(self, name)
        if keeps_place:
            self.setFixedSize(self._size_px, self._size_px)

    def show_icon(
        self, picture: Icon, meaning: Meaning | None = None, *, is_muted: bool = False, is_filled: bool = False
    ) -> None:
        """Shows `picture` in the colour of its meaning, also on a ground filled with it, of muted text, or of text."""
        if self._shown != (picture, meaning, is_muted, is_filled):
            self._shown = (picture, meaning, is_muted, is_filled)
            self._draw()

    def _draw(self) -> None:
        if self._shown is not None:
            picture, meaning, is_muted, is_filled = self._shown
            ink = QColor(current().muted) if is_muted else current().ink(meaning)
            if is_filled and meaning is not None:
                ink = QColor(current().tint(meaning).on_fill)
            self.setPixmap(pixmap(picture, self._size_px, ink, ratio=self.devicePixelRatioF()))

    def event(self, event: QEvent) -> bool:
        if event.type() in _REDRAWN_AT:
            self._draw()
        return super().event(event)


class EmptyState(QWidget):
    """An icon and words where there is nothing yet. Without `title` and `text` the owner fills the labels."""

    def __init__(self, name: str, picture: Icon, title: str = "", text: str = "") -> None:
        super().__init__()
        self.setObjectName(name)
        sign = IconLabel(f"{name}_icon", IconSize.EMPTY)
        sign.show_icon(picture, is_muted=True)
        sign.setAlignment(Qt.AlignmentFlag.AlignHCenter)
        self.title = named(QLabel(title), f"{name}_title", "title")
        self.text = named(QLabel(text), f"{name}_text", "muted")
        for label in (self.title, self.text):
            label.setAlignment(Qt.AlignmentFlag.AlignHCenter)
            label.setWordWrap(True)
        # Without an alignment in the layout, which would break the height of wrapped text.
        self.column = in_column(2, sign, self.title, self.text, 3, of=self, spacing=Space.S, margins=Space.XL)
