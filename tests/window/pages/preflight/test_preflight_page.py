"""The Pre-flight page by real clicks on the simulated module: run, fail, repair, run again; its records; its profile is
edited, and nothing typed is changed, refused silently, or lost.
"""

import re
from collections import Counter
from pathlib import Path

import pytest
from PySide6.QtCore import Qt
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QApplication, QLineEdit
from pytestqt.qtbot import QtBot

from app.guided.results import GuidedKind
from app.limits.past import Past
from app.preflight.checks import CHECKS, Case, CheckResult, Finding
from app.preflight.evidence import Evidence
from app.preflight.verdict import Judged, Standing, Verdict
from app.records.verification import RecordState, verify_file
from app.settings.profile_file import read_profile
from app.settings.profiles import ActivatedBy, ManualLine, Profile
from app.store.rows import PreflightCheck
from app.system.files import data_folder
from app.text.messages import UserMessage
from protocol.catalogue import BY_NAME
from protocol.fields import Value
from tests.support.records.stored import add
from tests.support.window.desk import NOBODY, confirm_name, desk, kept, name_module, press_row, said, unfold
from tests.support.window.fakes_ui import store_of
from tests.support.window.rig import Rig
from tests.support.window.steps import choosing, drop, find, given, notice_text
from ui.pages.preflight.checks import remedy
from ui.pages.triggers.page import TriggersPage
from ui.style.theme import Meaning
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


@pytest.mark.module(cell=3.6)
def test_run_fail_repair_run_again_print(tmp_path: Path, one: Rig) -> None:
    page = one.preflight
    assert not page.export.isEnabled()
    name_module(one, "M-07")
    assert one.check(is_enabling=False) is Standing.NO_GO
    assert one.acts == []  # questions only
    shown = page.banner.announcement
    assert (shown.word, shown.head) == ("NO-GO", "Do not fly")
    assert "Cell voltage" in shown.lines[1]  # a check is named by what has to be so
    assert not any("holds for" in line for line in shown.lines)  # nobody has to wait for a NO-GO to end
    row = page.list.rows["cell_voltage"]
    assert (row.word.text(), row.measured.text(), row.limit.text()) == ("FAILED", "3.60 V", "≥ 3.80 V")
    assert "Charge it" in row.reason.text()
    assert page.list.rows["attitude_trigger"].word.text() == "UNKNOWN"
    assert "Attitude trigger enabled" in page.banner.accessibleName()
    one.bench.set_world(cell_v=4.0)
    press_row(one, "attitude_trigger")
    share = 0.0
    while page.state.standing is Standing.CHECKING:
        shown = page.banner.announcement
        assert (shown.progress or 0.0) >= share, "the check's own steps, which go one way"
        assert "{" not in shown.head
        share = shown.progress or 0.0
        one.turn()
    assert page.state.standing is Standing.READY, page.banner.accessibleName()
    assert [request.command for request in one.acts] == [
        BY_NAME["freefall_trigger"], BY_NAME["attitude_trigger"],
    ]  # fmt: skip
    shown = page.banner.announcement
    assert (shown.word, shown.head) == ("READY", "Activate before the flight")
    assert any(re.fullmatch(r"M-07 · \d\d:\d\d:\d\d · holds for \d+ min", line) for line in shown.lines)
    assert kept(one, "M-07") == ["READY", "NO-GO"]
    target = tmp_path / "report.pdf"
    page.ask_path = choosing(target)
    one.click(page.export)
    one.until(lambda: "report.pdf" in said(one))
    opened: list[str] = []
    page.result.open_in_system = lambda url: opened.append(url.toLocalFile())
    for choice in ("open", "folder"):
        one.click(given(page.strip.button(choice)))
    assert opened == [str(target), str(tmp_path)]
    for suffix in (".pdf", ".json"):
        assert verify_file(target.with_suffix(suffix), NOBODY).state is RecordState.INTACT


# What a person says


def change_threshold(bench: Rig) -> None:
    """Nobody at this window did: what was known of the module is over."""
    port = bench.assembly.ports.current
    before = port.module.number
    bench.until(lambda: port.module.is_read)
    bench.bench.module.memory.attitude_threshold = 70
    bench.until(lambda: port.module.number > before and port.module.is_read)


def use_profile(bench: Rig, folder: Path, text: str) -> Path:
    path = folder / "hexa.toml"
    path.write_text(text, encoding="utf-8")
    bench.preflight.form.ask_open = choosing(path)
    bench.preflight.form.choose_file()
    return path


def test_manual_items_are_ticked_by_a_person(tmp_path: Path, one: Rig) -> None:
    use_profile(one, tmp_path, PROFILE)
    page = one.preflight
    needed, other = page.list.manual
    assert one.check() is Standing.NO_GO
    assert "Bridle free" in page.banner.accessibleName()
    one.click(needed.done)
    assert page.banner.announcement.standing is Standing.VOID  # the record no longer says what is ticked
    assert one.check() is Standing.READY
    manual = given(page.signed).record.manual
    assert [(item.text, item.is_done, item.is_required) for item in manual] == [
        ("Bridle free", True, True),
        ("<b>Pack date</b>", None, False),
    ]
    one.click(other.bad)
    one.click(page.run)
    assert not other.done.isEnabled()
    one.wait_standing(Standing.NO_GO)
    assert other.word.text() == "Not OK"
    later = lambda: one.clock() + 1000.0  # noqa: E731
    one.assembly.ports.clock = one.assembly.ports.current._clock = later
    page.tick()  # a quarter of an hour later the ticks are of another flight
    assert [row.word.text() for row in page.list.manual] == ["skipped", "skipped"]


@pytest.mark.module(is_connected=False)
def test_what_was_entered_stays_when_a_module_gets_its_name_and_goes_with_another(tmp_path: Path, one: Rig) -> None:
    page, port = one.preflight, one.assembly.ports.current
    use_profile(one, tmp_path, PROFILE)

    def enter() -> None:
        page.form.aircraft.setText("H6-12")
        page.form.commit()
        one.click(page.list.manual[0].done)

    def shown() -> tuple[bool | None, str]:
        assert page.form.committed[1] == page.form.aircraft.text()
        return page.list.manual[0].state, page.form.aircraft.text()

    enter()
    one.connect()
    assert shown() == (None, "")
    enter()
    name_module(one, "M-07")
    assert shown() == (True, "H6-12")
    one.check()
    for name, of_it in (("M-08", ""), ("M-07", "H6-12")):
        name_module(one, name)
        assert shown() == (None, of_it)
    one.restart()
    assert shown() == (None, "")
    confirm_name(one)
    assert shown() == (None, "H6-12")
    port.treat_as_another()
    one.until(lambda: not port.module.name)
    assert shown() == (None, "")


@pytest.mark.module("preflight", "triggers", reads_triggers=True, history=2, boots=37)
def test_records_and_boot_count_need_a_word_of_a_person(one: Rig) -> None:
    page, window = one.preflight, one.assembly.window
    name_module(one, "M-07")
    assert one.check() is Standing.NO_GO
    press_row(one, "trigger_records")  # nobody has seen them: one click never calls them reviewed
    triggers = find(window, TriggersPage)
    one.until(lambda: triggers.isVisible() and len(triggers.table.chosen()) == 2)
    assert page.state.standing is Standing.NO_GO
    assert [row.seen.judgement for row in triggers.table.chosen()] == [None, None]
    window.go_to("preflight")
    one.until(lambda: given(page.list.rows["trigger_records"].act).text() == "Mark as reviewed")
    press_row(one, "trigger_records")
    one.wait_standing(Standing.READY, Standing.NO_GO)
    assert (page.state.assessment and page.state.assessment.result("trigger_records")) is CheckResult.PASS
    one.bench.module.memory.boot_count = 11
    one.restart()
    one.wait_standing(Standing.NOT_CHECKED)
    assert one.assembly.ports.module.name == ""
    confirm_name(one)  # beside what speaks against it
    assert one.check() is Standing.READY
    assert given(page.state.assessment).result("boot_count") is CheckResult.PASS


def test_changed_settings_are_approved_by_a_person_once_for_the_module(one: Rig) -> None:
    page = one.preflight
    name_module(one, "M-07")
    assert one.check() is Standing.READY
    change_threshold(one)
    name_module(one, "M-07")
    assert one.check() is Standing.NO_GO
    assert given(page.list.rows["fingerprint"].act).text() == "Approve these settings"
    press_row(one, "fingerprint")
    one.wait_standing(Standing.READY, Standing.NO_GO)
    assert page.state.standing is Standing.READY
    unfold(one)
    row = page.list.rows["fingerprint"]
    code = row.limit.text()  # the report said "none approved" of what was just approved
    assert row.measured.text() == f"{code}, confirmed by a person"
    assert one.check() is Standing.READY  # they are the approved ones now


def test_what_a_profile_approves_is_changed_in_the_profile(tmp_path: Path, one: Rig) -> None:
    approved = 'approved_fingerprint = "OPQ7-5ZRY"  # in May\n[['
    page = one.preflight
    change_threshold(one)
    profile = use_profile(one, tmp_path, PROFILE.replace("[[", approved, 1))
    for item in page.list.manual:
        one.click(item.done)
    assert one.check() is Standing.NO_GO
    code = page.list.rows["fingerprint"].measured.text()
    text = profile.read_text(encoding="utf-8")
    profile.write_text("[", encoding="utf-8")  # somebody edits it
    press_row(one, "fingerprint")
    assert "hexa.toml is not a profile" in notice_text(page.strip)
    assert profile.read_text(encoding="utf-8") == "["
    profile.write_text(text, encoding="utf-8")
    press_row(one, "fingerprint")
    one.wait_standing(Standing.CHECKING)
    one.wait_standing(Standing.READY, Standing.NO_GO)
    assert (page.state.assessment and page.state.assessment.result("fingerprint")) is CheckResult.PASS
    assert [item.state for item in page.list.manual] == [True] * len(page.list.manual)  # what was ticked before it
    assert page.state.standing is Standing.READY
    assert f'approved_fingerprint = "{code}"' in profile.read_text(encoding="utf-8")
    assert "# in May" in profile.read_text(encoding="utf-8")
    profile.write_text(f"{text}[limits]\ntilt_max_deg = 4\n", encoding="utf-8")  # in a text editor
    one.wait(1.0)  # the button lies elsewhere since the verdict
    assert one.check() is Standing.NO_GO
    unfold(one)
    assert page.list.rows["tilt"].limit.text() == "≤ 4°"


def test_ctrl_return_is_always_the_main_button(tmp_path: Path, one: Rig) -> None:
    page, target = one.preflight, tmp_path / "report.pdf"
    page.ask_path = choosing(target)

    def press() -> None:
        one.wait(0.6)  # a step is dead for half a second
        find(one.assembly.window, Shortcut, "preflight_run_key").activated.emit()

    press()  # enable the triggers and check
    one.wait_standing(Standing.READY)
    assert len(one.acts) == 2
    press()  # ask to activate, which sends nothing
    assert page.activation.confirm.is_asking
    page.activation.confirm.withdraw()
    assert len(one.acts) == 2
    one.bench.module.activate(is_active=True)
    one.wait_standing(Standing.GO)
    press()  # export the report
    one.until(target.exists)
    assert len(one.acts) == 2


def test_what_mends_a_row_is_offered_only_where_its_value_is_known() -> None:
    wanted: dict[str, Value] = {"attitude_threshold_deg": 65}
    mended: tuple[tuple[str, CheckResult, dict[str, Value], str], ...] = (
        ("attitude_threshold", CheckResult.FAIL, wanted, "Write the profile's value"),
        ("attitude_threshold", CheckResult.FAIL, {}, "Write the default"),
        ("attitude_threshold", CheckResult.UNKNOWN, wanted, ""),
        ("light_threshold", CheckResult.WARN, {}, "Measure"),
        ("light", CheckResult.UNKNOWN, {}, ""),
        ("boot_count", CheckResult.FAIL, {}, "It is this module"),
        ("boot_count", CheckResult.UNKNOWN, {}, ""),
        ("fingerprint", CheckResult.FAIL, {}, "Approve these settings"),
        ("fingerprint", CheckResult.UNKNOWN, {}, ""),
        ("cell_voltage", CheckResult.FAIL, {}, ""),
    )
    for id_, result, settings, words in mended:
        check = next(check for check in CHECKS if check.id == id_)
        case = Case(evidence=Evidence(), profile=Profile(settings=settings), past=Past(module="M"))
        judged = Judged(check, Finding(result, None, UserMessage(""), UserMessage("")))
        act = remedy(judged, case, looked_at=Counter())
        assert (act.words if act else "") == words, id_


def test_what_a_profile_says_is_put_into_settings_and_not_written(tmp_path: Path, one: Rig) -> None:
    page, used = one.preflight, list[object]()
    page.exchange.used.connect(used.append)
    use_profile(one, tmp_path, "[settings]\nattitude_threshold_deg = 65\n")
    assert one.check() is Standing.NO_GO
    before = list(one.acts)
    press_row(one, "attitude_threshold")
    assert used == [{"attitude_threshold_deg": 65}]
    assert one.acts == before


def test_without_a_store_the_verdict_stands_and_says_that_it_was_not_kept(
    qtbot: QtBot, qapp: QApplication, tmp_path: Path
) -> None:
    data_folder().parent.mkdir(parents=True, exist_ok=True)
    data_folder().write_text("a file where the folder should be", encoding="utf-8")
    with desk(qtbot, qapp, tmp_path, "preflight", name="homeless") as bench:
        assert bench.check() is Standing.READY
        assert "Not kept so far." in said(bench)


# Its records


def test_what_was_typed_last_is_on_the_report_and_a_dropped_one_is_intact_or_altered(tmp_path: Path, one: Rig) -> None:
    page, target = one.preflight, tmp_path / "report.pdf"
    assert one.check() is Standing.READY
    page.ask_path = choosing(target)
    # The field still has the focus: the report waits for the record that says it.
    one.find(QLineEdit, "preflight_aircraft").setText("H6-12")
    one.click(page.export)
    one.until(lambda: "Saved to" in said(one))
    saved = given(verify_file(target, NOBODY).record)
    assert (saved.aircraft, saved.verdict, page.state.standing) == ("H6-12", Verdict.READY, Standing.READY)
    one.assembly.window.go_to("triggers")
    drop(one.assembly.window, target)
    one.until(lambda: "INTACT" in said(one))
    assert one.assembly.window.navigation.chosen == "preflight"
    record = target.with_suffix(".json")
    record.write_text(record.read_text(encoding="utf-8").replace('"measured":3.9', '"measured":4.1'), "utf-8")
    drop(one.assembly.window, record)
    one.until(lambda: "ALTERED" in said(one))
    assert given(page.strip.notice).meaning is Meaning.DANGER
    nonsense = tmp_path / "x.json"
    nonsense.write_text("[" * 100_000, encoding="utf-8")
    drop(one.assembly.window, nonsense)
    one.until(lambda: "No pre-flight record" in said(one))
    drop(one.assembly.window, tmp_path / "gone.pdf")
    one.until(lambda: "cannot be read" in said(one))


def test_what_is_simulated_void_or_has_no_name_makes_no_curve(one: Rig) -> None:
    history, store = one.preflight.past, store_of(one.assembly.storage)
    for cell_v, is_void, is_simulated in ((4.0, False, False), (1.0, False, True), (2.0, True, False)):
        check = PreflightCheck(
            verdict="GO", is_void=is_void, is_simulated=is_simulated, cell_voltage_v=cell_v, document="{}"
        )
        for module in ("M-07", None):  # what has no name may be of several modules
            add(store, check, module).result()
    one.preflight.show_view("past")
    one.until(lambda: len(history.checks) == 3)
    assert history.trend.values == ()
    one.preflight.show_view("checks")
    name_module(one, "M-07")
    one.until(lambda: "M-07" in one.assembly.ports.known_names())
    one.preflight.show_view("past")
    one.until(lambda: history.trend.values == (4.0,))
    shown = [history.table.model().index(row, 1).data() for row in range(3)]
    assert shown == ["GO (void)", "GO (simulated)", "GO"]


@pytest.mark.module(cell=3.6)
def test_past_checks_and_what_they_measured(qtbot: QtBot, tmp_path: Path, one: Rig) -> None:
    page = one.preflight
    name_module(one, "M-07")
    one.find(QLineEdit, "preflight_aircraft").setText("H6-12")
    assert one.check() is Standing.NO_GO
    one.bench.set_world(cell_v=4.0)
    assert one.check() is Standing.READY
    page.show_view("past")
    history = page.past
    one.until(lambda: [check.verdict for check in history.checks] == ["READY", "NO-GO"])
    assert history.trend.values == (3.6, 4.0)
    assert "3.60 V to 4.00 V" in history.trend.accessibleName()
    target = tmp_path / "again.pdf"
    page.ask_path = choosing(target)
    history.table.selectRow(1)
    one.click(history.export)
    one.until(lambda: not page.result.is_busy)
    assert verify_file(target, NOBODY).state is RecordState.INTACT
    page.show_view("past")
    qtbot.keyClick(page, Qt.Key.Key_Escape)
    assert page.view == "checks"


EDITED = """
format = 1
name = "Survey hexacopter"  # the big one
notes = "measured in the yard"
light_inverted = true
[settings]
attitude_threshold_deg = 60
[limits]
cell_voltage_min_v = 3.875
tilt_max_deg = 3.0
[[manual]]
text = " Bridle free"
required = true
"""


def _type(qtbot: QtBot, field: QLineEdit, text: str) -> None:
    field.selectAll()
    qtbot.keyClick(field, Qt.Key.Key_Delete)
    qtbot.keyClicks(field, text)


@pytest.mark.module(is_connected=False)
def test_a_profile_is_edited_saved_and_used(qtbot: QtBot, tmp_path: Path, one: Rig) -> None:
    path, page = tmp_path / "hexa.toml", one.preflight
    path.write_text(EDITED, encoding="utf-8")
    before = read_profile(path)
    page.form.use_profile(path)
    page.form.menu.aboutToShow.emit()
    find(page, QAction, "preflight_profile_edit").trigger()
    editor = given(page.editor)
    assert not editor.isWindowModified()  # what is only looked at is not changed
    assert (editor.save.isEnabled(), page.list.isVisible()) == (False, False)
    number = editor.limits["cell_voltage_min_v"]
    assert (number.text(), editor.limits["round_trip_max_ms"].text()) == ("3.875", "")
    _type(qtbot, number, "2.0")  # below the bound that no profile goes beyond
    assert number.text() == "2.0"
    assert "3.5 to 4.2" in notice_text(editor.strip)
    assert (editor.save.isEnabled(), editor.save_as.isEnabled(), editor.isWindowModified()) == (False, False, True)
    for line, text in (
        (number, "3.5"),
        (editor.limits["tilt_max_deg"], ""),
        (editor.limits["round_trip_max_ms"], "100"),
        (editor.tests[GuidedKind.BAY], "180"),
        (editor.airframe, "H6"),
        (editor.manual[1][0], "Pack date"),
    ):
        _type(qtbot, line, text)
    editor.activated_by.setCurrentIndex(1)
    editor.service.click()
    assert len(editor.manual) == 3  # a line for one more
    assert editor.manual[1][1].nextInFocusChain() is editor.manual[2][0]
    _type(qtbot, editor.manual[0][0], "")
    path.write_text(EDITED.replace("= 60", "= 45"), encoding="utf-8")  # by the Settings page
    one.click(editor.save)
    assert page.editor is None
    assert 'name = "Survey hexacopter"  # the big one' in path.read_text(encoding="utf-8")
    wanted = before._replace(
        settings={"attitude_threshold_deg": 45},
        limits={"round_trip_max_ms": 100, "cell_voltage_min_v": 3.5},
        tests_within_days={GuidedKind.BAY: 180},
        activated_by=ActivatedBy.AIRCRAFT,
        is_service_required=True,
        airframe="H6",
        manual=(ManualLine("Pack date"),),
    )
    assert read_profile(path) == page.form.profile == wanted
    assert [row.line for row in page.list.manual] == [ManualLine("Pack date")]


@pytest.mark.module(is_connected=False)
def test_edits_are_discarded_only_when_that_is_said(qtbot: QtBot, tmp_path: Path, one: Rig) -> None:
    page, window = one.preflight, one.assembly.window
    page.edit_profile()
    editor = given(page.editor)
    qtbot.keyClicks(editor.name, "H6")
    assert page.on_escape()
    assert not window.close()
    assert "Profile: Unsaved edits." in notice_text(window.notice_bar)
    one.click(given(window.notice_bar.button("stay")))
    record = tmp_path / "x.json"
    record.write_text("{}", encoding="utf-8")
    drop(window, record)
    assert notice_text(editor.strip) == "Unsaved edits."
    one.click(given(editor.strip.button("keep")))
    assert (editor.isVisible(), editor.name.text()) == (True, "H6")
    editor.ask_save = choosing(tmp_path / "none" / "x.toml")
    one.click(editor.save)
    assert editor.strip.notice is not None  # the folder is not there
    page.edit_profile()
    assert page.editor is editor
    editor.ask_save = choosing(tmp_path / "x.toml")
    one.click(editor.save)
    assert read_profile(tmp_path / "x.toml").name == "H6"
    assert page.form.path == tmp_path / "x.toml"
    page.edit_profile()
    editor = given(page.editor)
    qtbot.keyClicks(editor.limits["tilt_max_deg"], "99")  # the field was empty, as its number still is
    one.click(editor.cancel)
    one.click(given(editor.strip.button("discard")))
    assert page.editor is None
    assert page.list.isVisible()
    assert read_profile(tmp_path / "x.toml").name == "H6"
    assert window.close()
