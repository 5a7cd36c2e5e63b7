"""The Pre-flight page by real clicks on the simulated module: run, fail, repair, run again, print; what voids it."""

import json
import time
from collections.abc import Callable
from pathlib import Path

import pytest
from PySide6.QtCore import QRect, Qt
from PySide6.QtWidgets import QAbstractButton, QApplication, QComboBox, QLineEdit, QPushButton, QWidget
from pytestqt.qtbot import QtBot

from app.preflight.checks import CHECKS
from app.preflight.findings import Result
from app.preflight.verification import State, verify_file
from app.store.checks import CheckStore
from app.store.store import Store
from protocol.catalogue import BY_NAME
from tests.preflight_window import VERDICTS, OnBench, hurry, on_bench
from ui.preflight_row import CheckRow
from ui.preflight_work import Standing
from ui.theme import THEMES, Meaning, contrast
from ui.verdict import Announcement, VerdictBanner

PROFILE = """
format = 1
name = "Survey hexacopter"
[[manual]]
text = "Bridle free"
required = true
[[manual]]
text = "<b>Pack date</b>"
"""


@pytest.fixture
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    hurry(monkeypatch)


def kept(bench: OnBench, module: str = "") -> list[str]:
    store = bench.assembly.keeping.store
    assert isinstance(store, Store)
    module_id = next((one.id for one in store.modules() if one.name == module), None)
    return [one.verdict for one in CheckStore(store.database).checks(module_id)]


def said(bench: OnBench) -> str:
    notice = bench.preflight.strip.notice
    return "" if notice is None else notice.text


def name_module(bench: OnBench, name: str) -> None:
    edit = bench.find(QLineEdit, "preflight_module_edit")
    edit.setFocus()
    edit.clear()
    bench.qtbot.keyClicks(edit, name)
    bench.qtbot.keyClick(edit, Qt.Key.Key_Return)


def test_run_fail_repair_run_again_print(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with on_bench(qtbot, qapp, tmp_path, "repair", cell=3.6) as bench:
        page = bench.preflight
        assert page.banner.announcement.standing is Standing.NOT_CHECKED
        assert not page.buttons.print.isEnabled()
        name_module(bench, "M-07")
        assert bench.check(is_enabling=False) is Standing.NO_GO
        assert bench.acts == []  # questions only
        assert page.banner.announcement.word == "NO-GO"
        row = page.list.rows["cell_voltage"]
        assert (row.chip.word, row.measured.text(), row.limit.text()) == ("FAIL", "3.60 V", "at least 3.80 V")
        assert "Charge the module" in row.reason.text()
        assert row.chip.meaning is Meaning.DANGER
        assert page.list.rows["attitude_trigger"].chip.word == "UNKNOWN"
        assert all(name in page.banner.accessibleName() for name in ("Cell voltage", "Attitude trigger enabled"))
        bench.bench.set_cell(4.0)
        enable = page.list.rows["attitude_trigger"].act
        page.list.ensureWidgetVisible(enable)
        bench.click(enable)
        bench.wait_standing(Standing.GO, Standing.NO_GO)
        assert page.work.standing is Standing.GO, page.banner.accessibleName()
        assert [request.command for request in bench.acts] == [
            BY_NAME["attitude_trigger"], BY_NAME["freefall_trigger"],
        ]  # fmt: skip
        assert page.banner.announcement.word == "GO"
        assert kept(bench, "M-07") == ["GO", "NO-GO"]
        target = tmp_path / "report.pdf"
        page.files.ask_path = lambda *_: target
        bench.click(page.buttons.print)
        assert "report.pdf" in said(bench)
        for suffix in (".pdf", ".html", ".json"):
            assert verify_file(target.with_suffix(suffix)).state is State.INTACT
        record = json.loads(target.with_suffix(".json").read_text(encoding="utf-8"))
        assert (record["verdict"], record["module"], record["number"]) == ("GO", "M-07", 2)
        assert len(record["frames"]) > 60
        assert record["frames"][0][0] >= 0


# What voids it


def restart(bench: OnBench) -> None:
    bench.bench.restart()


def unplug(bench: OnBench) -> None:
    bench.bench.unplug()


def silence(bench: OnBench) -> None:
    bench.bench.power_off()


def open_bay(bench: OnBench) -> None:
    bench.bench.set_bay(is_open=True)


def plug_charger(bench: OnBench) -> None:
    bench.bench.set_charger(is_plugged_in=True)


def activate(bench: OnBench) -> None:
    bench.bench.module.activate(is_active=True)


def grow_old(bench: OnBench) -> None:
    bench.assembly.connector.clock = lambda: time.monotonic() + 901.0


def type_another_name(bench: OnBench) -> None:
    edit = bench.find(QLineEdit, "preflight_who")
    edit.setFocus()
    bench.qtbot.keyClicks(edit, "Li Wei")
    bench.qtbot.keyClick(edit, Qt.Key.Key_Return)


def name_it(bench: OnBench) -> None:
    name_module(bench, "M-08")


@pytest.mark.parametrize(
    ("act", "why"),
    [
        (restart, "the module restarted"),
        (unplug, "the port was lost"),
        (silence, "the module stopped answering"),
        (open_bay, "the module changed: Light"),
        (plug_charger, "the module changed: Charging"),
        (activate, "the module changed: Activation"),
        (grow_old, "too old"),
        (type_another_name, "the module changed: what is entered here"),
        (name_it, "the module changed: what is entered here"),
    ],
)
def test_what_voids_a_go(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path, quick: None, act: Callable[[OnBench], None], why: str
) -> None:
    with on_bench(qtbot, qapp, tmp_path, "void") as bench:
        page = bench.preflight
        assert bench.check() is Standing.GO, page.banner.accessibleName()
        act(bench)
        bench.wait_standing(Standing.VOID)
        one = page.banner.announcement
        assert (one.word, one.head) == ("VOID", why)
        assert "GO" not in page.banner.accessibleName()
        assert not page.buttons.print.isEnabled()
        assert page.work.record is None
        assert "void" in page.list.rows["tilt"].chip.accessibleName()


def test_a_void_check_stays_void(qtbot: QtBot, qapp: QApplication, tmp_path: Path, quick: None) -> None:
    with on_bench(qtbot, qapp, tmp_path, "stays") as bench:
        assert bench.check() is Standing.GO
        bench.bench.set_bay(is_open=True)
        bench.wait_standing(Standing.VOID)
        bench.bench.set_bay(is_open=False)
        qtbot.waitUntil(lambda: bench.assembly.connector.device.values["light_v"].value < 1.0, timeout=8000)
        bench.preflight.tick()
        assert bench.preflight.banner.announcement.standing is Standing.VOID


def test_a_check_that_is_cancelled_is_void_and_not_kept(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path, quick: None
) -> None:
    with on_bench(qtbot, qapp, tmp_path, "cancel") as bench:
        page = bench.preflight
        bench.click(page.buttons.run)
        qtbot.waitUntil(page.buttons.cancel.isVisible)
        bench.click(page.buttons.cancel)
        bench.wait_standing(Standing.VOID)
        assert page.banner.announcement.head == "interrupted"
        assert not page.buttons.print.isEnabled()
        assert kept(bench) == []


def test_unplugged_in_the_middle(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with on_bench(qtbot, qapp, tmp_path, "middle") as bench:
        page = bench.preflight
        bench.click(page.buttons.enable)
        qtbot.waitUntil(lambda: page.work.progress is not None and page.work.progress.done >= 2, timeout=8000)
        bench.bench.unplug()
        bench.wait_standing(Standing.VOID)
        assert page.banner.announcement.head == "the port was lost"
        assert kept(bench) == []


def test_a_module_that_says_nothing_is_never_go(qtbot: QtBot, qapp: QApplication, tmp_path: Path, quick: None) -> None:
    with on_bench(qtbot, qapp, tmp_path, "mute") as bench:
        bench.bench.change(mute=True)
        assert bench.check() is Standing.VOID
        assert bench.preflight.work.assessment is not None
        assert bench.preflight.work.assessment.verdict.value == "NO-GO"


def test_a_new_check_shows_nothing_of_the_old_one(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path, quick: None
) -> None:
    with on_bench(qtbot, qapp, tmp_path, "again") as bench:
        page = bench.preflight
        assert bench.check() is Standing.GO
        bench.bench.set_cell(3.0)
        bench.click(page.buttons.run)
        assert page.banner.announcement.word == "CHECKING"
        assert "GO" not in page.banner.accessibleName()
        assert {row.chip.word for row in page.list.rows.values()} == {"checking …"}
        assert all(not row.measured.text() for row in page.list.rows.values())
        assert not page.buttons.print.isEnabled()
        bench.wait_standing(Standing.NO_GO)


# What a person says


def test_manual_items_are_ticked_by_a_person(qtbot: QtBot, qapp: QApplication, tmp_path: Path, quick: None) -> None:
    profile = tmp_path / "hexa.toml"
    profile.write_text(PROFILE, encoding="utf-8")
    with on_bench(qtbot, qapp, tmp_path, "manual") as bench:
        page = bench.preflight
        page.form.ask_open = lambda *_: profile
        page.form.choose_file()
        needed, other = page.list.manual
        assert bench.check() is Standing.NO_GO
        assert "Bridle free" in page.banner.accessibleName()
        bench.click(needed.done)
        assert page.banner.announcement.standing is Standing.VOID  # the record no longer says what is ticked
        assert bench.check() is Standing.GO
        assert page.work.record is not None
        assert page.work.record["manual"] == [
            {"text": "Bridle free", "is_done": True, "is_required": True},
            {"text": "<b>Pack date</b>", "is_done": None, "is_required": False},
        ]
        bench.click(other.bad)
        assert bench.check() is Standing.NO_GO
        assert other.chip.word == "NOT IN ORDER"
        bench.assembly.connector.clock = lambda: time.monotonic() + 1000.0
        page.tick()  # a quarter of an hour later the ticks are of another flight
        assert [row.chip.word for row in page.list.manual] == ["skipped", "skipped"]


def test_another_name_in_the_middle_voids_the_check(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path, quick: None
) -> None:
    with on_bench(qtbot, qapp, tmp_path, "renamed") as bench:
        page = bench.preflight
        bench.click(page.buttons.enable)
        bench.triggers.module.setFocus()
        qtbot.keyClicks(bench.find(QLineEdit, "triggers_module_edit"), "M-09")
        qtbot.keyClick(bench.find(QLineEdit, "triggers_module_edit"), Qt.Key.Key_Return)
        bench.wait_standing(*VERDICTS)
        assert page.work.standing is Standing.VOID
        assert kept(bench, "M-09") == kept(bench) == []


def test_ticks_stay_when_a_module_gets_its_name_and_go_with_another(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path
) -> None:
    profile = tmp_path / "hexa.toml"
    profile.write_text(PROFILE, encoding="utf-8")
    with on_bench(qtbot, qapp, tmp_path, "ticks", is_connected=False) as bench:
        page = bench.preflight
        page.form.ask_open = lambda *_: profile
        page.form.choose_file()
        bench.click(page.list.manual[0].done)
        name_module(bench, "M-07")
        assert page.list.manual[0].state is True
        name_module(bench, "M-08")
        assert page.list.manual[0].state is None


def test_a_file_that_is_no_profile_is_refused_with_its_reason(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path
) -> None:
    bad = tmp_path / "bad.toml"
    bad.write_text("format = 1\nattitude_threshold_deg = 'x'\nsurprise = 1\n", encoding="utf-8")
    with on_bench(qtbot, qapp, tmp_path, "refused", is_connected=False) as bench:
        bench.preflight.form.ask_open = lambda *_: bad
        bench.preflight.form.choose_file()
        assert said(bench).startswith("bad.toml is no profile: Line")
        assert bench.preflight.form.profile is None


def test_records_and_boot_count_need_a_word_of_a_person(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path, quick: None
) -> None:
    with on_bench(qtbot, qapp, tmp_path, "words", history=2, boots=37) as bench:
        page = bench.preflight
        name_module(bench, "M-07")
        assert bench.check() is Standing.NO_GO
        row = page.list.rows["trigger_records"]
        page.list.ensureWidgetVisible(row.act)
        bench.click(row.act)
        bench.wait_standing(Standing.GO, Standing.NO_GO)
        assert page.work.result("trigger_records") is Result.PASS
        bench.bench.module.memory.boot_count = 11
        bench.bench.restart()
        bench.wait_standing(Standing.VOID)
        assert bench.check() is Standing.NO_GO
        row = page.list.rows["boot_count"]
        assert row.measured.text() == "12: is it the same module?"
        assert "37" in row.limit.text()
        page.list.ensureWidgetVisible(row.act)
        bench.click(row.act)
        bench.wait_standing(Standing.GO, Standing.NO_GO)
        assert page.work.result("boot_count") is Result.PASS


def test_a_module_is_named_once(qtbot: QtBot, qapp: QApplication, tmp_path: Path, quick: None) -> None:
    with on_bench(qtbot, qapp, tmp_path, "once") as bench:
        name_module(bench, "M-07")
        bench.check()
    with on_bench(qtbot, qapp, tmp_path, "once") as bench:
        assert bench.find(QLineEdit, "preflight_module_edit").text() == "M-07"
        assert bench.triggers.module.currentText() == "M-07"


def test_hostile_names_do_no_harm(qtbot: QtBot, qapp: QApplication, tmp_path: Path, quick: None) -> None:
    name = "<b>x</b>=1+../\u202e☠"
    with on_bench(qtbot, qapp, tmp_path, "hostile") as bench:
        page = bench.preflight
        bench.assembly.window._services.naming.choose(name)
        bench.find(QLineEdit, "preflight_who").setText("=cmd|'/c calc'!A1")
        assert bench.check() is Standing.GO
        suggested: list[Path] = []

        def ask(_parent: QWidget, _title: str, path: Path, _filter: str) -> Path:
            suggested.append(path)
            return tmp_path / "r.pdf"

        page.files.ask_path = ask
        bench.click(page.buttons.print)
        assert suggested[0].parent == Path.home()
        assert "<b>x" not in (tmp_path / "r.html").read_text(encoding="utf-8").partition("<script")[0]
        bench.click(page.buttons.history)
        assert page.history.isVisible()


def test_without_a_store_the_verdict_stands_and_says_that_it_was_not_kept(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path, quick: None, user_files: Path
) -> None:
    (user_files / "data").parent.mkdir(parents=True, exist_ok=True)
    (user_files / "data").write_text("a file where the folder should be")
    with on_bench(qtbot, qapp, tmp_path, "homeless") as bench:
        assert bench.check() is Standing.GO
        assert "The check was not kept." in said(bench)


# Files and past checks


def test_a_dropped_record_is_intact_or_altered(qtbot: QtBot, qapp: QApplication, tmp_path: Path, quick: None) -> None:
    with on_bench(qtbot, qapp, tmp_path, "drop") as bench:
        page = bench.preflight
        assert bench.check() is Standing.GO
        target = tmp_path / "report.pdf"
        page.files.ask_path = lambda *_: target
        bench.click(page.buttons.print)
        bench.assembly.window.go_to("triggers")
        bench.drop(target)
        qtbot.waitUntil(lambda: "INTACT" in said(bench), timeout=8000)
        assert bench.assembly.window.navigation.chosen == "preflight"
        record = target.with_suffix(".json")
        record.write_text(record.read_text(encoding="utf-8").replace('"measured": 3.9', '"measured": 4.1'), "utf-8")
        bench.drop(record)
        qtbot.waitUntil(lambda: "ALTERED: checks.cell_voltage" in said(bench), timeout=8000)
        assert page.strip.notice is not None
        assert page.strip.notice.meaning is Meaning.DANGER
        nonsense = tmp_path / "x.json"
        nonsense.write_text("[" * 100_000)
        bench.drop(nonsense)
        qtbot.waitUntil(lambda: "No pre-flight record" in said(bench), timeout=8000)
        bench.drop(tmp_path / "gone.pdf")
        qtbot.waitUntil(lambda: "cannot be read" in said(bench), timeout=8000)


def test_past_checks_and_what_they_measured(qtbot: QtBot, qapp: QApplication, tmp_path: Path, quick: None) -> None:
    with on_bench(qtbot, qapp, tmp_path, "past", cell=3.6) as bench:
        page = bench.preflight
        name_module(bench, "M-07")
        bench.find(QLineEdit, "preflight_aircraft_edit").setText("H6-12")
        assert bench.check() is Standing.NO_GO
        bench.bench.set_cell(4.0)
        assert bench.check() is Standing.GO
        bench.click(page.buttons.history)
        history = page.history
        assert [one.verdict for one in history.checks] == ["GO", "NO-GO"]
        assert [point.value for point in history.trends["cell_voltage_v"].points] == [3.6, 4.0]
        assert "3.60 V to 4.00 V" in history.trends["cell_voltage_v"].accessibleName()
        target = tmp_path / "again.pdf"
        page.files.ask_path = lambda *_: target
        history.table.selectRow(1)
        bench.click(history.print)
        assert verify_file(target).state is State.INTACT
        bench.click(page.buttons.history)
        box = bench.find(QComboBox, "check_history_filter")
        box.setCurrentIndex(box.findText("Aircraft H6-12"))
        box.activated.emit(box.currentIndex())
        assert len(history.checks) == 2
        qtbot.keyClick(page, Qt.Key.Key_Escape)
        assert page.buttons.isVisible()


# Looks


def test_without_a_module_nothing_can_be_checked(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with on_bench(qtbot, qapp, tmp_path, "none", is_connected=False) as bench:
        page = bench.preflight
        assert not page.buttons.run.isEnabled()
        assert "Connect a module" in page.banner.accessibleName()
        assert {row.chip.word for row in page.list.rows.values()} == {"not checked"}


def test_everything_has_a_name_and_fits(qtbot: QtBot, qapp: QApplication, tmp_path: Path, quick: None) -> None:
    with on_bench(qtbot, qapp, tmp_path, "fits", cell=3.6, history=1) as bench:
        page = bench.preflight
        assert bench.check(is_enabling=False) is Standing.NO_GO
        assert len(page.findChildren(CheckRow)) == len(CHECKS)
        controls: list[QWidget] = [*page.findChildren(QPushButton), *page.findChildren(QLineEdit)]
        controls += page.findChildren(QComboBox)
        for control in controls:
            if not control.objectName().startswith("qt_") and control.isVisible():
                assert control.accessibleName(), control.objectName()
        for button in page.buttons.findChildren(QAbstractButton):
            if button.isVisible():
                assert button.width() >= button.sizeHint().width(), button.objectName()
                place = QRect(button.mapTo(page, button.rect().topLeft()), button.size())
                assert page.rect().contains(place), button.objectName()
        content = bench.find(QWidget, "preflight_content")
        assert content.width() <= page.list.viewport().width()


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


def test_the_verdict_is_readable_in_every_theme() -> None:
    for theme in THEMES:
        for meaning in (Meaning.GOOD, Meaning.DANGER):
            tint = theme.tint(meaning)
            assert contrast(tint.fill, tint.on_fill) >= (7.0 if theme.name == "sunlight" else 4.5)
