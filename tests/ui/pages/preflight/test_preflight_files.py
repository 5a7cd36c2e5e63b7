"""The Pre-flight page: records that are dropped, past checks, and how it looks."""

from collections.abc import Callable
from pathlib import Path

import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QApplication, QComboBox, QLineEdit, QWidget
from pytestqt.qtbot import QtBot

from app.records.record import as_text
from app.records.verification import RecordState, verify_file
from app.stations.station import fingerprint_of
from app.text.i18n import CHINESE, ENGLISH, tr
from tests.app.records.test_record import checked_record
from tests.support.records.stations_made import station
from tests.support.window.preflight_window import find_in, name_module, on_bench, said
from tests.support.window.steps import choosing
from ui.pages.preflight.controller import Standing
from ui.pages.preflight.verdict import Announcement, VerdictBanner
from ui.style.theme import Meaning


def test_a_dropped_record_is_intact_or_altered(qtbot: QtBot, qapp: QApplication, tmp_path: Path, quick: None) -> None:
    with on_bench(qtbot, qapp, tmp_path, "drop") as bench:
        page = bench.preflight
        assert bench.check() is Standing.READY
        target = tmp_path / "report.pdf"
        page.files.ask_path = choosing(target)
        bench.click(page.buttons.print)
        bench.assembly.window.go_to("triggers")
        bench.drop(target)
        qtbot.waitUntil(lambda: "INTACT" in said(bench))
        assert bench.assembly.window.navigation.chosen == "preflight"
        record = target.with_suffix(".json")
        record.write_text(record.read_text(encoding="utf-8").replace('"measured": 3.9', '"measured": 4.1'), "utf-8")
        bench.drop(record)
        qtbot.waitUntil(lambda: "ALTERED: the content" in said(bench))
        assert page.strip.notice is not None
        assert page.strip.notice.meaning is Meaning.DANGER
        nonsense = tmp_path / "x.json"
        nonsense.write_text("[" * 100_000, encoding="utf-8")
        bench.drop(nonsense)
        qtbot.waitUntil(lambda: "No pre-flight record" in said(bench))
        bench.drop(tmp_path / "gone.pdf")
        qtbot.waitUntil(lambda: "cannot be read" in said(bench))


def test_a_station_is_trusted_and_forgotten(qtbot: QtBot, qapp: QApplication, tmp_path: Path, quick: None) -> None:
    record = tmp_path / "theirs.json"
    record.write_text(as_text(checked_record()), "utf-8")
    asked: list[str] = []

    def answer(_parent: QWidget, _title: str, label: str, then: Callable[[str], object]) -> None:
        asked.append(label)
        then("Hangar 2")

    with on_bench(qtbot, qapp, tmp_path, "trust", is_connected=False) as bench:
        page = bench.preflight
        page.files.ask_name = answer
        bench.drop(record)
        qtbot.waitUntil(lambda: "UNKNOWN STATION" in said(bench))
        assert page.strip.notice is not None
        assert page.strip.notice.meaning is Meaning.ATTENTION
        trust = page.strip.button("trust_station")
        assert trust is not None
        bench.click(trust)
        qtbot.waitUntil(lambda: "signed by Hangar 2" in said(bench))
        fingerprint = fingerprint_of(station().public)
        assert fingerprint in asked[0]
        bench.click(page.buttons.history)
        row = page.history.stations
        assert row.own.text().startswith("This station: ")
        assert row.known.currentText() == f"Hangar 2 · {fingerprint}"
        bench.click(row.forget)
        assert not row.forget.isEnabled()
        bench.drop(record)
        qtbot.waitUntil(lambda: "UNKNOWN STATION" in said(bench))


def test_past_checks_and_what_they_measured(qtbot: QtBot, qapp: QApplication, tmp_path: Path, quick: None) -> None:
    with on_bench(qtbot, qapp, tmp_path, "past", cell=3.6) as bench:
        page = bench.preflight
        name_module(bench, "M-07")
        bench.find(QLineEdit, "preflight_aircraft_edit").setText("H6-12")
        assert bench.check() is Standing.NO_GO
        bench.bench.set_cell(4.0)
        assert bench.check() is Standing.READY
        bench.click(page.buttons.history)
        history = page.history
        qtbot.waitUntil(lambda: [one.verdict for one in history.checks] == ["READY", "NO-GO"])
        assert history.trends["cell_voltage_v"].values == (3.6, 4.0)
        assert "3.60 V to 4.00 V" in history.trends["cell_voltage_v"].accessibleName()
        target = tmp_path / "again.pdf"
        page.files.ask_path = choosing(target)
        history.table.selectRow(1)
        bench.click(history.print)
        assert verify_file(target, find_station=find_in(bench)).state is RecordState.INTACT
        bench.click(page.buttons.history)
        box = bench.find(QComboBox, "check_history_filter")
        qtbot.waitUntil(lambda: box.findText("Aircraft: H6-12") >= 0)
        box.setCurrentIndex(box.findText("Aircraft: H6-12"))
        box.activated.emit(box.currentIndex())
        trend = history.trends["cell_voltage_v"]
        qtbot.waitUntil(lambda: trend.isHidden() and len(history.checks) == 2)
        bench.assembly.language_switch.use(CHINESE)
        qtbot.waitUntil(lambda: box.currentText() == tr("Aircraft: {name}", name="H6-12") != "Aircraft: H6-12")
        assert not history.stations.own.text().startswith("This station")
        bench.assembly.language_switch.use(ENGLISH)
        qtbot.waitUntil(lambda: (box.currentText(), len(history.checks)) == ("Aircraft: H6-12", 2))
        qtbot.keyClick(page, Qt.Key.Key_Escape)
        assert page.buttons.isVisible()


# Looks


def test_without_a_module_nothing_can_be_checked(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with on_bench(qtbot, qapp, tmp_path, "none", is_connected=False) as bench:
        page = bench.preflight
        assert not page.buttons.run.isEnabled()
        assert "Connect a module" in page.banner.accessibleName()
        assert {row.chip.word for row in page.list.rows.values()} == {"not checked"}


@pytest.mark.parametrize("standing", list(Standing))
def test_each_standing_looks_different_without_colour(qtbot: QtBot, qapp: QApplication, standing: Standing) -> None:
    """Word and shape alone tell them apart: compared in grey, and by their words."""
    pictures = {}
    for other in Standing:
        banner = VerdictBanner(Announcement(other, ""))
        qtbot.addWidget(banner)
        banner.resize(640, 128)
        pictures[other] = banner.grab().toImage().convertToFormat(banner.grab().toImage().Format.Format_Grayscale8)
    assert all(pictures[standing] != pictures[other] for other in Standing if other is not standing)
