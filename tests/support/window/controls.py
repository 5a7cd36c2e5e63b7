"""Finds the controls of a window, their tab order, and those that move, so that the next click would miss them."""

from PySide6.QtCore import QPoint, QRect, Qt
from PySide6.QtWidgets import (
    QAbstractButton,
    QAbstractItemView,
    QAbstractScrollArea,
    QAbstractSlider,
    QAbstractSpinBox,
    QComboBox,
    QDialogButtonBox,
    QLineEdit,
    QPlainTextEdit,
    QScrollArea,
    QScrollBar,
    QTabBar,
    QWidget,
)

from ui.widgets.readout import StateChip

CONTROLS = (
    QAbstractButton, QComboBox, QAbstractSpinBox, QAbstractSlider, QLineEdit, QAbstractItemView, QPlainTextEdit,
)  # fmt: skip
_SLACK_PX = 1
_PRESSED = (QAbstractButton, QComboBox, QLineEdit)


def visible_in(root: QWidget) -> list[QWidget]:
    """Return the visible widgets below `root`, in the order of `findChildren`, without looking into hidden pages."""
    found: list[QWidget] = []
    for child in root.findChildren(QWidget, options=Qt.FindChildOption.FindDirectChildrenOnly):
        if child.isVisible():
            found += [child, *visible_in(child)]
    return found


def controls_in(root: QWidget) -> list[QWidget]:
    """Return the visible controls, without the parts that Qt makes within them."""
    return [
        one
        for one in visible_in(root)
        if not one.objectName().startswith("qt_")
        and (isinstance(one, CONTROLS) or takes_tab(one))
        and not isinstance(one, QScrollBar | QScrollArea)
        and not isinstance(one.parent(), QAbstractSpinBox | QComboBox | QLineEdit | QAbstractScrollArea)
        and not isinstance(one.parent(), QDialogButtonBox | QTabBar)
    ]


def takes_tab(widget: QWidget) -> bool:
    return bool(widget.focusPolicy() & Qt.FocusPolicy.TabFocus)


def place(widget: QWidget) -> QRect:
    """Return the place of a widget in its window."""
    return QRect(widget.mapTo(widget.window(), QPoint(0, 0)), widget.size())


def places(root: QWidget) -> dict[str, QRect]:
    """Return the place in `root` of each control and each chip, by object name."""
    found: list[QWidget] = [one for one in controls_in(root) if isinstance(one, _PRESSED)]
    found += [one for one in root.findChildren(StateChip) if one.isVisible() and one.objectName()]
    return {one.objectName(): QRect(one.mapTo(root, QPoint()), one.size()) for one in found}


def moved(before: dict[str, QRect], after: dict[str, QRect]) -> list[str]:
    """Return a line for each control that moved; ones that appeared or disappeared do not count."""
    return [
        f"{name} moved from {was.x()}, {was.y()} to {after[name].x()}, {after[name].y()}"
        for name, was in before.items()
        if name in after and (after[name].topLeft() - was.topLeft()).manhattanLength() > _SLACK_PX
    ]


def covered(before: dict[str, QRect], after: dict[str, QRect]) -> list[str]:
    """Return a line for each new control in the place of one that disappeared: a click would hit it instead."""
    gone = {name: place for name, place in before.items() if name not in after}
    return [
        f"{name} came to lie where {other} was"
        for name, place in after.items()
        for other, was in gone.items()
        if name not in before and place.intersects(was)
    ]
