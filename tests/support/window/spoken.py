"""Collects the texts of a window: labels, tooltips, and names and descriptions for screen readers."""

import re
from collections.abc import Iterator
from typing import Final, NamedTuple

from PySide6.QtCore import QModelIndex, QPersistentModelIndex, Qt
from PySide6.QtGui import QAction
from PySide6.QtWidgets import (
    QAbstractButton,
    QAbstractItemView,
    QComboBox,
    QDockWidget,
    QGroupBox,
    QHeaderView,
    QLabel,
    QLineEdit,
    QMenu,
    QTableView,
    QWidget,
)

SPEAK_FOR_OTHERS = {"port_list", "bundle_text", "profile_title", "profile_about"}
"""Widgets that show text of an adapter, a file or a profile, which is not translated."""
NAMES = re.compile(
    r"DPS-S|USB|UART|Ctrl|Shift|Alt|Esc|Del|Return|Enter|\((?:Space|End|Down|Up)\)|\w+\.(?:json|txt|toml|csv)|\b[0-9A-Z]{4}-[0-9A-Z]{4}\b|tty\w+|\bGO\b|\brad\b|sim://\w+"
    r"|(?:[A-Z]:)?[\\/][\w.\\/~-]+"
)
_ROOT: Final[QModelIndex | QPersistentModelIndex] = QModelIndex()


class Said(NamedTuple):
    """One text, with its widget and its role."""

    where: str
    role: str
    text: str


def said_by(root: QWidget) -> Iterator[Said]:
    """Yield all texts below `root`, visible or not, except typed text and data of the module."""
    for widget in [root, *root.findChildren(QWidget)]:
        parent = widget.parent()
        if widget.objectName().startswith("qt_") or isinstance(parent and (parent.parent() or parent), QComboBox):
            continue  # the list of a combo box has the texts of the box
        where = widget.objectName() or type(widget).__name__
        for role, text in texts_of(widget):
            if text:
                yield Said(where, role, text)
    for action in root.findChildren(QAction):
        if action.objectName().startswith("act_"):
            yield Said(action.objectName(), "action", action.text())


def texts_of(widget: QWidget) -> Iterator[tuple[str, str]]:
    yield "tooltip", widget.toolTip()
    yield "name", widget.accessibleName()
    yield "description", widget.accessibleDescription()
    yield "what's this", widget.whatsThis()
    match widget:
        case QLabel() | QAbstractButton():
            yield "text", widget.text()
        case QLineEdit():
            yield "placeholder", widget.placeholderText()
        case QComboBox():
            for index in range(widget.count()):
                yield "entry", widget.itemText(index)
        case QGroupBox() | QMenu():
            yield "title", widget.title()
        case QDockWidget():
            yield "title", widget.windowTitle()
        case QHeaderView():
            pass  # its view says it
        case QAbstractItemView():
            yield from _in_view(widget)


def _in_view(view: QAbstractItemView) -> Iterator[tuple[str, str]]:
    model = view.model()
    if model is None:
        return
    columns = model.columnCount(_ROOT) if isinstance(view, QTableView) else 1  # a list's is private
    if isinstance(view, QTableView):
        for column in range(columns):
            yield "head", str(model.headerData(column, Qt.Orientation.Horizontal) or "")
    for row in range(min(20, model.rowCount(_ROOT))):
        for column in range(columns):
            index = model.index(row, column, _ROOT)
            yield "cell", str(index.data() or "")
            yield "cell's tooltip", str(index.data(Qt.ItemDataRole.ToolTipRole) or "")


def outside_brackets(text: str) -> str:
    """Return what the pseudo-language did not put in brackets, without tags of rich text."""
    text = re.sub(r"<[^<>]*>", " ", text)
    depth, kept = 0, []
    for letter in text:
        depth += (letter == "[") - (letter == "]")
        kept.append(letter if depth == 0 and letter != "]" else " ")
    return "".join(kept)


def untranslated(root: QWidget) -> Iterator[str]:
    for said in said_by(root):
        if said.where.startswith("simulator_") and (said.role == "entry" or said.text.startswith("--")):
            continue  # the options of the simulated module are written as they are typed
        left = NAMES.sub(" ", outside_brackets(said.text))
        if said.where not in SPEAK_FOR_OTHERS and re.search(r"[A-Za-z]{3,}", left):
            yield f"{said.where}, {said.role}: {said.text!r}"
