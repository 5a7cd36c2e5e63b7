"""Finds texts that do not fit, and areas that scroll sideways. A shortened text passes if its tooltip or its name for
screen readers has all of it."""

from collections.abc import Iterator

from PySide6.QtCore import QRect, Qt
from PySide6.QtGui import QFont, QFontMetrics
from PySide6.QtWidgets import (
    QAbstractButton,
    QAbstractItemView,
    QAbstractScrollArea,
    QAbstractSpinBox,
    QComboBox,
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

SLACK_PX = 1
OVER_THE_PAGE = ("connect_panel",)
# A text, what it needs and what it has, and what else tells all of it.
Measured = tuple[str, float, float, str]


def cut_off(root: QWidget) -> list[str]:
    """Return a line for every visible widget below `root` that does not fit, once all is laid out."""
    let_lay_out(root)
    found: list[str] = []
    for widget in (root, *visible_in(root)):
        if widget.visibleRegion().isEmpty() and not is_in_scroll_area(widget):
            continue
        name = " < ".join(one.objectName() or type(one).__name__ for one in (widget, widget.parentWidget() or widget))
        told = f"{widget.toolTip()}\n{widget.accessibleName()}\n{widget.accessibleDescription()}"
        for text, needs_px, has_px, also in measured(widget):
            is_told = bool(text) and text.replace("&", "") in told + also
            if needs_px > has_px + SLACK_PX and not is_told:
                found.append(f"{name}: {text!r} needs {needs_px:.0f} px, has {has_px:.0f}")
        found += [f"{name}: {fault}" for fault in faults_of_place(widget)]
    return found


def texts_of(widget: QWidget) -> Iterator[str]:
    """All that it says, to the eye, in its tooltip and to a screen reader."""
    yield from (widget.toolTip(), widget.accessibleName(), widget.accessibleDescription(), widget.whatsThis())
    yield from (text for one in measured(widget) for text in (one[0], one[3]))


def measured(widget: QWidget) -> Iterator[Measured]:
    metrics = widget.fontMetrics()
    match widget:
        case QLabel() if widget.text() and widget.pixmap().isNull():
            text, room = widget.text(), widget.contentsRect()
            if widget.wordWrap():
                yield text, widget.heightForWidth(widget.width()), widget.height(), ""
                # The longest word, as Qt breaks paths; Chinese breaks anywhere.
                text = max(text.replace("/", "/ ").split(), key=metrics.horizontalAdvance, default="")
                if any(ord(letter) > 0x2E80 for letter in text):
                    return
            else:
                yield text, metrics.tightBoundingRect(text).height() * (text.count("\n") + 1), widget.height(), ""
            yield text, along(text, metrics), room.width(), ""
        case QAbstractButton() if not isinstance(widget.parent(), QHeaderView | QTableView | QTabBar | QToolBar):
            if len(widget.text()) != 1:  # "+" has room enough
                hint = widget.sizeHint() if widget.text() else widget.minimumSizeHint()
                yield widget.text(), hint.width(), widget.width(), ""
                yield widget.text(), min(hint.height(), 22), widget.height(), ""
        case QComboBox():
            option, part = QStyleOptionComboBox(), QStyle.SubControl.SC_ComboBoxEditField
            widget.initStyleOption(option)
            room = widget.style().subControlRect(QStyle.ComplexControl.CC_ComboBox, option, part, widget)
            yield widget.currentText(), along(widget.currentText(), metrics), room.width(), ""
        case QLineEdit() if not isinstance(widget.parent(), QComboBox):
            margins = widget.textMargins().left() + widget.textMargins().right()
            text = widget.displayText() if isinstance(widget.parent(), QAbstractSpinBox) else widget.placeholderText()
            yield text, along(text, metrics), widget.contentsRect().width() - margins, ""
        case QTabBar():
            for index in range(widget.count()):
                yield widget.tabText(index), along(widget.tabText(index), metrics), widget.tabRect(index).width(), ""
        case QHeaderView() if widget.orientation() is Qt.Orientation.Horizontal:
            for section in range(widget.count()):
                if not widget.isSectionHidden(section):
                    roles = Qt.ItemDataRole.DisplayRole, Qt.ItemDataRole.ToolTipRole
                    text, tip = (
                        str(widget.model().headerData(section, widget.orientation(), one) or "") for one in roles
                    )
                    yield text, along(text, metrics), widget.sectionSize(section) - 8, tip
        case QListView() | QTableView() if has_model(widget):
            yield from in_view(widget)


def in_view(view: QListView | QTableView) -> Iterator[Measured]:
    model = view.model()
    columns = range(model.columnCount()) if isinstance(view, QTableView) else range(1)  # a list's is private
    for row in range(min(20, model.rowCount())):
        for column in columns:
            index = model.index(row, column)
            text, tip = str(index.data() or ""), str(index.data(Qt.ItemDataRole.ToolTipRole) or "")
            if not text or (isinstance(view, QTableView) and view.isColumnHidden(column)):
                continue
            own = index.data(Qt.ItemDataRole.FontRole)
            metrics = QFontMetrics(own if isinstance(own, QFont) else view.font())
            icon_px = view.iconSize().width() if index.data(Qt.ItemDataRole.DecorationRole) else 0
            place = view.visualRect(index)
            if isinstance(view, QListView) and view.wordWrap():
                room = QRect(0, 0, place.width(), 10_000)
                yield (
                    text,
                    metrics.boundingRect(room, Qt.TextFlag.TextWordWrap.value, text).height(),
                    place.height(),
                    "",
                )
            else:
                width = view.columnWidth(column) if isinstance(view, QTableView) else place.width()
                yield text, along(text, metrics) + icon_px, width, tip
                yield text, metrics.height(), place.height() or metrics.height(), ""


def along(text: str, metrics: QFontMetrics) -> int:
    return max(map(metrics.horizontalAdvance, text.split("\n")))


def faults_of_place(widget: QWidget) -> Iterator[str]:
    if isinstance(widget, QAbstractScrollArea) and not isinstance(widget, QTableView):
        bar = widget.horizontalScrollBar()
        if bar.maximum() > 0:
            yield f"scrolls sideways by {bar.maximum()} px"
    if isinstance(widget, QAbstractScrollArea | QAbstractSpinBox | QComboBox | QHeaderView | QLineEdit):
        return
    children = [
        one
        for one in widget.children()
        if isinstance(one, QWidget) and one.isVisible() and not one.isWindow() and not isinstance(one, QScrollBar)
        and one.objectName() not in OVER_THE_PAGE and not one.objectName().startswith("qt_")
    ]  # fmt: skip
    around = widget.rect().adjusted(-1, -1, 1, 1)
    is_viewport = isinstance(widget.parentWidget(), QAbstractScrollArea)
    for number, one in enumerate(children):
        if not is_viewport and one.geometry().isValid() and not around.contains(one.geometry()):
            yield f"{one.objectName()} is outside of it"
        for other in children[number + 1 :]:
            common = one.geometry().intersected(other.geometry())
            if common.width() > SLACK_PX and common.height() > SLACK_PX:
                yield f"{one.objectName()} and {other.objectName()} overlap"


def has_model(view: QAbstractItemView) -> bool:
    """Qt's annotations say that a view always has one."""
    model: object = view.model()
    return model is not None


def is_in_scroll_area(widget: QWidget) -> bool:
    """It can be scrolled into sight."""
    parent: QWidget | None = widget
    while parent is not None and not isinstance(parent, QAbstractScrollArea):
        parent = parent.parentWidget()
    return parent is not None
