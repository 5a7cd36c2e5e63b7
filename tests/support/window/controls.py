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


def tab_chain(window: QWidget) -> list[QWidget]:
    """Return the controls in tab order.

    PySide makes the widget whose `nextInFocusChain` is called the parent of the result. A closed ring of such parents
    would be garbage, and the collector would free visible widgets. So the loop ends before it returns to the window,
    and `findChildren` then restores the parents.
    """
    to_come = {widget for widget in window.findChildren(QWidget) if widget.window() is window}
    chain = [window]
    while to_come:
        following = chain[-1].nextInFocusChain()
        assert following is not None
        to_come.remove(following)
        chain.append(following)
    window.findChildren(QWidget)
    return [
        one
        for one in chain[1:]
        if one.isVisible() and one.isEnabled() and takes_tab(one)
        and one.focusProxy() is None and not one.objectName().startswith("qt_")
    ]  # fmt: skip


def place_of(widget: QWidget, root: QWidget) -> QRect:
    """Return its place in `root`; a widget that is scrolled out of sight is placed at the edge of its scroll area."""
    place = QRect(widget.mapTo(root, QPoint(0, 0)), widget.size())
    parent = widget.parentWidget()
    while parent is not None and parent is not root:
        if isinstance(parent, QAbstractScrollArea):
            area = QRect(parent.mapTo(root, QPoint(0, 0)), parent.size())
            place.moveTop(min(max(place.top(), area.top()), area.bottom() - 1))
            place.setBottom(min(place.bottom(), area.bottom()))
        parent = parent.parentWidget()
    return place


def goes_back(one: QWidget, other: QWidget, root: QWidget) -> bool:
    """Return whether Tab goes against the reading order: up without going right, or left within a row."""
    if one.isAncestorOf(other) or other.isAncestorOf(one):
        return False
    around = one.parentWidget()
    while around is not None and around is not root and not around.isAncestorOf(other):
        around = around.parentWidget()
    here, there = place_of(one, around or root), place_of(other, around or root)
    is_above = there.bottom() <= here.top() and there.left() < here.right()
    is_left = there.right() <= here.left() and there.top() < here.bottom() and here.top() < there.bottom()
    return is_above or is_left


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
