"""The traffic table: rows, filter and search, scrolling, copying."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from PySide6.QtCore import QAbstractItemModel, Qt
from PySide6.QtWidgets import QApplication, QWidget
from pytestqt.qtbot import QtBot

from protocol.catalogue import BY_NAME
from protocol.events import Event, Received, Rejected, Role, Sent
from protocol.messages import Direction, Frame, Status, decode
from protocol.stream import StreamParser
from tests.support.window.fakes_ui import connect, page_entries, simulated, window
from tests.support.window.steps import show_page
from ui.pages.diagnosis.page import DiagnosisPage
from ui.pages.diagnosis.traffic import MAX_ROW_BYTES, MAX_ROWS, Column, Filter, TrafficModel, TrafficView

STREAMED = Status(7, 1.0, triggered=False, active=False).encode()


def streamed(count: int, first: int = 0) -> list[Event]:
    frame = Frame(Direction.MODULE_TO_HOST, STREAMED)
    return [Received(frame, decode(STREAMED), Role.STREAMED, float(first + number)) for number in range(count)]


def rejected(raw: bytes) -> list[Event]:
    parser = StreamParser()
    return [Rejected(piece, 1.0) for piece in (*parser.feed(raw), *parser.flush()) if not isinstance(piece, Frame)]


def sent(name: str = "cell_voltage", attempt: int = 1) -> Sent:
    request = BY_NAME[name].query()
    return Sent(request.encode(), request, attempt, 1.0)


def cell(model: QAbstractItemModel, row: int, column: Column) -> str:
    return str(model.index(row, column).data())


def model_of(*events: Event) -> TrafficModel:
    model = TrafficModel()
    model.append(events)
    model.show_new()
    return model


def feed(traffic: TrafficView, *events: Event) -> None:
    traffic.model.append(events)
    traffic.draw()


@pytest.fixture
def traffic(qtbot: QtBot) -> Iterator[TrafficView]:
    """Alone in a window."""
    around = QWidget()
    qtbot.addWidget(around)
    view = TrafficView()
    view.setParent(around)
    around.resize(900, 620)
    view.resize(900, 620)
    around.show()
    around.activateWindow()
    qtbot.waitUntil(around.isActiveWindow)
    yield view
    around.close()


def test_a_row_describes_its_frame_or_why_bytes_are_none(qapp: QApplication) -> None:
    voltage = bytes.fromhex("4175 34 01 BE F3")
    frame = Frame(Direction.MODULE_TO_HOST, voltage)
    model = model_of(sent(), Received(frame, decode(voltage, BY_NAME["cell_voltage"].query()), Role.ANSWER, 1.01))
    assert cell(model, 0, Column.KIND) == "sent"
    assert cell(model, 0, Column.BYTES) == "42 61 34 01 00 35"
    assert cell(model, 1, Column.KIND) == "reply"
    assert cell(model, 1, Column.MEANING) == "reply: cell voltage 3.80 V"
    model = model_of(*rejected(bytes(STREAMED[:-1] + bytes((STREAMED[-1] ^ 1,)))))
    index = model.index(0, Column.KIND)
    assert index.data() == "invalid"
    assert not index.data(Qt.ItemDataRole.DecorationRole).isNull()
    assert index.data(Qt.ItemDataRole.ForegroundRole) is not None
    assert "checksum" in cell(model, 0, Column.MEANING)


def test_the_oldest_rows_are_dropped(qapp: QApplication) -> None:
    model = model_of(*streamed(MAX_ROWS - 1))
    model.append(streamed(11, first=MAX_ROWS))
    model.show_new()
    assert (model.rowCount(), model.rows[0].at, model.rows[-1].at) == (MAX_ROWS, 10.0, MAX_ROWS + 10)


def test_a_long_run_of_garbage_takes_several_rows_and_loses_nothing(qapp: QApplication) -> None:
    garbage = bytes(range(48)) * 100
    model = model_of(*rejected(garbage))
    raws = [event.noise.raw for event in model.rows if isinstance(event, Rejected)]
    assert len(raws) > 1
    assert b"".join(raws) == garbage
    assert max(map(len, raws)) <= MAX_ROW_BYTES


def test_filter_and_search(traffic: TrafficView) -> None:
    voltage = bytes.fromhex("4175 34 01 BE F3")
    answer = decode(voltage, BY_NAME["cell_voltage"].query())
    reply = Received(Frame(Direction.MODULE_TO_HOST, voltage), answer, Role.ANSWER, 1.0)
    feed(traffic, sent(), reply, *streamed(10), *rejected(b"\x00\x01"))
    for kind, query, count in (
        (Filter.ALL, "", 13),
        (Filter.WITHOUT_STREAM, "", 3),
        (Filter.REJECTED, "", 1),
        (Filter.ALL, "41 75", 11),
        (Filter.ALL, "4175", 11),
        (Filter.ALL, "Tilt 7", 10),
        (Filter.ALL, "query: cell", 1),
        (Filter.WITHOUT_STREAM, "tilt 7", 0),
        (Filter.ALL, "nowhere", 0),
    ):
        traffic.filter.setCurrentIndex(traffic.filter.findData(kind))
        traffic.search.setText(query)
        assert traffic.shown.rowCount() == count, (kind, query)
        assert traffic.count.text() == (f"rows: {count}" if count else "No matches")
    feed(traffic, *rejected(b"\x02"))
    assert traffic.shown.rowCount() == 0
    traffic.search.clear()
    assert traffic.shown.rowCount() == 14


def test_frames_of_a_real_exchange_appear_and_another_module_ends_a_search(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path
) -> None:
    with simulated("frames"), window(qapp, tmp_path, entries=page_entries("diagnosis")) as assembly:
        page = show_page(qtbot, assembly.window, "diagnosis", DiagnosisPage)
        page.go_to("traffic")
        traffic = page.traffic
        connect(qtbot, assembly, "sim://frames")

        def column(wanted: Column) -> set[str]:
            return {cell(traffic.shown, row, wanted) for row in range(traffic.shown.rowCount())}

        qtbot.waitUntil(lambda: {"sent", "reply"} <= column(Column.KIND))
        qtbot.waitUntil(lambda: "heartbeat" in column(Column.MEANING))
        qtbot.keyClick(assembly.window, Qt.Key.Key_F, Qt.KeyboardModifier.ControlModifier)
        assert traffic.search.hasFocus()
        traffic.search.setText("nowhere")
        assembly.ports.choose(assembly.ports.add())
        assert (traffic.count.text(), traffic.search.text()) == ("rows: 0", "")


def test_the_list_scrolls_only_from_its_end(qtbot: QtBot, traffic: TrafficView) -> None:
    bar = traffic.table.verticalScrollBar()
    feed(traffic, *streamed(200))
    qtbot.waitUntil(lambda: bar.maximum() > 0 and bar.value() == bar.maximum())
    before = bar.maximum()
    traffic.resize(900, 520)
    qtbot.waitUntil(lambda: bar.value() == bar.maximum() > before)
    before = bar.maximum()
    feed(traffic, *streamed(50))
    qtbot.waitUntil(lambda: bar.value() == bar.maximum() > before)
    bar.setValue(100)
    feed(traffic, *streamed(1234))
    QApplication.processEvents()
    assert (bar.value(), traffic.count.text()) == (100, "1,234 new")
    bar.setValue(bar.maximum())
    qtbot.waitUntil(lambda: traffic.shown.rowCount() == 1484)


def test_the_visible_rows_stay_in_place_when_old_rows_are_dropped(qtbot: QtBot, traffic: TrafficView) -> None:
    feed(traffic, *streamed(MAX_ROWS))
    bar = traffic.table.verticalScrollBar()
    qtbot.waitUntil(lambda: bar.maximum() > 0 and bar.value() == bar.maximum())
    bar.setValue(bar.maximum() // 2)
    top = traffic.model.rows[traffic.table.rowAt(0)]
    feed(traffic, *streamed(100, first=MAX_ROWS))
    assert traffic.model.rows[traffic.table.rowAt(0)] is top
    bar.setValue(0)
    traffic.begin_again()
    QApplication.processEvents()
    feed(traffic, *streamed(2))
    assert traffic.shown.rowCount() == 2, "an empty list is at its end"


def test_copy_and_detail(qtbot: QtBot, traffic: TrafficView) -> None:
    feed(traffic, *streamed(3), sent(), sent("boot_count"), sent("light"))
    traffic.filter.setCurrentIndex(traffic.filter.findData(Filter.WITHOUT_STREAM))
    traffic.table.selectRow(1)
    assert "42 61 23 01 00 24" in traffic.detail.text()
    qtbot.keyClick(traffic.table, Qt.Key.Key_C, Qt.KeyboardModifier.ControlModifier)
    (line,) = QApplication.clipboard().text().split("\n")
    assert line.split("\t")[1:] == ["sent", "42 61 23 01 00 24", "query: boot count"]
    traffic.table.clearSelection()
    qtbot.mouseClick(traffic.copy, Qt.MouseButton.LeftButton)
    assert len(QApplication.clipboard().text().split("\n")) == 3
    traffic.table.selectRow(1)
    traffic.filter.setCurrentIndex(traffic.filter.findData(Filter.REJECTED))
    assert "42 61 23 01 00 24" not in traffic.detail.text()
