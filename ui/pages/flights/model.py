"""Columns of the two lists of flights."""

import math
from enum import IntEnum
from typing import Final

from PySide6.QtGui import QIcon
from PySide6.QtWidgets import QWidget

from app.text.durations import stopwatch
from protocol.translatable import marked
from ui.forms.table_kit import RowsModel, TableColumn
from ui.pages.flights.controller import FlightRow
from ui.pages.flights.texts import problem_count, row_text, short_name, verdict_text
from ui.pages.flights.verdicts import appearance_of, order_of, verdict_of
from ui.style.icons import Icon, icon
from ui.style.theme import Meaning


class FlightColumn(IntEnum):
    NAME = 0
    FIRES = 1
    TILT = 2
    FALL = 3
    DURATION = 4
    PROBLEMS = 5


def _fires_icon(row: FlightRow) -> QIcon:
    look = appearance_of(row.group, verdict_of(row.outcome))
    return icon(look.icon, look.meaning)


def _fires_ink(row: FlightRow) -> Meaning | None:
    return appearance_of(row.group, verdict_of(row.outcome)).meaning


def _tilt(row: FlightRow) -> float:
    return math.nan if row.outcome is None else row.outcome.flight.tilt_max_deg


def _tilt_text(row: FlightRow) -> str:
    return "—" if math.isnan(_tilt(row)) else f"{_tilt(row):.0f}°"


def _fall_text(row: FlightRow) -> str:
    return "—" if row.longest_fall_s < 0 else f"{row.longest_fall_s:.2f} s"


def _duration(row: FlightRow) -> float:
    return -1.0 if row.outcome is None else row.outcome.flight.duration_s


COLUMNS: Final = (
    TableColumn[FlightRow](marked("Flight"), lambda row: short_name(row.name)),
    TableColumn[FlightRow](
        marked("Fires"),
        lambda row: verdict_text(row.outcome),
        lambda row: order_of(row.group, row.outcome),
        picture=_fires_icon,
        ink=_fires_ink,
    ),
    TableColumn[FlightRow](
        marked("Tilt"),
        _tilt_text,
        lambda row: -1.0 if math.isnan(_tilt(row)) else _tilt(row),
        is_right=True,
    ),
    TableColumn[FlightRow](
        marked("Fall"),
        _fall_text,
        lambda row: row.longest_fall_s,
        is_right=True,
    ),
    TableColumn[FlightRow](
        marked("Duration"),
        lambda row: "—" if row.outcome is None else stopwatch(_duration(row)),
        _duration,
        is_right=True,
    ),
    TableColumn[FlightRow](
        marked("Problems"),
        lambda row: str(problem_count(row)) if problem_count(row) else "",
        lambda row: float(problem_count(row)),
        picture=lambda row: icon(Icon.WARNING, Meaning.ATTENTION) if problem_count(row) else None,
        ink=lambda row: Meaning.ATTENTION if problem_count(row) else None,
    ),
)


def flights_model(parent: QWidget) -> RowsModel[FlightRow]:
    return RowsModel(COLUMNS, lambda row: row.name, row_text, parent, aligns_heads=True)
