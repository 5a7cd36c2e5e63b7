"""Rows, columns and scroll areas made in one call, and a row that wraps."""

from collections.abc import Iterable
from typing import Final, NamedTuple, TypeVar

from PySide6.QtCore import QRect, QSize, Qt
from PySide6.QtGui import QFocusEvent
from PySide6.QtWidgets import (
    QBoxLayout,
    QHBoxLayout,
    QLabel,
    QLayout,
    QLayoutItem,
    QScrollArea,
    QStackedLayout,
    QStackedWidget,
    QVBoxLayout,
    QWidget,
    QWidgetItem,
)

from ui.style.theme import Space, scaled
from ui.widgets.controls import control, named, set_role

_LOWEST_PX: Final = 130
"""Of a list and of its details, one below the other."""
_BESIDE_FROM_PX: Final = 640
"""Width of a page, in the usual size of text."""
_UNBOUNDED: Final = 16_777_215
"""QWIDGETSIZE_MAX."""


class Gap(NamedTuple):
    """Empty room of a fixed width or height."""

    px: int


Item = Gap | QWidget | QLayout | int | tuple[QWidget | QLayout, int] | tuple[QWidget, Qt.AlignmentFlag]
"""A number is a stretch; a pair is a widget or layout with its stretch, or a widget with its alignment."""
Margins = int | tuple[int, int] | tuple[int, int, int, int]
"""One for all sides, (horizontal, vertical), or (left, top, right, bottom)."""

Box = TypeVar("Box", bound=QBoxLayout)
Stack = TypeVar("Stack", QStackedLayout, QStackedWidget)


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
    return layout


def _set_margins(layout: QLayout, margins: Margins) -> None:
    sides = (margins, margins) if isinstance(margins, int) else margins
    layout.setContentsMargins(*sides, *sides) if len(sides) == 2 else layout.setContentsMargins(*sides)


def stacked(stack: Stack, *views: QWidget) -> Stack:
    """Adds `views` to `stack`, which shows the first; returns it."""
    for view in views:
        stack.addWidget(view)
    return stack


def captioned_row(*fields: tuple[str, QWidget]) -> "FlowRow":
    """Fields of equal width, each below its caption in as few rows as have room for them."""
    boxes = []
    for caption, field in fields:
        label = named(QLabel(caption), f"{field.objectName()}_caption", "small")
        label.setBuddy(field)
        both = QWidget()
        in_column(label, field, of=both, spacing=2, margins=0)
        boxes.append(both)
    return FlowRow(*boxes, is_even=True)


class ScrollArea(QScrollArea):
    """As large as its content or larger. Takes the focus only while it scrolls, and shows it by its bars."""

    def __init__(self) -> None:
        super().__init__()
        self.setWidgetResizable(True)
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


def fold_beside(lists: QBoxLayout, table: QWidget, details: QWidget, width_px: int, page_px: int) -> None:
    """Lays `details` out beside the table, `width_px` wide in the usual size of text, or below it on a narrow page."""
    is_beside, direction = page_px >= scaled(_BESIDE_FROM_PX), QBoxLayout.Direction
    lists.setDirection(direction.LeftToRight if is_beside else direction.TopToBottom)
    details.setMinimumWidth(scaled(width_px) if is_beside else 0)
    details.setMaximumWidth(scaled(width_px) if is_beside else _UNBOUNDED)
    for part in (table, details):
        part.setMinimumHeight(0 if is_beside else scaled(_LOWEST_PX))


def retain_size(widget: QWidget) -> None:
    """Keeps the room of `widget` in its layout while it is hidden."""
    policy = widget.sizePolicy()
    policy.setRetainSizeWhenHidden(True)
    widget.setSizePolicy(policy)


def least_size(widget: QWidget) -> QSize:
    """The size below which something in `widget` is cut off: as high as its texts are when they wrap in the width that
    they have now. The view of a page that is behind another one needs no room."""
    layout = widget.layout()
    if layout is not None:
        view = layout.currentWidget() if isinstance(layout, QStackedLayout) else None
        least = _least_size(layout) if view is None else least_size(view)
        return least.grownBy(widget.contentsMargins()).expandedTo(widget.minimumSize())
    size = QWidgetItem(widget).minimumSize()
    if widget.hasHeightForWidth():
        size.setHeight(max(size.height(), widget.heightForWidth(widget.width())))
    return size


def _least_size(layout: QLayout) -> QSize:
    if not isinstance(layout, QBoxLayout):
        size = layout.totalMinimumSize()
        if layout.hasHeightForWidth():
            size.setHeight(layout.totalMinimumHeightForWidth(_last_width(layout)))
        return size
    items = [item for item in map(layout.itemAt, range(layout.count())) if item is not None]
    sizes = [_least_of(item) for item in items]
    widths, heights = [size.width() for size in sizes], [size.height() for size in sizes]
    gaps = layout.spacing() * max(0, sum(not item.isEmpty() for item in items) - 1)
    is_column = layout.direction() in (QBoxLayout.Direction.TopToBottom, QBoxLayout.Direction.BottomToTop)
    size = (
        QSize(max(widths, default=0), sum(heights) + gaps)
        if is_column
        else QSize(sum(widths) + gaps, max(heights, default=0))
    )
    return size.grownBy(layout.contentsMargins())


def _last_width(layout: QLayout) -> int:
    """Where it has to be laid out again, Qt has forgotten its width."""
    parent = layout.parentWidget()
    last_px = layout.last_px if isinstance(layout, FlowRow) else 0
    return layout.geometry().width() or last_px or (0 if parent is None else parent.width())


def _least_of(item: QLayoutItem) -> QSize:
    widget, layout = item.widget(), item.layout()
    if widget is not None and not item.isEmpty():
        return least_size(widget)
    return item.minimumSize() if layout is None else _least_size(layout)  # the margins of an empty layout remain


class FlowRow(QLayout):
    """A row that wraps, as the layout `of` that widget; those at the `right` are in the last line. Where it `is_even`
    the others lie in columns of one width. In more height than it needs it is centred."""

    def __init__(
        self, *left: QWidget, right: Iterable[QWidget] = (), of: QWidget | None = None, spacing: int = Space.S,
        margins: Margins = 0, is_even: bool = False,
    ) -> None:  # fmt: skip
        super().__init__(of)
        self._is_even = is_even
        self._left: Final[list[QLayoutItem]] = []
        self._right: Final[list[QLayoutItem]] = []
        self._heights: dict[int, int] = {}
        """Cache by width: Qt asks many times for each layout."""
        self._share = 0
        """Width of an even column."""
        self.last_px = 0
        """Its width when it was laid out last."""
        _set_margins(self, margins)
        self.setSpacing(spacing)
        self.add(*left)
        self.add_right(*right)

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
            room = QRect(0, 0, width - margins.left() - margins.right(), 0)
            self._heights[width] = self._arrange(room, is_trial=True) + margins.top() + margins.bottom()
        return self._heights[width]

    def invalidate(self) -> None:
        super().invalidate()
        self._heights.clear()

    def sizeHint(self) -> QSize:
        """The size in one line."""
        items = self._shown(self._left) + self._shown(self._right)
        return QSize(self._width(items), _height(items)).grownBy(self.contentsMargins())

    def minimumSize(self) -> QSize:
        """As wide as the widest widget, since all others can wrap."""
        items = self._shown(self._left) + self._shown(self._right)
        widest = max((item.sizeHint().width() for item in items), default=0)
        return QSize(widest, _height(items)).grownBy(self.contentsMargins())

    def setGeometry(self, rect: QRect) -> None:
        super().setGeometry(rect)
        self.last_px = rect.width()
        spare_px = max(0, rect.height() - self.heightForWidth(rect.width()))
        self._arrange(rect.marginsRemoved(self.contentsMargins()).translated(0, spare_px // 2), is_trial=False)

    def _arrange(self, room: QRect, *, is_trial: bool) -> int:
        """Places all items, or only measures where it `is_trial`; returns the height."""
        left, right = self._shown(self._left), self._shown(self._right)
        wrapped = self._wrap(left, room.width())
        last = wrapped.pop() if wrapped else []
        lines: list[tuple[list[QLayoutItem], list[QLayoutItem]]] = [(line, []) for line in wrapped]
        if self._width(last + right) <= room.width():
            lines.append((last, right))
        else:
            lines += [(last, [])] * bool(last)
            lines += [([], line) for line in self._wrap(right, room.width())]
        top = room.top()
        for at_left, at_right in lines:
            height = _height(at_left + at_right)
            if not is_trial:
                self._place(at_left, QRect(room.left(), top, room.width(), height))
                right_px = min(self._width(at_right), room.width())
                self._place(at_right, QRect(room.left() + room.width() - right_px, top, right_px, height))
            top += height + self.spacing()
        return max(0, top - self.spacing() - room.top())

    def _wrap(self, items: list[QLayoutItem], width: int) -> list[list[QLayoutItem]]:
        if self._is_even:
            return self._in_columns(items, width)
        lines: list[list[QLayoutItem]] = []
        for item in items:
            if lines and self._width([*lines[-1], item]) <= width:
                lines[-1].append(item)
            else:
                lines.append([item])
        return lines

    def _in_columns(self, items: list[QLayoutItem], width: int) -> list[list[QLayoutItem]]:
        """As many as hold the widgets in them."""
        lines: list[list[QLayoutItem]] = []
        for count in range(len(items), 0, -1):
            lines = [items[first : first + count] for first in range(0, len(items), count)]
            self._share = (width + self.spacing()) // count - self.spacing()
            has_shares = all(item.minimumSize().width() <= self._share for item in items)
            if has_shares and all(self._width(line) <= width for line in lines):
                break
        return lines

    def _place(self, items: list[QLayoutItem], line: QRect) -> None:
        # The layout is always from the left: neither of the window's languages runs the other way.
        x = line.left()
        for item in items:
            width = self._share if self._is_even else item.sizeHint().width()
            item.setGeometry(QRect(x, line.top(), min(width, line.width()), line.height()))
            x += width + self.spacing()

    def _width(self, items: list[QLayoutItem]) -> int:
        return sum(item.sizeHint().width() for item in items) + self.spacing() * max(0, len(items) - 1)

    @staticmethod
    def _shown(items: list[QLayoutItem]) -> list[QLayoutItem]:
        return [item for item in items if not item.isEmpty()]


def _height(items: list[QLayoutItem]) -> int:
    return max((item.sizeHint().height() for item in items), default=0)
