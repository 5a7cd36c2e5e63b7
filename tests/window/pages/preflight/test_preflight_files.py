"""The Pre-flight page: records that are dropped, past checks, how it looks; the profile edited
in the window: loaded, validated, saved, used."""

from pathlib import Path

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QApplication, QComboBox, QGraphicsItem, QLineEdit
from pytestqt.qtbot import QtBot

from app.preflight.verdict import Verdict
from app.records.verification import RecordState, verify_file
from app.store.rows import PreflightCheck
from tests.support.window.fakes_ui import store_of
from tests.support.window.preflight_window import NOBODY, OnBench, confirm_name, name_module, on_bench, said
from tests.support.window.steps import choosing, given
from ui.session.check import Standing
from ui.style.theme import Meaning


def test_a_dropped_record_is_intact_or_altered(tmp_path: Path, rig: OnBench) -> None:
    page = rig.preflight
    assert rig.check() is Standing.READY
    target = tmp_path / "report.pdf"
    page.ask_path = choosing(target)
    rig.click(page.export)
    rig.until(lambda: not page.result.is_writing)
    rig.assembly.window.go_to("triggers")
    rig.drop(target)
    rig.until(lambda: "INTACT" in said(rig))
    assert rig.assembly.window.navigation.chosen == "preflight"
    record = target.with_suffix(".json")
    record.write_text(record.read_text(encoding="utf-8").replace('"measured":3.9', '"measured":4.1'), "utf-8")
    rig.drop(record)
    rig.until(lambda: "ALTERED" in said(rig))
    assert given(page.strip.notice).meaning is Meaning.DANGER
    nonsense = tmp_path / "x.json"
    nonsense.write_text("[" * 100_000, encoding="utf-8")
    rig.drop(nonsense)
    rig.until(lambda: "No pre-flight record" in said(rig))
    rig.drop(tmp_path / "gone.pdf")
    rig.until(lambda: "cannot be read" in said(rig))
    for path in (target, nonsense):  # the second while the first is still being read
        page.open_file(path)
    rig.until(lambda: "No pre-flight record" in said(rig))


def test_a_simulated_module_of_this_name_passes_for_no_check_of_it(tmp_path: Path, rig: OnBench) -> None:
    history = rig.preflight.past
    store = store_of(rig.assembly.storage)
    for cell_v, is_void, is_simulated in ((4.0, False, False), (1.0, False, True), (2.0, True, False)):
        check = PreflightCheck(
            verdict="GO", is_void=is_void, is_simulated=is_simulated, cell_voltage_v=cell_v, document="{}"
        )
        store.add(check, "M-07").result()
    name_module(rig, "M-07")
    rig.until(lambda: "M-07" in rig.assembly.ports.known_names())
    rig.preflight.show_view("past")
    rig.until(lambda: len(history.checks) == 3)
    shown = [history.table.model().index(row, 1).data() for row in range(3)]
    assert shown == ["GO (void)", "GO (simulated)", "GO"]
    assert history.trend.values == (4.0,)


def test_what_has_no_name_makes_no_curve(rig: OnBench) -> None:
    """It may be of several modules."""
    store, history = store_of(rig.assembly.storage), rig.preflight.past
    for cell_v in (4.0, 3.6):
        check = PreflightCheck(verdict="GO", is_void=False, is_simulated=False, cell_voltage_v=cell_v, document="{}")
        store.add(check).result()
    rig.preflight.show_view("past")
    rig.until(lambda: len(history.checks) == 2)
    assert history.trend.values == ()


def test_what_was_typed_last_is_on_the_report(tmp_path: Path, rig: OnBench) -> None:
    """Also where the field still has the focus: the report waits for the record that says it."""
    page, target = rig.preflight, tmp_path / "report.pdf"
    assert rig.check() is Standing.READY
    page.ask_path = choosing(target)
    rig.find(QLineEdit, "preflight_aircraft").setText("H6-12")
    rig.click(page.export)
    rig.until(lambda: "Saved to" in said(rig))
    record = given(verify_file(target, NOBODY).record)
    assert (record.aircraft, record.verdict) == ("H6-12", Verdict.READY)
    assert page.work.standing is Standing.READY


def test_past_checks_and_what_they_measured(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with on_bench(qtbot, qapp, tmp_path, "past", "preflight", cell=3.6) as bench:
        page = bench.preflight
        name_module(bench, "M-07")
        bench.find(QLineEdit, "preflight_aircraft").setText("H6-12")
        assert bench.check() is Standing.NO_GO
        bench.bench.set_world(cell_v=4.0)
        assert bench.check() is Standing.READY
        page.show_view("past")
        history = page.past
        bench.until(lambda: [check.verdict for check in history.checks] == ["READY", "NO-GO"])
        assert history.trend.values == (3.6, 4.0)
        assert "3.60 V to 4.00 V" in history.trend.accessibleName()
        axes = history.trend.axes.values()  # a kept picture cut off the first figure of the labels
        assert {axis.cacheMode() for axis in axes} == {QGraphicsItem.CacheMode.NoCache}
        target = tmp_path / "again.pdf"
        page.ask_path = choosing(target)
        history.table.selectRow(1)
        bench.click(history.export)
        bench.until(lambda: not page.result.is_writing)
        assert verify_file(target, NOBODY).state is RecordState.INTACT
        page.show_view("past")
        box = bench.find(QComboBox, "past_checks_filter")
        assert box.currentText() == "Module: M-07"
        box.setCurrentText("Unnamed")
        box.activated.emit(box.currentIndex())
        bench.until(lambda: history.checks == ())
        qtbot.keyClick(page, Qt.Key.Key_Escape)
        assert page.view == "checks"


def test_an_aircraft_is_entered_for_its_own_module_only(rig: OnBench) -> None:
    aircraft = rig.find(QLineEdit, "preflight_aircraft")
    aircraft.setText("H6-12")
    name_module(rig, "M-07")
    rig.check()
    assert aircraft.text() == "H6-12"
    name_module(rig, "M-08")
    assert (aircraft.text(), rig.preflight.form.committed[1]) == ("", "")
    name_module(rig, "M-07")
    assert (aircraft.text(), rig.preflight.form.committed[1]) == ("H6-12", "H6-12")
    rig.bench.unplug()
    rig.until(lambda: not rig.assembly.ports.current.is_open)
    rig.bench.plug()
    rig.until(lambda: not rig.assembly.ports.current.module.name)
    assert aircraft.text() == ""
    confirm_name(rig)
    assert (aircraft.text(), rig.preflight.form.committed[1]) == ("H6-12", "H6-12")
    rig.assembly.ports.current.treat_as_another()
    rig.until(lambda: not rig.assembly.ports.module.name)
    assert (aircraft.text(), rig.preflight.form.committed[1]) == ("", "")
