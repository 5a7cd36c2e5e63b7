"""Rows and columns of widgets, said in one call, and a row that breaks where it has no room."""

from typing import Final, NamedTuple

from PySide6.QtCore import QMargins, QRect, QSize, Qt
from PySide6.QtWidgets import QBoxLayout, QHBoxLayout, QLayout, QLayoutItem, QVBoxLayout, QWidget, QWidgetItem

from ui.style.theme import Space


class Gap(NamedTuple):
    """Room that stays as wide as it is."""

    px: int


Item = Gap | QWidget | QLayout | int | tuple[QWidget | QLayout, int] | tuple[QWidget, Qt.AlignmentFlag]
"""A number is empty room that grows by it; a pair gives a widget its share of the room, or its side."""
Margins = int | tuple[int, int] | tuple[int, int, int, int]
"""All four, those at the sides and those above and below, or each as Qt orders them."""


def in_row(
    *items: Item, of: QWidget | None = None, spacing: int | None = None, margins: Margins | None = None
) -> QHBoxLayout:
    """From left to right; `of` is the widget that they fill. What is not given is the style's."""
    layout = QHBoxLayout()
    _fill(layout, items, of, spacing, margins)
    return layout


def in_column(
    *items: Item, of: QWidget | None = None, spacing: int | None = None, margins: Margins | None = None
) -> QVBoxLayout:
    """As `in_row`, from top to bottom."""
    layout = QVBoxLayout()
    _fill(layout, items, of, spacing, margins)
    return layout


def _fill(
    layout: QBoxLayout, items: tuple[Item, ...], of: QWidget | None, spacing: int | None, margins: Margins | None
) -> None:
    if of is not None:
        of.setLayout(layout)
    if margins is not None:
        sides = (margins, margins) if isinstance(margins, int) else margins
        layout.setContentsMargins(*sides, *sides) if len(sides) == 2 else layout.setContentsMargins(*sides)
    if spacing is not None:
        layout.setSpacing(spacing)
    for item in items:
        match item:
            case Gap(px):
                layout.addSpacing(px)
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


class FlowRow(QLayout):
    """What was added with `add` begins at the left, with `add_right` ends at the right, as long as all has room
    beside each other; else it goes on line by line, and what belongs to the right is on the last."""

    def __init__(self, parent: QWidget | None = None, *, spacing_px: int = Space.S) -> None:
        super().__init__(parent)
        self._left: Final[list[QLayoutItem]] = []
        self._right: Final[list[QLayoutItem]] = []
        self._heights: dict[int, int] = {}
        """By width, until something in it changes: Qt asks again and again."""
        self.setContentsMargins(0, 0, 0, 0)
        self.setSpacing(spacing_px)

    def add(self, *widgets: QWidget) -> None:
        self._add(self._left, widgets)

    def add_right(self, *widgets: QWidget) -> None:
        self._add(self._right, widgets)

    def _add(self, items: list[QLayoutItem], widgets: tuple[QWidget, ...]) -> None:
        for widget in widgets:
            self.addChildWidget(widget)
            items.append(QWidgetItem(widget))
        self.invalidate()

    # QLayout

    def addItem(self, item: QLayoutItem) -> None:
        self._left.append(item)

    def count(self) -> int:
        return len(self._left) + len(self._right)

    def itemAt(self, index: int) -> QLayoutItem | None:
        items = [*self._left, *self._right]
        return items[index] if 0 <= index < len(items) else None

    def takeAt(self, index: int) -> QLayoutItem | None:
        if not 0 <= index < self.count():
            return None
        is_left = index < len(self._left)
        return self._left.pop(index) if is_left else self._right.pop(index - len(self._left))

    def expandingDirections(self) -> Qt.Orientation:
        return Qt.Orientation(0)

    def hasHeightForWidth(self) -> bool:
        return True

    def heightForWidth(self, width: int) -> int:
        if width not in self._heights:
            margins = self.contentsMargins()
            room = QRect(0, 0, width, 0).marginsRemoved(_sides(margins))
            self._heights[width] = self._arrange(room, is_trial=True) + _height(margins)
        return self._heights[width]

    def invalidate(self) -> None:
        super().invalidate()
        self._heights.clear()

    def sizeHint(self) -> QSize:
        """All of it in one line."""
        items = self._shown(self._left) + self._shown(self._right)
        hints = [item.sizeHint() for item in items]
        width = sum(hint.width() for hint in hints) + self.spacing() * max(0, len(hints) - 1)
        return self._with_margins(QSize(width, max((hint.height() for hint in hints), default=0)))

    def minimumSize(self) -> QSize:
        """As wide as the widest of them: the rest can go on below."""
        hints = [item.sizeHint() for item in self._shown(self._left) + self._shown(self._right)]
        widest = max((hint.width() for hint in hints), default=0)
        return self._with_margins(QSize(widest, max((hint.height() for hint in hints), default=0)))

    def setGeometry(self, rect: QRect) -> None:
        super().setGeometry(rect)
        self._arrange(rect.marginsRemoved(self.contentsMargins()), is_trial=False)

    def _arrange(self, room: QRect, *, is_trial: bool) -> int:
        """Place everything, or only measure; the height that it takes."""
        left, right = self._shown(self._left), self._shown(self._right)
        begun = self._broken(left, room.width())
        last = begun.pop() if begun else []
        lines: list[tuple[list[QLayoutItem], list[QLayoutItem]]] = [(line, []) for line in begun]
        if self._width(last + right) <= room.width():
            lines.append((last, right))
        else:
            lines.append((last, []))
            lines += [([], line) for line in self._broken(right, room.width())]
        top = room.top()
        for at_left, at_right in lines:
            height = max((item.sizeHint().height() for item in at_left + at_right), default=0)
            if not is_trial:
                self._place(at_left, QRect(room.left(), top, room.width(), height))
                right_px = min(self._width(at_right), room.width())
                self._place(at_right, QRect(room.left() + room.width() - right_px, top, right_px, height))
            top += height + self.spacing()
        return max(0, top - self.spacing() - room.top())

    def _broken(self, items: list[QLayoutItem], width: int) -> list[list[QLayoutItem]]:
        lines: list[list[QLayoutItem]] = []
        for item in items:
            if lines and self._width([*lines[-1], item]) <= width:
                lines[-1].append(item)
            else:
                lines.append([item])
        return lines

    def _place(self, items: list[QLayoutItem], line: QRect) -> None:
        # The layout is always from the left: neither of the window's languages runs the other way.
        x = line.left()
        for item in items:
            hint = item.sizeHint()
            item.setGeometry(QRect(x, line.top(), min(hint.width(), line.width()), line.height()))
            x += hint.width() + self.spacing()

    def _width(self, items: list[QLayoutItem]) -> int:
        return sum(item.sizeHint().width() for item in items) + self.spacing() * max(0, len(items) - 1)

    @staticmethod
    def _shown(items: list[QLayoutItem]) -> list[QLayoutItem]:
        return [item for item in items if not item.isEmpty()]

    def _with_margins(self, size: QSize) -> QSize:
        margins = self.contentsMargins()
        return size.grownBy(margins)


def _sides(margins: QMargins) -> QMargins:
    return QMargins(margins.left(), 0, margins.right(), 0)


def _height(margins: QMargins) -> int:
    return margins.top() + margins.bottom()
