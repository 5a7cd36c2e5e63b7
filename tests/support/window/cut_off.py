"""Finds texts that do not fit: cut off, outside their parent, overlapping, or behind a scroll bar.

Every finding is one line that names the widget. An elided text passes if its tooltip or accessible name has all of it.
"""

from collections.abc import Iterator

from PySide6.QtCore import QModelIndex, QPoint, QRect, Qt
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
    QStyledItemDelegate,
    QStyleOptionComboBox,
    QTabBar,
    QTableView,
    QWidget,
)

from tests.support.window.controls import visible_in
from tests.support.window.painted_text import Drawn
from tests.support.window.steps import let_lay_out
from ui.style.painted_widget import PaintedWidget
from ui.style.theme import Size, font

_SLACK_PX = 1
_OVER_THE_PAGE = ("connect_panel",)
"""Widgets that may lie over others."""


def cut_off(root: QWidget) -> list[str]:
    """Return a line for every visible widget below `root` that does not fit, once all is laid out."""
    let_lay_out(root)
    found: list[str] = []
    for widget in (root, *visible_in(root)):
        if not widget.visibleRegion().isEmpty() or _scrolls(widget):
            found += [f"{_named(widget)}: {fault}" for fault in _faults(widget)]
    return found


def cut_off_in_paint(drawn: list[Drawn]) -> list[str]:
    """Return a line for every painted text that is wider than its room, or elided and nowhere given in full."""
    found = []
    for one in drawn:
        is_cell = isinstance(one.widget.parentWidget(), QAbstractItemView)  # its tooltip is the model's: see _in_cells
        whole = one.text.rstrip("…").rstrip()
        is_whole = isinstance(one.widget, QLabel) and one.text == one.widget.text()  # "Checking…"
        if one.room_px is not None and one.needs_px > one.room_px + _SLACK_PX:
            found.append(f"{_named(one.widget)}: {one.text!r} needs {one.needs_px:.0f} px, has {one.room_px:.0f}")
        elif one.text.endswith("…") and not (is_whole or is_cell or _is_told(one.widget, whole)):
            found.append(f"{_named(one.widget)}: {one.text!r} is elided, and given nowhere in full")
    return found


def _faults(widget: QWidget) -> Iterator[str]:
    match widget:
        case QLabel():
            yield from _in_label(widget)
        case QAbstractButton():
            yield from _in_button(widget)
        case QComboBox():
            yield from _in_combo(widget)
        case QAbstractSpinBox():
            yield from _too_narrow(widget.lineEdit().displayText(), widget.lineEdit())
        case QLineEdit() if not isinstance(widget.parent(), QAbstractSpinBox | QComboBox):
            yield from _too_narrow(widget.placeholderText(), widget)
        case QTabBar():
            yield from _in_tabs(widget)
        case QHeaderView():
            yield from _in_header(widget)
        case QGroupBox():
            if widget.fontMetrics().horizontalAdvance(widget.title()) > widget.width():
                yield f"title {widget.title()!r} is cut off"
        case QListView():
            yield from _in_rows(widget)
        case QTableView():
            yield from _in_cells(widget)
        case PaintedWidget():
            least = widget.minimumSizeHint()
            if widget.width() < least.width() - _SLACK_PX or widget.height() < least.height() - _SLACK_PX:
                yield f"has {widget.width()}x{widget.height()}, wants {least.width()}x{least.height()}"
    if isinstance(widget, QAbstractScrollArea) and not isinstance(widget, QTableView):
        bar = widget.horizontalScrollBar()
        if bar.maximum() > 0:
            yield f"scrolls sideways by {bar.maximum()} px"
    yield from _beyond_parent(widget)
    yield from _overlaps(widget)


def _in_label(label: QLabel) -> Iterator[str]:
    text = label.text()
    if not text or not label.pixmap().isNull():
        return
    room = label.contentsRect()
    metrics = label.fontMetrics()
    if label.wordWrap():
        needed = label.heightForWidth(label.width())
        if needed > label.height() + _SLACK_PX:
            yield f"{text!r} needs {needed} px of height, has {label.height()}"
        longest = max(text.replace("/", "/ ").split(), key=metrics.horizontalAdvance, default="")  # as Qt breaks paths
        if metrics.horizontalAdvance(longest) > room.width() + _SLACK_PX and not _has_chinese(longest):
            yield f"the word {longest!r} is wider than {room.width()} px"
        return
    needed = metrics.tightBoundingRect(text).height() * (text.count("\n") + 1)
    if needed > label.height() + _SLACK_PX:
        yield f"{text!r} needs {needed} px of height, has {label.height()}"
    if not _is_told(label, text):
        wanted = max(metrics.horizontalAdvance(line) for line in text.split("\n"))
        if wanted > room.width() + _SLACK_PX:
            yield f"{text!r} needs {wanted} px, has {room.width()}"


def _in_button(button: QAbstractButton) -> Iterator[str]:
    hint = button.minimumSizeHint() if not button.text() else button.sizeHint()
    if isinstance(button.parent(), QHeaderView | QTableView) or len(button.text()) == 1:  # "+" has room enough
        return
    if hint.width() > button.width() + _SLACK_PX and not _is_told(button, button.text()):
        yield f"{button.text()!r} needs {hint.width()} px, has {button.width()}"
    if min(hint.height(), 22) > button.height() + _SLACK_PX:
        yield f"{button.text()!r} needs {hint.height()} px of height, has {button.height()}"


def _in_combo(box: QComboBox) -> Iterator[str]:
    option = QStyleOptionComboBox()
    box.initStyleOption(option)
    room = box.style().subControlRect(
        QStyle.ComplexControl.CC_ComboBox, option, QStyle.SubControl.SC_ComboBoxEditField, box
    )
    wanted = box.fontMetrics().horizontalAdvance(box.currentText())
    if wanted > room.width() + _SLACK_PX and not _is_told(box, box.currentText()):
        yield f"{box.currentText()!r} needs {wanted} px, has {room.width()}"


def _too_narrow(text: str, edit: QLineEdit) -> Iterator[str]:
    wanted = edit.fontMetrics().horizontalAdvance(text)
    room = edit.contentsRect().width() - edit.textMargins().left() - edit.textMargins().right()
    if wanted > room + _SLACK_PX and not _is_told(edit, text):
        yield f"{text!r} needs {wanted} px, has {room}"


def _in_tabs(bar: QTabBar) -> Iterator[str]:
    for index in range(bar.count()):
        if bar.fontMetrics().horizontalAdvance(bar.tabText(index)) > bar.tabRect(index).width():
            yield f"tab {bar.tabText(index)!r} is cut off"


def _in_header(header: QHeaderView) -> Iterator[str]:
    model = header.model()
    if header.orientation() is not Qt.Orientation.Horizontal:
        return
    for section in range(header.count()):
        if header.isSectionHidden(section):
            continue
        text = str(model.headerData(section, header.orientation()) or "")
        wanted = header.fontMetrics().horizontalAdvance(text)
        told = str(model.headerData(section, header.orientation(), Qt.ItemDataRole.ToolTipRole) or "")
        if wanted > header.sectionSize(section) - 8 and text not in told:
            yield f"head {text!r} needs {wanted + 8} px, has {header.sectionSize(section)}"


def _in_rows(view: QListView) -> Iterator[str]:
    model = view.model()
    for row in range(model.rowCount() if _has_model(view) else 0):
        index = model.index(row, 0)
        text = str(index.data() or "")
        icon_px = view.iconSize().width() + 8 if index.data(Qt.ItemDataRole.DecorationRole) else 0
        wanted = max(_metrics(view).horizontalAdvance(line) for line in text.split("\n")) + icon_px
        if view.wordWrap():
            room = QRect(0, 0, view.visualRect(index).width(), 10_000)
            high = _metrics(view).boundingRect(room, Qt.TextFlag.TextWordWrap.value, text).height()
            if high > view.visualRect(index).height() + _SLACK_PX:
                yield f"row {text!r} needs {high} px of height, has {view.visualRect(index).height()}"
        elif wanted > view.visualRect(index).width() and text not in str(index.data(Qt.ItemDataRole.ToolTipRole) or ""):
            yield f"row {text!r} needs {wanted} px, has {view.visualRect(index).width()}"


def _in_cells(view: QTableView) -> Iterator[str]:
    """Cells may be elided if the tooltip has the whole text."""
    model = view.model()
    for row in range(min(20, model.rowCount() if _has_model(view) else 0)):
        high = QFontMetrics(view.font()).height()
        if view.rowHeight(row) < high - _SLACK_PX:
            yield f"row {row} needs {high} px of height, has {view.rowHeight(row)}"
        for column in range(model.columnCount()):
            index = model.index(row, column)
            text = str(index.data() or "")
            if view.isColumnHidden(column) or not text:
                continue
            wanted = max(_metrics(view, index).horizontalAdvance(line) for line in text.split("\n"))
            told = str(index.data(Qt.ItemDataRole.ToolTipRole) or "")
            if wanted > view.columnWidth(column) and text not in told:
                yield f"cell {row}, {column} {text!r} needs {wanted} px, has {view.columnWidth(column)}"


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


def _metrics(view: QAbstractItemView, index: QModelIndex | None = None) -> QFontMetrics:
    own = None if index is None else index.data(Qt.ItemDataRole.FontRole)
    if isinstance(own, QFont):
        return QFontMetrics(own)
    is_ours = type(view.itemDelegate()) is not QStyledItemDelegate  # ours use the small font
    return QFontMetrics(font(Size.SMALL) if is_ours and isinstance(view, QTableView) else view.font())


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
