"""The traffic list: rows, filters, pause, scrolling, copying and cost."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from app.engine.device import DeviceView
from app.engine.worker import Batch, Connection
from protocol.catalogue import BY_NAME, HEARTBEAT
from protocol.events import Event, OutcomeUnknown, Received, Rejected, Restarted, Role, Sent, Unanswered
from protocol.frame import Direction, Frame
from protocol.messages import Status, decode
from protocol.stream import StreamParser
from tests.support.window.fakes_ui import TRAFFIC_ALONE, connect, page_entries, simulated, window
from tests.support.window.steps import find, let_lay_out, show_page
from ui.pages.diagnosis.page import DiagnosisPage
from ui.pages.diagnosis.traffic import TrafficPage
from ui.pages.diagnosis.traffic_model import MAX_ROW_BYTES, MAX_ROWS, Column, Filter, TrafficModel
from ui.shell.page_area import PageMaker
from ui.style.theme import Choice, Space

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


def batch(events: list[Event]) -> Batch:
    return Batch(1.0, Connection(), DeviceView(), None, events=tuple(events))


def cell(model: TrafficModel, row: int, column: Column) -> str:
    return str(model.index(row, column.value).data())


@pytest.fixture
def traffic(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> Iterator[TrafficPage]:
    """Alone in a window."""
    with window(qapp, tmp_path, entries=TRAFFIC_ALONE) as assembly:
        found = show_page(qtbot, assembly.window, "traffic", TrafficPage)
        maker = find(assembly.window, PageMaker)
        qtbot.waitUntil(lambda: maker.is_done)
        QApplication.processEvents()
        yield found


def test_a_row_describes_its_frame(qapp: QApplication) -> None:
    model = TrafficModel()
    voltage = bytes.fromhex("4175 34 01 BE F3")
    frame = Frame(Direction.MODULE_TO_HOST, voltage)
    model.append([sent(), Received(frame, decode(voltage, BY_NAME["cell_voltage"].query()), Role.ANSWER, 1.01)])
    model.show_new()
    assert cell(model, 0, Column.KIND) == "sent"
    assert cell(model, 0, Column.BYTES) == "42 61 34 01 00 35"
    assert cell(model, 1, Column.KIND) == "reply"
    assert cell(model, 1, Column.MEANING) == "reply: cell voltage 3.80 V"


def test_rejected_bytes_have_icon_word_colour_and_reason(qapp: QApplication) -> None:
    model = TrafficModel()
    bad = bytes(STREAMED[:-1] + bytes((STREAMED[-1] ^ 1,)))
    model.append(rejected(bad))
    model.show_new()
    index = model.index(0, Column.KIND.value)
    assert index.data() == "invalid"
    assert not index.data(Qt.ItemDataRole.DecorationRole).isNull()
    assert index.data(Qt.ItemDataRole.ForegroundRole) is not None
    assert "checksum" in cell(model, 0, Column.MEANING)


@pytest.mark.parametrize(
    ("event", "word"),
    [
        (Unanswered(HEARTBEAT.query(), 3, 1.0, 1.0), "no reply"),
        (Unanswered(HEARTBEAT.query(), 0, 1.0, 1.0), "not sent"),
        (OutcomeUnknown(BY_NAME["activation"].set(False), 1.0, 1.0), "may have been carried out"),
        (Restarted(True, 1.0), "restarted"),
    ],
)
def test_events_of_the_link_are_rows(qapp: QApplication, event: Event, word: str) -> None:
    model = TrafficModel()
    model.append([event])
    model.show_new()
    assert word in cell(model, 0, Column.MEANING)


def test_filters(qapp: QApplication, qtbot: QtBot) -> None:
    model = TrafficModel()
    asked = Received(Frame(Direction.MODULE_TO_HOST, STREAMED), decode(STREAMED), Role.ANSWER, 1.0)
    model.append([sent(), asked, *streamed(10), *rejected(b"\x00\x01")])
    model.show_new()
    assert model.rowCount() == 13
    model.use_filter(Filter.WITHOUT_STREAM)
    assert model.rowCount() == 3
    model.use_filter(Filter.REJECTED)
    assert [cell(model, row, Column.KIND) for row in range(model.rowCount())] == ["invalid"]
    model.append([*streamed(5), *rejected(b"\x02")])
    model.show_new()
    assert model.rowCount() == 2
    model.use_filter(Filter.ALL)
    assert model.rowCount() == 19
    model.use_filter(Filter.MARKED)
    model.append(streamed(3))
    with qtbot.assertNotEmitted(model.rowsInserted):
        model.show_new()
    assert (model.rowCount(), model.unseen) == (0, 3)


def test_the_oldest_rows_are_dropped(qapp: QApplication) -> None:
    model = TrafficModel()
    model.append(streamed(MAX_ROWS - 1))
    model.show_new()
    model.append(streamed(11, first=MAX_ROWS))
    assert model.show_new() == 10
    assert model.rowCount() == MAX_ROWS
    assert model.rows[0].at == 10.0
    assert model.rows[MAX_ROWS - 1].at == MAX_ROWS + 10


def test_a_long_run_of_garbage_takes_several_rows_and_loses_nothing(qapp: QApplication) -> None:
    model = TrafficModel()
    garbage = bytes(range(48)) * 100
    events = rejected(garbage)
    model.append(events)
    model.show_new()
    assert model.rowCount() > 1
    raws = [event.noise.raw for row in range(model.rowCount()) if isinstance(event := model.rows[row], Rejected)]
    assert b"".join(raws) == garbage
    assert max(map(len, raws)) <= MAX_ROW_BYTES


def test_frames_of_a_real_exchange_appear(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with simulated("frames"), window(qapp, tmp_path, entries=TRAFFIC_ALONE) as assembly:
        traffic = show_page(qtbot, assembly.window, "traffic", TrafficPage)
        connect(qtbot, assembly, "sim://frames")

        def column(wanted: Column) -> set[str]:
            return {cell(traffic.model, row, wanted) for row in range(traffic.model.rowCount())}

        qtbot.waitUntil(lambda: {"sent", "reply"} <= column(Column.KIND))
        qtbot.waitUntil(lambda: "heartbeat" in column(Column.MEANING))


def test_pause_stops_the_list_and_loses_nothing(qtbot: QtBot, traffic: TrafficPage) -> None:
    traffic.on_batch(batch(streamed(5)))
    qtbot.waitUntil(lambda: traffic.model.rowCount() == 5)
    qtbot.keyClick(traffic.table, Qt.Key.Key_P, Qt.KeyboardModifier.ControlModifier)
    assert traffic.pause.isChecked()
    traffic.on_batch(batch(streamed(1234)))
    traffic.draw()
    assert (traffic.model.rowCount(), traffic._count.text()) == (5, "1,234 new")
    qtbot.mouseClick(traffic.pause, Qt.MouseButton.LeftButton)
    qtbot.waitUntil(lambda: traffic.model.rowCount() == 1239)


def test_the_list_scrolls_only_from_its_end(qtbot: QtBot, traffic: TrafficPage) -> None:
    bar = traffic.table.verticalScrollBar()
    traffic.on_batch(batch(streamed(200)))
    traffic.draw()
    qtbot.waitUntil(lambda: bar.maximum() > 0 and bar.value() == bar.maximum())
    before = bar.maximum()
    traffic.on_batch(batch(streamed(50)))
    traffic.draw()
    qtbot.waitUntil(lambda: bar.value() == bar.maximum() > before)
    bar.setValue(100)
    traffic.on_batch(batch(streamed(50)))
    traffic.draw()
    QApplication.processEvents()
    assert bar.value() == 100


def test_the_visible_rows_stay_in_place_when_old_rows_are_dropped(qtbot: QtBot, traffic: TrafficPage) -> None:
    traffic.on_batch(batch(streamed(MAX_ROWS)))
    traffic.draw()
    bar = traffic.table.verticalScrollBar()
    qtbot.waitUntil(lambda: bar.maximum() > 0 and bar.value() == bar.maximum())
    bar.setValue(bar.maximum() // 2)
    top = traffic.model.rows[traffic.table.rowAt(0)]
    traffic.on_batch(batch(streamed(100, first=MAX_ROWS)))
    traffic.draw()
    QApplication.processEvents()
    assert traffic.model.rows[traffic.table.rowAt(0)] is top


def test_it_stays_at_the_end_when_the_table_shrinks(qtbot: QtBot, traffic: TrafficPage) -> None:
    traffic.on_batch(batch(streamed(200)))
    traffic.draw()
    bar = traffic.table.verticalScrollBar()
    qtbot.waitUntil(lambda: bar.maximum() > 0 and bar.value() == bar.maximum())
    before = bar.maximum()
    traffic.window().resize(900, 520)
    qtbot.waitUntil(lambda: bar.maximum() > before)
    assert bar.value() == bar.maximum()


def test_copy_and_clear(qtbot: QtBot, traffic: TrafficPage) -> None:
    traffic.on_batch(batch([sent(), sent("boot_count"), sent("light")]))
    traffic.draw()
    traffic.table.selectRow(1)
    assert "42 61 23 01 00 24" in traffic.detail.text()
    qtbot.keyClick(traffic.table, Qt.Key.Key_C, Qt.KeyboardModifier.ControlModifier)
    lines = QApplication.clipboard().text().split("\n")
    assert len(lines) == 1
    assert lines[0].split("\t")[1:] == ["sent", "42 61 23 01 00 24", "query: boot count"]
    traffic.table.clearSelection()
    qtbot.mouseClick(traffic.copy, Qt.MouseButton.LeftButton)
    assert len(QApplication.clipboard().text().split("\n")) == 3
    qtbot.mouseClick(traffic.clear, Qt.MouseButton.LeftButton)
    assert traffic.model.rowCount() == 0


def test_filter_by_keyboard(qtbot: QtBot, traffic: TrafficPage) -> None:
    traffic.on_batch(batch([sent(), *streamed(3)]))
    traffic.draw()
    qtbot.keyClick(traffic.filter, Qt.Key.Key_Down)
    assert traffic.model.rowCount() == 1


def test_the_row_in_full_goes_with_its_selection(traffic: TrafficPage) -> None:
    traffic.on_batch(batch([sent(), *streamed(3)]))
    traffic.draw()
    traffic.table.selectRow(0)
    assert "42 61 34 01 00 35" in traffic.detail.text()
    traffic.filter.setCurrentIndex(traffic.filter.findData(Filter.REJECTED))
    assert "42 61 34 01 00 35" not in traffic.detail.text()


def test_another_module_ends_a_pause_and_a_search(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with window(qapp, tmp_path, entries=page_entries("diagnosis")) as assembly:
        traffic = show_page(qtbot, assembly.window, "diagnosis", DiagnosisPage).traffic
        traffic.on_batch(batch(streamed(5)))
        traffic.draw()
        traffic.pause.click()
        traffic.search.field.setText("nowhere")
        traffic.search.find_next()
        qtbot.waitUntil(lambda: traffic._count.text() == "No matches")
        assembly.connector.invalidated.emit()
        assert (traffic._count.text(), traffic.pause.isChecked()) == ("rows: 0", False)


def test_the_number_of_rows_is_readable_on_the_smallest_screen_in_sunlight(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path
) -> None:
    with window(qapp, tmp_path, entries=TRAFFIC_ALONE) as assembly:
        assembly.appearance.choose(Choice.SUNLIGHT)
        assembly.window.resize(960, 540)
        shown = show_page(qtbot, assembly.window, "traffic", TrafficPage)
        shown.on_batch(batch(streamed(1500)))
        shown.draw()
        let_lay_out(shown)
        assert shown._count.text() == "rows: 1,500"
        assert shown._count.width() >= shown._count.sizeHint().width()
        for width in (960, 1366):  # the arrows stay beside the field
            assembly.window.resize(width, 540)
            let_lay_out(shown)
            search = shown.search
            assert search.next.x() - search.field.geometry().right() <= Space.S
