"""The Triggers page: no, one, nine and ten records; names, judgements, search, CSV."""

import csv
import io
from pathlib import Path

import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QApplication, QLineEdit
from pytestqt.qtbot import QtBot

from app.preflight.verdict import Standing
from app.store.rows import Judgement
from tests.support.line.frames import lose
from tests.support.window.desk import choose, confirm_name, desk
from tests.support.window.rig import Rig
from tests.support.window.steps import choosing, given, notice_text
from ui.pages.triggers.page import COLUMNS
from ui.style.theme import Meaning

CELL, JUDGED = 6, 7
EXAMPLE = bytes.fromhex("01 00 6C 02 3C 05 A0 00 01 03 EB".replace(" ", ""))
"""D4 to D14 of the vendor's worked example."""


def name_kept(bench: Rig, name: str) -> None:
    bench.assembly.ports.module.name_it(name)
    bench.until(lambda: not bench.triggers.work.is_busy)


def read(bench: Rig) -> None:
    """Until it is kept, too."""
    bench.read_triggers()
    bench.until(lambda: not bench.triggers.work.is_busy)


def texts(bench: Rig, row: int) -> list[str]:
    return [str(bench.triggers.table.filter.index(row, column).data()) for column in range(len(COLUMNS))]


def told(bench: Rig, row: int) -> str:
    return str(bench.triggers.table.filter.index(row, 0).data(Qt.ItemDataRole.ToolTipRole))


def said(bench: Rig) -> str:
    return notice_text(bench.triggers.strip)


def fire(bench: Rig, number: int = 1) -> None:
    """Trigger records of the worked example, as if it had fired."""
    bench.bench.module.memory.records.extend([EXAMPLE] * number)


def note(bench: Rig, row: int, text: str) -> None:
    page = bench.triggers
    page.table.selectRow(row)
    page.detail.note.setText(text)
    page.detail.note.editingFinished.emit()


# Reading


@pytest.mark.module(is_connected=False)
def test_without_a_module_of_one_that_never_fired_and_of_a_silent_one(one: Rig) -> None:
    page, empty = one.triggers, one.triggers.list.empty
    assert "Connect or choose" in empty.text.text()
    assert (page.read.isEnabled(), page.export.isEnabled()) == (False, False)
    assert (page.count.text(), empty.title.text()) == ("Trigger records", "Not read yet")  # no number yet
    one.connect()
    assert "as soon as the module answers" in empty.text.text()
    one.read_triggers()
    assert "has never fired" in empty.text.text()
    assert (page.count.text(), empty.title.text()) == ("Trigger records", "Trigger records: 0")
    assert one.acts == []
    one.bench.change(mute=True)
    one.read_triggers()
    assert said(one) == "The module was silent for a moment. Not kept."
    assert (page.list.isEnabled(), page.read.isEnabled()) == (False, False), "greyed until a module answers"


@pytest.mark.module("triggers", "preflight")
def test_a_silent_module_is_told_from_one_that_had_records(one: Rig) -> None:
    empty = one.triggers.list.empty
    end = lose(one.bench, 0x35)
    one.read_triggers()
    assert (said(one), empty.text.text()) == ("No answer: the records are unknown.", "")
    one.triggers.work.job.dismiss()
    assert (empty.title.text(), empty.text.text()) == ("Unknown", "No answer: the records are unknown.")
    name_kept(one, "M-07")
    assert said(one) == "No answer: the records are unknown."
    end()
    fire(one, 3)
    read(one)
    lose(one.bench, 0x35)
    one.read_triggers()
    assert said(one) == "No answer: the records are unknown."
    assert one.check() is Standing.NO_GO


@pytest.mark.promise("g")
@pytest.mark.module(reads_triggers=True, active=True)
def test_the_records_are_read_once_in_sight_and_again_after_a_trigger(one: Rig) -> None:
    """With queries only, without a click, and not again after a cancel."""
    page = one.triggers
    one.until(lambda: page.work.reading is not None and not page.work.is_busy)
    page.work.reading = None  # as after a cancel
    page.work.read_unasked()
    assert not page.work.is_busy
    one.bench.set_world(tilt_deg=80)
    one.until(lambda: page.count.text() == "Trigger records: 1")
    assert one.acts == []


@pytest.mark.module(boots=37)
def test_what_was_read_is_not_taken_for_the_records_of_what_answers_later(one: Rig) -> None:
    page = one.triggers
    fire(one, 2)
    one.read_triggers()
    assert page.count.text() == "Trigger records: 2"
    one.bench.module.memory.boot_count = 11
    one.bench.restart()
    one.until(lambda: page.work.reading is None and page.count.text() == "Trigger records")
    fire(one)
    one.until(lambda: one.port.module.is_going)
    one.read_triggers()
    assert page.count.text() == "Trigger records: 3"
    assert one.acts == []


@pytest.mark.module(history=4)
def test_an_unconfirmed_reading_is_reported_and_one_can_be_cancelled(one: Rig) -> None:
    one.bench.change(lag_ms=300.0)
    one.click(one.triggers.read)
    choose(one, "cancel", one.triggers.strip)
    one.until(lambda: not one.triggers.work.is_busy)
    assert said(one).startswith("Cancelled")
    assert one.triggers.work.reading is None
    one.bench.change(lag_ms=0.0, corrupt=0.05)
    one.read_triggers()
    assert "The readings differ" in said(one)
    assert given(one.triggers.strip.notice).meaning is Meaning.ATTENTION


# What is shown


def test_the_worked_example_as_a_row_and_a_sentence(one: Rig) -> None:
    fire(one)
    one.read_triggers()
    page = one.triggers
    assert page.count.text() == "Trigger records: 1"
    assert texts(one, 0) == [
        "1 min 48 s · boot 1", "attitude", "60° 0.5 g 1.60 s", "yes", "no", "0.3 V",
        "4.70 V", "—",
    ]  # fmt: skip
    assert told(one, 0) == (
        "tipped past 60° 1 min 48 s after power-on of boot 1, serial link connected, 4.70 V (implausible)"
    )
    cell_voltage = page.table.filter.index(0, CELL)
    assert cell_voltage.data(Qt.ItemDataRole.DecorationRole) is not None, "marked, as it is implausible"
    page.table.selectRow(0)
    assert page.detail.cause.text().startswith("Tipped past 60° 1 min 48")
    assert not page.detail.bytes.isVisible()
    one.click(page.detail.raw)
    assert EXAMPLE.hex(" ").upper() in page.detail.bytes.text()
    assert said(one).startswith("Name the module")
    assert not page.detail.note.isEnabled()


def test_another_module_under_the_same_name_is_not_mixed_in(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with desk(qtbot, qapp, tmp_path, "triggers", name="first", history=3, boots=37) as bench:
        name_kept(bench, "M-07")
        bench.read_triggers()
        assert bench.triggers.count.text() == "Trigger records: 3"
    with desk(qtbot, qapp, tmp_path, "triggers", name="second", history=2, boots=12, seed=9) as bench:
        page = bench.triggers
        name_kept(bench, "M-07")
        bench.read_triggers()
        assert said(bench) == "Name the module to keep these records."
        confirm_name(bench)
        bench.until(lambda: not bench.triggers.work.is_busy)
        assert said(bench) == "Not kept. M-07: the records do not follow those of its last visit"
        assert page.count.text() == "Trigger records: 2"  # what was read, not what M-07 had
        number = bench.assembly.ports.module.number
        choose(bench, "another_module", bench.triggers.strip)
        bench.until(lambda: bench.assembly.ports.module.number > number and bench.assembly.ports.module.is_read)
        assert bench.assembly.ports.module.name == ""
        assert bench.assembly.window.notice_bar.button("name_same") is None, "a person has just said that it is not"
        name_kept(bench, "M-07")
        read(bench)
        choose(bench, "same_module", bench.triggers.strip)
        bench.until(lambda: page.count.text() == "Trigger records: 5")


# What a person does


@pytest.mark.module("triggers", "preflight", history=1)
def test_the_notice_leads_to_the_box_for_the_name(one: Rig) -> None:
    one.read_triggers()
    one.click(given(one.triggers.strip.button("name_it")))
    one.until(one.preflight.form.name_field.isVisible)


def test_a_judgement_and_a_note_are_kept(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with desk(qtbot, qapp, tmp_path, "triggers", name="judge") as bench:
        fire(bench)
        name_kept(bench, "M-07")
        bench.read_triggers()
        page = bench.triggers
        page.table.selectRow(0)
        bench.click(page.detail.buttons[Judgement.BENCH_TEST])
        assert texts(bench, 0)[JUDGED] == "bench test"
        page.detail.note.setFocus()
        qtbot.keyClicks(page.detail.note, "tipped on the table")
        qtbot.keyClick(page.detail.note, Qt.Key.Key_Return)
        assert "tipped on the table" in told(bench, 0)
        qtbot.keyClicks(page.detail.note, " twice")
        bench.assembly.window.close()
    with desk(qtbot, qapp, tmp_path, "triggers", name="judge") as bench:
        page = bench.triggers
        name_kept(bench, "M-07")  # known before it is read
        assert texts(bench, 0)[JUDGED] == "bench test"
        page.table.selectRow(0)
        assert page.detail.note.text() == "tipped on the table twice"
        assert "No longer" in page.detail.seen.text()
        bench.click(page.detail.buttons[None])
        assert texts(bench, 0)[JUDGED] == "—"


@pytest.mark.module(history=3)
def test_several_records_are_judged_at_once_and_keep_their_notes(one: Rig) -> None:
    name_kept(one, "M-07")
    one.read_triggers()
    page = one.triggers
    note(one, 0, "in the wind")
    page.table.selectAll()
    assert page.detail.cause.text() == "3 selected"
    assert not page.detail.note.isVisible()
    one.click(page.detail.buttons[Judgement.REAL])
    assert [texts(one, row)[JUDGED] for row in range(3)] == ["real"] * 3
    assert ["in the wind" in told(one, row) for row in range(3)] == [True, False, False]


@pytest.mark.module(history=5)
def test_what_is_searched_is_shown_sorted_and_saved(tmp_path: Path, one: Rig) -> None:
    fire(one)
    page = one.triggers
    name_kept(one, "=M-07")
    one.read_triggers()
    page.table.sortByColumn(CELL, Qt.SortOrder.AscendingOrder)
    volts = [row.record.cell_voltage_v for row in page.table.filter.shown()]
    assert volts == sorted(volts)
    note(one, 5, "=1+1")
    search = one.find(QLineEdit, "triggers_search")
    for searched, count in (("implausible 4.70", 1), ("", 6)):
        search.setText(searched)
        target = tmp_path / f"{count}.csv"
        page.ask_path = choosing(target)
        one.click(page.export)
        one.until(lambda: not page.work.job.is_busy)
        rows = list(csv.DictReader(io.StringIO(target.read_text("utf-8-sig"))))
        assert len(rows) == page.table.filter.rowCount() == count
        assert {row["module"] for row in rows} == {"'=M-07"}
        assert all(not row["note"].startswith("=") for row in rows)
        assert "Saved" in said(one)
    page.ask_path = choosing(tmp_path / "no folder" / "x.csv")
    one.click(page.export)
    one.until(lambda: "cannot be written" in said(one))
