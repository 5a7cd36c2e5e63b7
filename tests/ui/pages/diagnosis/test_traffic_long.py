"""A long capture in the traffic list blocks the event loop no longer than a short one."""

import time
from collections.abc import Iterator, Sequence
from itertools import count
from pathlib import Path

import pytest
from PySide6.QtCore import QModelIndex, QPersistentModelIndex, Qt
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from app.captures.entries import CaptureEntry, Way
from app.captures.explained import Explained
from app.captures.rows import CaptureRows
from protocol.catalogue import BY_NAME
from protocol.messages import Status
from tests.support.records.recordings_made import explained
from tests.support.window.fakes_ui import TRAFFIC_ALONE, window
from tests.support.window.steps import show_page
from ui.pages.diagnosis import traffic
from ui.pages.diagnosis.traffic import TrafficPage
from ui.pages.diagnosis.traffic_model import Filter, TrafficModel

ROWS = 5000
TILTS = 20


def capture(rows: int = ROWS) -> CaptureRows:
    """A stream of few different frames with a request in the middle."""
    raws = [Status(tilt, 1.0, triggered=False, active=True).encode() for tilt in range(TILTS)]
    entries = [CaptureEntry(number / 100, Way.IN, raws[number % TILTS]) for number in range(rows)]
    entries[rows // 2] = CaptureEntry(rows / 200, Way.OUT, BY_NAME["light"].query().encode())
    return CaptureRows(explained(entries))


@pytest.fixture
def page(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> Iterator[TrafficPage]:
    with window(qapp, tmp_path, entries=TRAFFIC_ALONE) as assembly:
        found = show_page(qtbot, assembly.window, "traffic", TrafficPage)
        found.show_recorded(capture())
        yield found


def test_a_slice_of_the_search_ends_on_time(page: TrafficPage, monkeypatch: pytest.MonkeyPatch) -> None:
    looked_at: list[int] = []
    monkeypatch.setattr(page.model, "same_text_key", looked_at.append)  # None: the row itself is compared
    clock = count(0.0, traffic._SLICE_S / 2)
    monkeypatch.setattr(time, "perf_counter", lambda: next(clock))
    page.search.field.setText("nowhere")
    page.search.find_next()
    page.search._timer.stop()
    page.search._search_slice()
    assert len(looked_at) == traffic._ROWS_AT_ONCE
    assert page.search.share == pytest.approx(traffic._ROWS_AT_ONCE / ROWS)


def test_repeated_texts_are_formatted_once(qtbot: QtBot, page: TrafficPage, monkeypatch: pytest.MonkeyPatch) -> None:
    """A search in a million rows takes seconds, not a minute."""
    looked_at: list[object] = []
    matches = traffic.matches

    def counted(row: Explained, wanted: str, wanted_hex: str) -> bool:
        looked_at.append(row)
        return matches(row, wanted, wanted_hex)

    monkeypatch.setattr(traffic, "matches", counted)
    page.search.field.setText("nowhere")
    page.search.find_next()
    qtbot.waitUntil(lambda: not page.search.is_searching)
    assert page._count.text() == "No matches"
    assert len(looked_at) == TILTS + 1
    page.search.field.setText("query")
    page.search.find_next()
    qtbot.waitUntil(lambda: not page.search.is_searching)
    assert [index.row() for index in page.table.selectionModel().selectedRows()] == [ROWS // 2]


def test_a_search_backwards_selects_what_it_found_alone(qtbot: QtBot, page: TrafficPage) -> None:
    """Shift is still down, with which a person extends a selection."""
    page.table.selectRow(ROWS - 1)
    page.search.field.setText("query")
    qtbot.keyPress(page.search.field, Qt.Key.Key_Return, Qt.KeyboardModifier.ShiftModifier)
    qtbot.waitUntil(lambda: not page.search.is_searching)
    assert [index.row() for index in page.table.selectionModel().selectedRows()] == [ROWS // 2]


def test_the_cache_of_the_search_is_bounded(qtbot: QtBot, page: TrafficPage, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(traffic, "_MAX_KNOWN", 3)
    page.search.field.setText("query")
    page.search.find_next()
    while page.search.is_searching:
        assert len(page.search._known) <= 3
        QApplication.processEvents()
    assert page.search._place == ROWS // 2


def test_selecting_all_asks_for_no_more_than_is_in_sight(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A header asks for each row whether it is selected: 10 s for a million rows."""
    asked: list[int] = []

    def flags(model: TrafficModel, index: QModelIndex | QPersistentModelIndex) -> Qt.ItemFlag:
        asked.append(index.row())
        return super(TrafficModel, model).flags(index)

    monkeypatch.setattr(TrafficModel, "flags", flags, raising=False)
    with window(qapp, tmp_path, entries=TRAFFIC_ALONE) as assembly:
        page = show_page(qtbot, assembly.window, "traffic", TrafficPage)
        page.show_recorded(capture())
        asked.clear()
        page.table.selectAll()
        page.table.grab()
        QApplication.processEvents()
        assert len(asked) < ROWS / 2
        assert page.detail.text() == f"{ROWS:,} selected"


@pytest.mark.parametrize("wanted", [Filter.ALL, Filter.WITHOUT_STREAM])
def test_rows_are_copied_as_they_are_shown(qapp: QApplication, wanted: Filter) -> None:
    model = TrafficModel()
    rows = capture(50)
    model.show_recorded(rows)
    model.use_filter(wanted)

    def line(number: int) -> str:
        cells = (model.index(number, column).data() for column in range(4))
        return "\t".join(cells)

    numbers: Sequence[int] = range(model.rowCount())
    assert model.as_text(numbers).split("\n") == [line(number) for number in numbers]
    assert len(numbers) == (50 if wanted is Filter.ALL else 1)


def test_rows_of_equal_text_have_equal_keys() -> None:
    rows = capture(100)
    for one in range(100):
        for other in range(100):
            is_same = (rows[one].way, rows[one].piece.raw) == (rows[other].way, rows[other].piece.raw)
            assert (rows.same_text_key(one) == rows.same_text_key(other)) is is_same
