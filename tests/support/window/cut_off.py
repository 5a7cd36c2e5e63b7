"""Finds texts that do not fit: cut off, outside their parent, overlapping, or behind a scroll bar.

Every finding is one line that names the widget. An elided text passes if its tooltip or accessible name has all of it.
"""

from collections.abc import Iterator
from typing import NamedTuple

from PySide6.QtCore import QPoint, QRect, Qt
from PySide6.QtGui import QFont, QFontMetrics
from PySide6.QtWidgets import (
    QAbstractButton,
    QAbstractItemView,
    QAbstractScrollArea,
    QAbstractSpinBox,
    QComboBox,
    QGroupBox,
    QHeaderView,
    QLabel,
    QLineEdit,
    QListView,
    QScrollBar,
    QStyle,
    QStyleOptionComboBox,
    QTabBar,
    QTableView,
    QToolBar,
    QWidget,
)

from tests.support.window.controls import visible_in
from tests.support.window.steps import let_lay_out
from ui.widgets.controls import ElidedLabel
from ui.widgets.readout import PaintedWidget

_SLACK_PX = 1
_OVER_THE_PAGE = ("connect_panel",)
"""Widgets that may lie over others."""


class Text(NamedTuple):
    """A text in sight, measured along a line or across its lines. `is_told`: a shortened one is whole elsewhere."""

    text: str
    needs_px: float
    room_px: float
    is_told: bool = False
    across: str = ""

    @property
    def fits(self) -> bool:
        return self.is_told or self.needs_px <= self.room_px + _SLACK_PX


def cut_off(root: QWidget, texts: list[str] | None = None) -> list[str]:
    """Return a line for every visible widget below `root` that does not fit, once all is laid out. What was measured
    is added to `texts`."""
    let_lay_out(root)
    found: list[str] = []
    for widget in (root, *visible_in(root)):
        if not widget.visibleRegion().isEmpty() or _scrolls(widget):
            measured = list(_texts_of(widget))
            faults = [f"{one.text!r} needs {one.needs_px:.0f} px{one.across}, has {one.room_px:.0f}"
                      for one in measured if not one.fits]  # fmt: skip
            found += [f"{_named(widget)}: {fault}" for fault in (*faults, *_faults(widget))]
            if texts is not None:
                texts += [one.text for one in measured]
    return found


def _texts_of(widget: QWidget) -> Iterator[Text]:
    match widget:
        case QLabel() if widget.text() and widget.pixmap().isNull():
            yield from _in_label(widget)
        case QAbstractButton() if not isinstance(widget.parent(), QHeaderView | QTableView | QTabBar | QToolBar):
            yield from _in_button(widget)
        case QComboBox():
            yield _in_combo(widget)
        case QLineEdit() if not isinstance(widget.parent(), QComboBox):
            is_number = isinstance(widget.parent(), QAbstractSpinBox)
            text = widget.displayText() if is_number else widget.placeholderText()
            room_px = widget.contentsRect().width() - widget.textMargins().left() - widget.textMargins().right()
            yield _along(text, widget.fontMetrics(), room_px, is_told=_is_told(widget, text))
        case QTabBar():
            for index in range(widget.count()):
                yield _along(widget.tabText(index), widget.fontMetrics(), widget.tabRect(index).width())
        case QHeaderView() if widget.orientation() is Qt.Orientation.Horizontal:
            yield from _in_header(widget)
        case QGroupBox():
            yield _along(widget.title(), widget.fontMetrics(), widget.width())
        case QListView() if _has_model(widget):
            yield from _in_rows(widget)
        case QTableView() if _has_model(widget):
            yield from _in_cells(widget)


def _along(text: str, metrics: QFontMetrics, room_px: int, *, is_told: bool = False, beside_px: int = 0) -> Text:
    """The longest line of `text` needs its length, and `beside_px` for what stands beside it."""
    return Text(text, max(map(metrics.horizontalAdvance, text.split("\n"))) + beside_px, room_px, is_told)


def _in_label(label: QLabel) -> Iterator[Text]:
    """A label cuts off what has no room; only our own elided one may, if its tooltip has the whole text."""
    text, room, metrics = label.text(), label.contentsRect(), label.fontMetrics()
    if label.wordWrap():
        is_told = isinstance(label, ElidedLabel) and _is_told(label, text)
        yield Text(text, label.heightForWidth(label.width()), label.height(), is_told, across=" of height")
        longest = max(text.replace("/", "/ ").split(), key=metrics.horizontalAdvance, default="")  # as Qt breaks paths
        if not _has_chinese(longest):
            yield _along(longest, metrics, room.width())
        return
    high = metrics.tightBoundingRect(text).height() * (text.count("\n") + 1)
    yield Text(text, high, label.height(), across=" of height")
    yield _along(text, metrics, room.width(), is_told=isinstance(label, ElidedLabel) and _is_told(label, text))


def _in_button(button: QAbstractButton) -> Iterator[Text]:
    text, hint = button.text(), button.sizeHint() if button.text() else button.minimumSizeHint()
    if len(text) == 1:  # "+" has room enough
        return
    yield Text(text, hint.width(), button.width(), _is_told(button, text))
    yield Text(text, min(hint.height(), 22), button.height(), across=" of height")


def _in_combo(box: QComboBox) -> Text:
    option = QStyleOptionComboBox()
    box.initStyleOption(option)
    part = QStyle.SubControl.SC_ComboBoxEditField
    room = box.style().subControlRect(QStyle.ComplexControl.CC_ComboBox, option, part, box)
    text = box.currentText()
    return _along(text, box.fontMetrics(), room.width(), is_told=_is_told(box, text))


def _in_header(header: QHeaderView) -> Iterator[Text]:
    model = header.model()
    for section in range(header.count()):
        if not header.isSectionHidden(section):
            text, told = (
                str(model.headerData(section, header.orientation(), role) or "")
                for role in (Qt.ItemDataRole.DisplayRole, Qt.ItemDataRole.ToolTipRole)
            )
            room_px = header.sectionSize(section) - 8
            yield _along(text, header.fontMetrics(), room_px, is_told=bool(text) and text in told)


def _in_rows(view: QListView) -> Iterator[Text]:
    model, metrics = view.model(), view.fontMetrics()
    for row in range(model.rowCount()):
        index = model.index(row, 0)
        text, place = str(index.data() or ""), view.visualRect(index)
        if view.wordWrap():
            room = QRect(0, 0, place.width(), 10_000)
            high = metrics.boundingRect(room, Qt.TextFlag.TextWordWrap.value, text).height()
            yield Text(text, high, place.height(), across=" of height")
        else:
            icon_px = view.iconSize().width() + 8 if index.data(Qt.ItemDataRole.DecorationRole) else 0
            is_told = text in str(index.data(Qt.ItemDataRole.ToolTipRole) or "")
            yield _along(text, metrics, place.width(), is_told=is_told, beside_px=icon_px)


def _in_cells(view: QTableView) -> Iterator[Text]:
    """Cells may be elided if the tooltip has the whole text."""
    model = view.model()
    for row in range(min(20, model.rowCount())):
        for column in range(model.columnCount()):
            index = model.index(row, column)
            text = str(index.data() or "")
            if view.isColumnHidden(column) or not text:
                continue
            own = index.data(Qt.ItemDataRole.FontRole)
            metrics = QFontMetrics(own if isinstance(own, QFont) else view.font())
            icon_px = view.iconSize().width() if index.data(Qt.ItemDataRole.DecorationRole) else 0
            is_told = text in str(index.data(Qt.ItemDataRole.ToolTipRole) or "")
            yield _along(text, metrics, view.columnWidth(column), is_told=is_told, beside_px=icon_px)
            yield Text(text, metrics.height(), view.rowHeight(row), across=" of height")


def _faults(widget: QWidget) -> Iterator[str]:
    if isinstance(widget, PaintedWidget):
        least = widget.minimumSizeHint()
        if widget.width() < least.width() - _SLACK_PX or widget.height() < least.height() - _SLACK_PX:
            yield f"has {widget.width()}x{widget.height()}, wants {least.width()}x{least.height()}"
    if isinstance(widget, QAbstractScrollArea) and not isinstance(widget, QTableView):
        bar = widget.horizontalScrollBar()
        if bar.maximum() > 0:
            yield f"scrolls sideways by {bar.maximum()} px"
    yield from _beyond_parent(widget)
    yield from _overlaps(widget)


def _beyond_parent(widget: QWidget) -> Iterator[str]:
    parent = widget.parentWidget()
    if parent is None or widget.isWindow() or isinstance(parent.parentWidget(), QAbstractScrollArea):
        return
    if isinstance(widget, QScrollBar) or isinstance(parent, QAbstractScrollArea | QComboBox | QAbstractSpinBox):
        return
    if not parent.rect().adjusted(-1, -1, 1, 1).contains(widget.geometry()) and widget.geometry().isValid():
        yield f"{_place(widget.geometry())} is outside its parent of {parent.width()}x{parent.height()}"


def _overlaps(parent: QWidget) -> Iterator[str]:
    """Yield the pairs of children that overlap."""
    if isinstance(parent, QAbstractScrollArea | QAbstractSpinBox | QComboBox | QHeaderView | QLineEdit):
        return
    children = [
        child
        for child in parent.children()
        if isinstance(child, QWidget)
        and child.isVisible()
        and not child.isWindow()
        and child.objectName() not in _OVER_THE_PAGE
        and not child.objectName().startswith("qt_")
    ]
    for number, one in enumerate(children):
        for other in children[number + 1 :]:
            common = one.geometry().intersected(other.geometry())
            if common.width() > _SLACK_PX and common.height() > _SLACK_PX:
                yield f"{_named(one)} and {_named(other)} overlap by {common.width()}x{common.height()}"


def _has_model(view: QAbstractItemView) -> bool:
    """Return whether a view has a model; Qt's annotations say that it always has one."""
    model: object = view.model()
    return model is not None


def _is_told(widget: QWidget, text: str) -> bool:
    """Return whether the tooltip or the accessible name has the whole text."""
    whole = f"{widget.toolTip()}\n{widget.accessibleName()}\n{widget.accessibleDescription()}"
    return bool(text) and text.replace("&", "") in whole


def _scrolls(widget: QWidget) -> bool:
    """Return whether it is in a scroll area, so that it can be scrolled into sight."""
    parent: QWidget | None = widget
    while parent is not None:
        if isinstance(parent, QAbstractScrollArea):
            return True
        parent = parent.parentWidget()
    return False


def _has_chinese(text: str) -> bool:
    return any(ord(letter) > 0x2E80 for letter in text)


def _named(widget: QWidget) -> str:
    names: list[str] = []
    one: QWidget | None = widget
    while one is not None and len(names) < 3:
        names.append(one.objectName() or type(one).__name__)
        one = one.parentWidget()
    return " < ".join(names)


def _place(rect: QRect) -> str:
    corner = QPoint(rect.topLeft())
    return f"{rect.width()}x{rect.height()} at {corner.x()}, {corner.y()}"
