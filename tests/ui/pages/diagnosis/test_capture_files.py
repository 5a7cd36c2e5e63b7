"""Captures in the window: search and marks, save and open, decoded without a module."""

import threading
from functools import partial
from pathlib import Path

import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from tests.support.records.recordings_desk import record
from tests.support.records.recordings_made import explained, read_session
from tests.support.window.capture_window import opened, strip_button, write_capture
from tests.support.window.fakes_ui import WAIT_MS, connect, simulated
from tests.support.window.steps import drop, given, press
from tests.ui.pages.diagnosis.test_diagnosis_page import diagnosis
from tests.ui.pages.diagnosis.test_traffic import cell, sent, streamed
from tests.ui.pages.recordings.test_recordings_looks import damage
from ui.core.background_task import ExportCancelled, Running
from ui.pages.diagnosis.files import SUFFIX, Opened, load_capture
from ui.pages.diagnosis.page import DiagnosisPage
from ui.pages.diagnosis.traffic import MAX_COPIED, hex_part, matches
from ui.pages.diagnosis.traffic_model import MAX_MARKS, MAX_ROWS, Column, Filter, TrafficModel

# Search and marks


def test_bytes_and_words_are_found() -> None:
    assert hex_part("41 75 3") == ""
    assert hex_part("41 75 3A") == "41753a"
    assert hex_part("tilt") == ""
    status = streamed(1)[0]
    assert matches(status, "41 75", "4175")
    assert matches(status, "tilt 7", "")
    assert matches(status, "stream", "")
    assert not matches(status, "boot count", "")


def test_search_wraps_around_and_reports_no_match(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with diagnosis(qtbot, qapp, tmp_path) as (assembly, page):
        traffic = page.traffic
        page.go_to("traffic")
        traffic.model.append([*streamed(3000), sent("light"), *streamed(2000), sent("boot_count")])
        traffic.draw()
        qtbot.keyClick(assembly.window, Qt.Key.Key_F, Qt.KeyboardModifier.ControlModifier)
        assert traffic.search.field.hasFocus()
        qtbot.keyClicks(traffic.search.field, "query")

        def found() -> list[int]:
            return [index.row() for index in traffic.table.selectionModel().selectedRows()]

        qtbot.waitUntil(lambda: found() in ([3000], [5001]))
        first = found()
        qtbot.keyClick(traffic.search.field, Qt.Key.Key_Return)
        qtbot.waitUntil(lambda: found() not in (first, []))
        qtbot.keyClick(traffic.search.field, Qt.Key.Key_Return)
        qtbot.waitUntil(lambda: found() == first)
        press(qtbot, traffic.search.before)
        qtbot.waitUntil(lambda: found() not in (first, []))
        traffic.search.field.clear()
        qtbot.keyClicks(traffic.search.field, "FF FF FF")
        qtbot.waitUntil(lambda: traffic._count.text() == "No matches")
        traffic.search.field.selectAll()
        qtbot.keyClicks(traffic.search.field, "query")
        qtbot.waitUntil(lambda: traffic._count.text() != "No matches")
        traffic.search.field.selectAll()
        qtbot.keyClicks(traffic.search.field, "FF FF FF")
        qtbot.waitUntil(lambda: traffic._count.text() == "No matches")
        traffic.search.field.selectAll()
        qtbot.keyClick(traffic.search.field, Qt.Key.Key_Delete)
        qtbot.waitUntil(lambda: traffic._count.text() != "No matches")


def test_marks_are_seen_filtered_and_outlive_the_list(qapp: QApplication) -> None:
    model = TrafficModel()
    model.append([sent("light"), *streamed(5)])
    model.show_new()
    model.mark([0, 2])
    assert model.is_marked(0)
    spoken = model.index(0, Column.TIME.value).data(Qt.ItemDataRole.AccessibleTextRole)
    assert "Marked" in spoken
    assert not model.index(0, Column.TIME.value).data(Qt.ItemDataRole.DecorationRole).isNull()
    assert model.index(1, Column.TIME.value).data(Qt.ItemDataRole.DecorationRole) is None
    model.mark([2])
    assert not model.is_marked(2)
    model.append(streamed(MAX_ROWS))
    model.show_new()
    model.use_filter(Filter.MARKED)
    assert model.rowCount() == 1
    assert "light" in cell(model, 0, Column.MEANING)
    model.mark([0])
    assert model.rowCount() == 0


def test_mark_by_key(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with diagnosis(qtbot, qapp, tmp_path) as (_assembly, page):
        page.go_to("traffic")
        page.traffic.model.append([sent("light"), sent("boot_count")])
        page.traffic.draw()
        page.traffic.table.selectRow(1)
        qtbot.keyClick(page.traffic.table, Qt.Key.Key_M, Qt.KeyboardModifier.ControlModifier)
        assert page.traffic.model.is_marked(1)
        press(qtbot, page.traffic.mark)
        assert not page.traffic.model.is_marked(1)


# Files


def test_what_a_damaged_session_lacks_is_said(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    damage(path := record(tmp_path / "kept"))
    with diagnosis(qtbot, qapp, tmp_path) as (_assembly, page):
        page.files.ask_open = lambda _parent, _folder, then: then(path)
        press(qtbot, page.files.open)
        qtbot.waitUntil(lambda: "Damaged or altered; left out" in page.strip.accessibleName())


def test_a_capture_is_decoded_without_a_module(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with opened(qtbot, qapp, tmp_path) as (_assembly, page, path):
        model = page.traffic.model
        rows = list(explained(read_session(path)))
        assert model.rowCount() == len(rows)
        assert page.traffic.isVisible()
        assert cell(model, 0, Column.TIME) == "0.000 s"
        assert cell(model, 0, Column.MEANING) == "heartbeat"
        assert cell(model, model.rowCount() - 1, Column.KIND) == "invalid"
        assert "active" in cell(model, 20, Column.MEANING)
        page.traffic.model.append(streamed(5))  # the live traffic is still stored
        page.traffic.draw()
        assert model.rowCount() == len(rows)
        page.go_to("figures")
        counted = {key: total.figure.text() for key, total in page.statistics.totals.items()}
        assert (counted["sent"], counted["rejected"], counted["lost"], counted["restarts"]) == ("6", "2", "—", "—")
        assert page.statistics.over_time._stretch.is_recorded
        over_time = page.statistics.over_time.accessibleName()
        assert "Without reply —" in over_time
        assert "restarts: —; port lost: —" in over_time
        press(qtbot, strip_button(page, "capture_leave"))
        assert page.statistics.totals["restarts"].figure.text() == "0"
        page.traffic.model.rebuild()
        assert model.rowCount() == 5
        assert not model.is_recorded


def _says(page: DiagnosisPage, text: str) -> bool:
    return text in page.strip.accessibleName()


def test_a_file_that_is_no_capture_is_refused_with_the_reason(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    (tmp_path / "empty.mcap").write_bytes(b"\x89MCAP0\r\n")
    (tmp_path / "empty.txt").write_bytes(b"")
    (tmp_path / "words.txt").write_bytes(b"0.1 > hello\n")
    (tmp_path / "other.txt").write_bytes(bytes(range(256)) * 20)
    with diagnosis(qtbot, qapp, tmp_path) as (_assembly, page):
        for name, said in {
            "empty.txt": "is empty", "words.txt": "words.txt cannot be read: no pairs of hex digits",
            "other.txt": "other.txt cannot be read: no pairs of hex digits",
            "missing.mcap": "missing.mcap cannot be read", "empty.mcap": "not a recording by this program",
        }.items():  # fmt: skip
            page.open_file(tmp_path / name)
            qtbot.waitUntil(partial(_says, page, said))
            assert page.opened is None


def test_text_is_opened_and_its_faults_are_reported(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    path = tmp_path / "pasted.hex"
    with diagnosis(qtbot, qapp, tmp_path) as (_assembly, page):
        for text, said in {
            "42 61 32 01 00 33\n41 75 32 07 0A 00 01 44\n": "Times are estimated",
            "0.1 > 42 61 32 01 00 33\n0.2 < 41 75 32 07 0A 00 01 44\nzz\n": "Line 3",
        }.items():
            path.write_text(text, encoding="utf-8")
            page.open_file(path)
            qtbot.waitUntil(partial(_says, page, said))
            assert page.traffic.model.rowCount() == 2


def test_all_rows_of_a_long_capture_are_shown_and_a_few_of_them_copied(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path
) -> None:
    path = write_capture(tmp_path / f"long{SUFFIX}", seconds=600)
    with diagnosis(qtbot, qapp, tmp_path) as (_assembly, page):
        page.open_file(path)
        qtbot.waitUntil(lambda: page.opened is not None)
        traffic = page.traffic
        assert traffic.model.rowCount() > MAX_COPIED + 1000
        traffic.table.selectAll()
        assert traffic.detail.text() == f"{traffic.model.rowCount():,} selected"
        qtbot.keyClick(traffic.table, Qt.Key.Key_C, Qt.KeyboardModifier.ControlModifier)
        assert len(QApplication.clipboard().text().split("\n")) == MAX_COPIED
        assert traffic.detail.text() == f"{MAX_COPIED:,} of {traffic.model.rowCount():,} rows copied."
        traffic.mark_rows()
        traffic.filter.setCurrentIndex(traffic.filter.findData(Filter.MARKED))
        assert traffic.model.rowCount() == MAX_MARKS


def test_marks_of_a_capture_stay_with_their_rows(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with opened(qtbot, qapp, tmp_path) as (_assembly, page, _path):
        model = page.traffic.model
        last = model.rowCount() - 1
        model.mark([0, last])
        assert model.is_marked(last)
        assert not model.is_marked(1)
        model.use_filter(Filter.REJECTED)
        assert model.rowCount() == 1
        assert model.is_marked(0)
        assert cell(model, 0, Column.KIND) == "invalid"
        model.mark([0])
        model.use_filter(Filter.MARKED)
        assert [cell(model, row, Column.MEANING) for row in range(model.rowCount())] == ["heartbeat"]
        model.use_filter(Filter.ALL)
        assert not model.is_marked(last)
        assert model.is_marked(0)


def test_opening_shows_progress_and_can_be_cancelled(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen, may_go_on = threading.Event(), threading.Event()

    def held(path: Path, running: Running) -> Opened:
        running.set_progress(0.43)
        seen.set()
        may_go_on.wait(WAIT_MS / 1000)
        return load_capture(path, running)

    monkeypatch.setattr("ui.pages.diagnosis.files.load_capture", held)
    path = write_capture(tmp_path / f"cancelled{SUFFIX}", seconds=100)
    with diagnosis(qtbot, qapp, tmp_path) as (_assembly, page):
        page.open_file(path)
        qtbot.waitUntil(lambda: "43 %" in page.strip.accessibleName())
        press(qtbot, strip_button(page, "cancel"))
        assert page.strip.accessibleName().endswith("Cancelled.")
        may_go_on.set()
        assert page.result._reading.wait(WAIT_MS / 1000)
        qapp.processEvents()
        assert page.opened is None


def test_opening_ends_with_the_window(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    begun, may_go_on, still_wanted = threading.Event(), threading.Event(), list[bool]()

    def held(_path: Path, running: Running) -> Opened:
        begun.set()
        may_go_on.wait(WAIT_MS / 1000)
        still_wanted.append(running.is_requested)
        raise ExportCancelled

    monkeypatch.setattr("ui.pages.diagnosis.files.load_capture", held)
    with diagnosis(qtbot, qapp, tmp_path) as (assembly, page):
        page.open_file(tmp_path / f"any{SUFFIX}")
        assert begun.wait(WAIT_MS / 1000)
        assembly.window.close_now()
        may_go_on.set()
        qtbot.waitUntil(lambda: bool(still_wanted))
    assert still_wanted == [False]


def test_a_capture_dropped_on_the_window_is_opened(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    path = write_capture(tmp_path / f"dropped{SUFFIX}", seconds=1)
    with diagnosis(qtbot, qapp, tmp_path) as (assembly, page):
        assert drop(assembly.window, path)
        qtbot.waitUntil(lambda: page.opened is not None)


def test_the_support_bundle_in_sight_is_made_again_for_another_module(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path
) -> None:
    with simulated("former"), diagnosis(qtbot, qapp, tmp_path) as (assembly, page):
        connect(qtbot, assembly, "sim://former")
        port, bundle = assembly.connector.current, page.bundle
        qtbot.waitUntil(lambda: "boot_count" in port.device.values, timeout=WAIT_MS)
        page.go_to("bundle")
        qtbot.waitUntil(lambda: bundle.bundle is not None and bundle.save.isEnabled(), timeout=WAIT_MS)
        former = given(bundle.bundle)
        bundle.parts.setCurrentRow([part.name for part in former.files].index("module.json"))
        assert "boot_count" in bundle.text.toPlainText()
        port.module.treat_as_new()
        for row in (0, bundle.parts.count() - 1):  # chosen while the next one is being made
            bundle.parts.setCurrentRow(row)
        assert (bundle.text.toPlainText(), bundle.save.isEnabled()) == ("", False)
        qtbot.waitUntil(bundle.save.isEnabled, timeout=WAIT_MS)
        assert bundle.bundle is not former
        bundle.parts.setCurrentRow([part.name for part in former.files].index("module.json"))
        assert "boot_count" not in bundle.text.toPlainText()
