"""Rows and columns of widgets, said in one call."""

from typing import NamedTuple

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QBoxLayout, QHBoxLayout, QLayout, QVBoxLayout, QWidget


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
