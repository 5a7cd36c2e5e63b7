"""The Pre-flight page by real clicks on the simulated module: run, fail, repair, run again, print; what voids it."""

import json
import re
from collections import Counter
from pathlib import Path

import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QApplication, QLineEdit
from pytestqt.qtbot import QtBot

from app.limits.past import Past
from app.preflight.checks import CHECKS, Case, CheckResult, Finding
from app.preflight.evidence import Evidence
from app.preflight.verdict import Judged
from app.records.verification import RecordState, verify_file
from app.settings.profiles import Profile
from app.system.files import data_folder
from app.text.messages import UserMessage
from protocol.catalogue import BY_NAME
from protocol.fields import Value
from tests.support.window.preflight_window import (
    NOBODY,
    VERDICTS,
    OnBench,
    confirm_name,
    kept,
    name_module,
    on_bench,
    press_row,
    said,
)
from tests.support.window.steps import choosing, find, given, notice_text
from ui.pages.preflight.checks import remedy
from ui.pages.triggers.page import TriggersPage
from ui.session.check import Standing
from ui.widgets.controls import Shortcut

PROFILE = """
format = 1
name = "Survey hexacopter"
[[manual]]
text = "Bridle free"
required = true
[[manual]]
text = "<b>Pack date</b>"
"""


def test_run_fail_repair_run_again_print(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with on_bench(qtbot, qapp, tmp_path, "repair", "preflight", cell=3.6) as bench:
        page = bench.preflight
        assert page.banner.announcement.standing is Standing.NOT_CHECKED
        assert not page.export.isEnabled()
        name_module(bench, "M-07")
        assert bench.check(is_enabling=False) is Standing.NO_GO
        assert bench.acts == []  # questions only
        shown = page.banner.announcement
        assert (shown.word, shown.head) == ("NO-GO", "Do not fly")
        assert "Cell voltage" in shown.lines[1]  # a check is named by what has to be so
        assert not any("holds for" in line for line in shown.lines)  # nobody has to wait for a NO-GO to end
        row = page.list.rows["cell_voltage"]
        assert (row.word.text(), row.measured.text(), row.limit.text()) == ("FAILED", "3.60 V", "≥ 3.80 V")
        assert "Charge it" in row.reason.text()
        assert page.list.rows["attitude_trigger"].word.text() == "UNKNOWN"
        assert all(name in page.banner.accessibleName() for name in ("Cell voltage", "Attitude trigger enabled"))
        bench.bench.set_world(cell_v=4.0)
        press_row(bench, "attitude_trigger")
        share = 0.0
        while page.work.standing is Standing.CHECKING:
            shown = page.banner.announcement
            assert (shown.progress or 0.0) >= share, "the check's own steps, which go one way"
            assert "{" not in shown.head
            share = shown.progress or 0.0
            bench.turn()
        assert page.work.standing is Standing.READY, page.banner.accessibleName()
        assert [request.command for request in bench.acts] == [
            BY_NAME["freefall_trigger"], BY_NAME["attitude_trigger"],
        ]  # fmt: skip
        shown = page.banner.announcement
        assert (shown.word, shown.head) == ("READY", "Activate before the flight")
        assert any(re.fullmatch(r"M-07 · \d\d:\d\d:\d\d · holds for \d+ min", line) for line in shown.lines)
        assert kept(bench, "M-07") == ["READY", "NO-GO"]
        target = tmp_path / "report.pdf"
        page.ask_path = choosing(target)
        bench.click(page.export)
        bench.until(lambda: "report.pdf" in said(bench))
        opened: list[str] = []
        page.result.open_in_system = lambda url: opened.append(url.toLocalFile())
        for choice in ("open", "folder"):
            bench.click(given(page.strip.button(choice)))
        assert opened == [str(target), str(tmp_path)]
        for suffix in (".pdf", ".json"):
            assert verify_file(target.with_suffix(suffix), NOBODY).state is RecordState.INTACT
        record = json.loads(target.with_suffix(".json").read_text(encoding="utf-8"))["record"]
        assert (record["verdict"], record["module"]) == ("READY", "M-07")
        assert len(record["frames"]) > 60
        assert record["frames"][0][0] >= 0


# What a person says


def change_threshold(bench: OnBench) -> None:
    """Nobody at this window did: what was known of the module is over."""
    port = bench.assembly.ports.current
    before = port.module.number
    bench.until(lambda: port.module.is_read)
    bench.bench.module.memory.attitude_threshold = 70
    bench.until(lambda: port.module.number > before and port.module.is_read)


def test_manual_items_are_ticked_by_a_person(tmp_path: Path, rig: OnBench) -> None:
    profile = tmp_path / "hexa.toml"
    profile.write_text(PROFILE, encoding="utf-8")
    page = rig.preflight
    page.form.ask_open = choosing(profile)
    page.form.choose_file()
    needed, other = page.list.manual
    assert rig.check() is Standing.NO_GO
    assert "Bridle free" in page.banner.accessibleName()
    rig.click(needed.done)
    assert page.banner.announcement.standing is Standing.VOID  # the record no longer says what is ticked
    assert rig.check() is Standing.READY
    manual = given(page.work.signed).record.manual
    assert [(one.text, one.is_done, one.is_required) for one in manual] == [
        ("Bridle free", True, True),
        ("<b>Pack date</b>", None, False),
    ]
    rig.click(other.bad)
    assert rig.check() is Standing.NO_GO
    assert other.word.text() == "Not OK"
    later = lambda: rig.clock() + 1000.0  # noqa: E731
    rig.assembly.ports.clock = rig.assembly.ports.current._clock = later
    page.tick()  # a quarter of an hour later the ticks are of another flight
    assert [row.word.text() for row in page.list.manual] == ["skipped", "skipped"]


def test_another_name_in_the_middle_voids_the_check(qtbot: QtBot, full_rig: OnBench) -> None:
    page = full_rig.preflight
    name_module(full_rig, "M-08")
    full_rig.click(page.enable)
    full_rig.triggers.name_field.setFocus()
    qtbot.keyClicks(full_rig.find(QLineEdit, "triggers_module_edit"), "M-09")
    qtbot.keyClick(full_rig.find(QLineEdit, "triggers_module_edit"), Qt.Key.Key_Return)
    full_rig.wait_standing(*VERDICTS)
    assert page.work.standing is Standing.VOID
    assert kept(full_rig, "M-09") == kept(full_rig, "M-08") == kept(full_rig) == []


def test_ticks_stay_when_a_module_gets_its_name_and_go_with_another(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path
) -> None:
    profile = tmp_path / "hexa.toml"
    profile.write_text(PROFILE, encoding="utf-8")
    with on_bench(qtbot, qapp, tmp_path, "ticks", "preflight", is_connected=False) as bench:
        page = bench.preflight
        page.form.ask_open = choosing(profile)
        page.form.choose_file()
        page.form.aircraft.setText("H6-12")
        bench.click(page.list.manual[0].done)
        bench.connect()
        assert (page.list.manual[0].state, page.form.aircraft.text()) == (None, "")
        bench.click(page.list.manual[0].done)
        name_module(bench, "M-07")
        assert page.list.manual[0].state is True
        name_module(bench, "M-08")
        assert page.list.manual[0].state is None


def test_records_and_boot_count_need_a_word_of_a_person(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    with on_bench(qtbot, qapp, tmp_path, "words", "preflight", "triggers", reads_triggers=True, history=2,
                  boots=37) as bench:  # fmt: skip
        page, window = bench.preflight, bench.assembly.window
        name_module(bench, "M-07")
        assert bench.check() is Standing.NO_GO
        press_row(bench, "trigger_records")  # nobody has seen them: one click never calls them reviewed
        triggers = find(window, TriggersPage)
        bench.until(lambda: triggers.isVisible() and len(triggers.table.chosen()) == 2)
        assert page.work.standing is Standing.NO_GO
        assert [one.seen.judgement for one in triggers.table.chosen()] == [None, None]
        window.go_to("preflight")
        bench.until(lambda: given(page.list.rows["trigger_records"].act).text() == "Mark as reviewed")
        press_row(bench, "trigger_records")
        bench.wait_standing(Standing.READY, Standing.NO_GO)
        assert (page.work.assessment and page.work.assessment.result("trigger_records")) is CheckResult.PASS
        bench.bench.module.memory.boot_count = 11
        bench.restart()
        bench.wait_standing(Standing.NOT_CHECKED)
        assert bench.assembly.ports.module.name == ""
        confirm_name(bench)  # beside what speaks against it
        assert bench.check() is Standing.READY
        assert given(page.work.assessment).result("boot_count") is CheckResult.PASS


def test_changed_settings_are_approved_by_a_person_once_for_the_module(rig: OnBench) -> None:
    page = rig.preflight
    name_module(rig, "M-07")
    assert rig.check() is Standing.READY
    change_threshold(rig)
    last = given(rig.assembly.ports.current.interruptions.last).in_english()
    assert "Two modules on this line?" in last
    name_module(rig, "M-07")
    assert rig.check() is Standing.NO_GO
    assert given(page.list.rows["fingerprint"].act).text() == "Approve these settings"
    press_row(rig, "fingerprint")
    rig.wait_standing(Standing.READY, Standing.NO_GO)
    assert page.work.standing is Standing.READY
    row = page.list.rows["fingerprint"]
    code = row.limit.text()  # the report said "none approved" of what was just approved
    assert row.measured.text() == f"{code}, confirmed by a person"
    assert rig.check() is Standing.READY  # they are the approved ones now


def test_what_a_profile_approves_is_changed_in_the_profile(tmp_path: Path, rig: OnBench) -> None:
    profile = tmp_path / "hexa.toml"
    approved = 'approved_fingerprint = "JFKY-2WSC"  # in May\n[['
    profile.write_text(PROFILE.replace("[[", approved, 1), encoding="utf-8")
    page = rig.preflight
    change_threshold(rig)
    page.form.ask_open = choosing(profile)
    page.form.choose_file()
    for item in page.list.manual:
        rig.click(item.done)
    assert rig.check() is Standing.NO_GO
    code = page.list.rows["fingerprint"].measured.text()
    text = profile.read_text(encoding="utf-8")
    profile.write_text("[", encoding="utf-8")  # somebody edits it
    press_row(rig, "fingerprint")
    assert "hexa.toml is not a profile" in notice_text(page.strip)
    assert profile.read_text(encoding="utf-8") == "["
    profile.write_text(text, encoding="utf-8")
    press_row(rig, "fingerprint")
    rig.wait_standing(Standing.CHECKING)
    rig.wait_standing(Standing.READY, Standing.NO_GO)
    assert (page.work.assessment and page.work.assessment.result("fingerprint")) is CheckResult.PASS
    assert [item.state for item in page.list.manual] == [True] * len(page.list.manual)  # what was ticked before it
    assert page.work.standing is Standing.READY
    assert f'approved_fingerprint = "{code}"' in profile.read_text(encoding="utf-8")
    assert "# in May" in profile.read_text(encoding="utf-8")
    profile.write_text(f"{text}[limits]\ntilt_max_deg = 4\n", encoding="utf-8")  # as the page Flights does, too
    rig.wait(1.0)  # the button lies elsewhere since the verdict
    assert rig.check() is Standing.NO_GO
    assert page.list.rows["tilt"].limit.text() == "≤ 4°"
    profile.write_text(f"{text}[limits]\ntilt_max_deg = 3\n", encoding="utf-8")
    press_row(rig, "fingerprint")
    assert "tilt_max_deg = 3" in profile.read_text(encoding="utf-8")


def test_ctrl_return_is_always_the_main_button(qtbot: QtBot, qapp: QApplication, tmp_path: Path) -> None:
    def press() -> None:
        bench.wait(0.6)  # a step is dead for half a second
        find(bench.assembly.window, Shortcut, "preflight_run_key").activated.emit()

    with on_bench(qtbot, qapp, tmp_path, "main", "preflight") as bench:
        page = bench.preflight
        press()  # enable the triggers and check
        bench.wait_standing(Standing.READY)
        assert len(bench.acts) == 2
        target = tmp_path / "report.pdf"
        page.ask_path = choosing(target)
        press()  # ask to activate, which sends nothing
        assert page.activation.confirm.is_asking
        page.activation.confirm.withdraw()
        assert len(bench.acts) == 2
        bench.bench.module.activate(is_active=True)
        bench.wait_standing(Standing.GO)
        press()  # export the report
        bench.until(target.exists)
        assert len(bench.acts) == 2


_WRITE = "Write the profile's value"
MENDED: tuple[tuple[str, CheckResult, dict[str, Value], str | None, str], ...] = (
    ("attitude_threshold", CheckResult.FAIL, {"attitude_threshold_deg": 65}, "M", _WRITE),
    ("attitude_threshold", CheckResult.FAIL, {}, "M", "Write the default"),
    ("attitude_threshold", CheckResult.UNKNOWN, {"attitude_threshold_deg": 65}, "M", ""),
    ("light_threshold", CheckResult.WARN, {}, "M", "Measure"),
    ("light_threshold", CheckResult.FAIL, {"light_threshold_v": 2.0}, "M", _WRITE),
    ("light", CheckResult.FAIL, {}, "M", "Measure"),
    ("light", CheckResult.UNKNOWN, {}, "M", ""),
    ("freefall_trigger", CheckResult.FAIL, {}, "M", "Enable now"),
    ("boot_count", CheckResult.FAIL, {}, "M", "It is this module"),
    ("fingerprint", CheckResult.WARN, {}, "M", "Approve these settings"),
    ("cell_voltage", CheckResult.FAIL, {}, "M", ""),
    ("tilt", CheckResult.PASS, {}, "M", ""),
)  # fmt: skip


@pytest.mark.parametrize(("id_", "result", "settings", "module", "words"), MENDED)
def test_each_row_that_is_not_met_carries_what_mends_it(
    id_: str, result: CheckResult, settings: dict[str, Value], module: str | None, words: str
) -> None:
    check = next(check for check in CHECKS if check.id == id_)
    case = Case(evidence=Evidence(), profile=Profile(settings=settings), past=Past(module=module))
    judged = Judged(check, Finding(result, None, UserMessage(""), UserMessage("")))
    act = remedy(judged, case, has_profile=False, needs_lock=False, looked_at=Counter())
    assert (act.words if act else "") == words


def test_what_a_profile_says_is_put_into_settings_and_not_written(
    tmp_path: Path, qtbot: QtBot, qapp: QApplication
) -> None:
    profile = tmp_path / "hexa.toml"
    profile.write_text("[settings]\nattitude_threshold_deg = 65\n", encoding="utf-8")
    with on_bench(qtbot, qapp, tmp_path, "write", "preflight") as bench:
        page, used = bench.preflight, list[object]()
        page.exchange.used.connect(used.append)
        page.form.use_profile(profile)
        assert bench.check() is Standing.NO_GO
        before = list(bench.acts)
        press_row(bench, "attitude_threshold")
        assert used == [{"attitude_threshold_deg": 65}]
        assert bench.acts == before


def test_without_a_store_the_verdict_stands_and_says_that_it_was_not_kept(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path
) -> None:
    data_folder().parent.mkdir(parents=True, exist_ok=True)
    data_folder().write_text("a file where the folder should be", encoding="utf-8")
    with on_bench(qtbot, qapp, tmp_path, "homeless", "preflight") as bench:
        assert bench.check() is Standing.READY
        assert "Not kept." in said(bench)
