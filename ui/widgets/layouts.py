"""Rows, columns and scroll areas made in one call."""

from typing import Final, TypeVar

from PySide6.QtCore import Qt
from PySide6.QtGui import QFocusEvent
from PySide6.QtWidgets import (
    QBoxLayout,
    QGridLayout,
    QHBoxLayout,
    QLabel,
    QLayout,
    QScrollArea,
    QSizePolicy,
    QStackedLayout,
    QStackedWidget,
    QVBoxLayout,
    QWidget,
)

from ui.style.theme import is_text_large, scaled
from ui.widgets.controls import control, named, set_role

Item = QWidget | QLayout | int | tuple[QWidget | QLayout, int] | tuple[QWidget, Qt.AlignmentFlag]
"""A number is a stretch; a pair is a widget or layout with its stretch, or a widget with its alignment."""
Margins = int | tuple[int, int] | tuple[int, int, int, int]
"""One for all sides, (horizontal, vertical), or (left, top, right, bottom)."""

Box = TypeVar("Box", bound=QBoxLayout)
Stack = TypeVar("Stack", QStackedLayout, QStackedWidget)
_LEAST_PX: Final = 60
"""Height of what scrolls."""


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
        _set_margins(layout, margins)
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


def _set_margins(layout: QLayout, margins: Margins) -> None:
    sides = (margins, margins) if isinstance(margins, int) else margins
    layout.setContentsMargins(*sides, *sides) if len(sides) == 2 else layout.setContentsMargins(*sides)


def stacked(stack: Stack, *views: QWidget) -> Stack:
    """Adds `views` to `stack`, which shows the first; returns it."""
    for view in views:
        stack.addWidget(view)
    return stack


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
        self.setMinimumSize(1, scaled(_LEAST_PX))
        self._bars = (self.verticalScrollBar(), self.horizontalScrollBar())
        for bar in self._bars:
            bar.rangeChanged.connect(self._offer_focus)
        self._offer_focus()

    def _offer_focus(self) -> None:
        scrolls = any(bar.maximum() > bar.minimum() for bar in self._bars)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus if scrolls else Qt.FocusPolicy.NoFocus)

    def focusInEvent(self, event: QFocusEvent) -> None:
        super().focusInEvent(event)
        self._show_focus("focus")

    def focusOutEvent(self, event: QFocusEvent) -> None:
        super().focusOutEvent(event)
        self._show_focus("")

    def _show_focus(self, role: str) -> None:
        for bar in self._bars:
            set_role(bar, role)


def scroll_area(
    content: QWidget, name: str, says: str, *, is_vertical: bool = False, is_transparent: bool = False
) -> ScrollArea:
    """An area that scrolls `content`; `says` is its accessible name. Where it `is_vertical` it never scrolls sideways;
    where it `is_transparent` the card below it shows through."""
    area = control(ScrollArea(), name, says=says)
    area.setWidget(content)
    if is_vertical:
        area.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
    if is_transparent:
        for ground in (content, area.viewport()):
            ground.setAutoFillBackground(False)
    return area


def retain_size(widget: QWidget) -> None:
    """Keeps the room of `widget` in its layout while it is hidden."""
    policy = widget.sizePolicy()
    policy.setRetainSizeWhenHidden(True)
    widget.setSizePolicy(policy)
