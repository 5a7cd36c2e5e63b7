"""What is done with several modules at once: checks, reports, one profile; what is asked before one is left."""

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from PySide6.QtWidgets import QPushButton, QWidget

from app.engine.procedure import Cancelled, Procedure
from app.fleet.check_set import SetMember, write_set_reports
from app.fleet.profile_table import Applied
from app.modules.labels import Printer
from app.preflight.evidence import Evidence
from app.preflight.findings import Case, Person
from app.preflight.run import run_preflight
from app.preflight.verdict import assess
from app.procedures.lock import Locked
from app.procedures.read import Everything, read_everything
from app.procedures.write import SettingChange, WriteContext
from app.records.filing import Filed, local_now
from app.records.record import make_record
from app.safety.journal import Outcome
from app.settings.profiles import NO_PROFILE, Profile
from app.store.kinds import PreflightCheck
from app.store.trouble import StoreFault, StoreTrouble
from app.trigger_records.kept import KeptTriggers
from protocol.events import EndReason
from tests.support.records.preflight_rig import check
from tests.support.records.stored import modules_in
from tests.support.window.fake_ports import FakeWorker
from tests.support.window.fakes_ui import store_of
from tests.support.window.steps import given, notice_text
from tests.ui.pages.fleet.conftest import Desk
from ui.files.file_dialogs import ThenPath
from ui.session.check import ENTRIES
from ui.session.left_active import LeftActiveWatch
from ui.shell.attention import Attention
from ui.widgets.notice_bar import NoticeBar


@pytest.mark.promise("l")
def test_a_group_act_sends_questions_and_settings_only_where_it_may(desk: Desk) -> None:
    """The check asks; the profile writes settings. Nothing else that a person does here reaches several modules."""
    desk.plug_in(3)
    desk.click(desk.page.check)
    assert [len(worker.jobs) for _, worker in desk.modules] == [2, 2, 2]  # the handshake, and the check
    assert not any(worker.wanted(is_urgent=True) for _, worker in desk.modules)
    desk.modules[0][1].unplug()
    desk.settle()
    assert desk.page.checks.is_running  # one that is lost stops none of the others
    for _, worker in desk.modules[1:]:
        worker.end_jobs(Cancelled())
    desk.wait(lambda: not desk.page.checks.is_running)
    results = desk.page.checks.results
    assert {result.verdict for result in results.values()} <= {None}
    assert len(results) == 3
    desk.page.profile.open(Profile(name="Show", settings={"attitude_threshold_deg": 70}))
    desk.page.profile.apply(desk.page.members.connections)
    states = [desk.page.profile.applied[one].state for one, _ in desk.modules]
    assert states == [Applied.UNREACHABLE, Applied.WRITING, Applied.WRITING]
    desk.modules[1][1].unplug()
    desk.settle()
    states = [desk.page.profile.applied[one].state for one, _ in desk.modules]
    assert states == [Applied.UNREACHABLE, Applied.FAILED, Applied.WRITING]
    shown = desk.page.panel.table.filter.index(1, 2)
    assert shown.data() == "FAILED: The port was lost."
    port = desk.modules[1][0]
    reports = [one.text.in_english() for one in port.interruptions.remainders if one.text is not None]
    assert reports == ["Profile: The port was lost."]
    desk.modules[1][1].open("/dev/port1", 115200)
    desk.modules[1][1].say(attitude_threshold_deg=60)
    desk.settle()
    assert shown.data() == ""  # another module may be there


def test_a_profile_is_opened_and_what_is_wrong_with_a_file_is_said(desk: Desk, tmp_path: Path) -> None:
    desk.plug_in(1, attitude_threshold_deg=70)
    path = tmp_path / "show.toml"
    desk.page.ask_profile = lambda _parent, _folder, then: then(path)
    for text, name, said in (
        ('name = "Show"\nattitude_threshold_deg = "steep"\n', None, True),
        ('name = "Show"\n[settings]\nattitude_threshold_deg = 70\n', "Show", False),
    ):
        path.write_text(text, encoding="utf-8")
        desk.click(desk.page.open_profile)
        desk.settle()
        profile = desk.page.profile.profile
        assert (None if profile is None else profile.name) == name
        assert (desk.page.notice_bar.notice is not None) is said
    desk.page.profile.apply(desk.page.members.connections)
    assert desk.page.profile.applied[desk.modules[0][0]].state is Applied.NOTHING_TO_DO
    assert desk.page.panel.write.text() == "No changes"
    shown = desk.page.panel.table.filter.index(0, 2)
    for exchange, before in ((desk.modules[0][1].unplug, "unchanged"), (bool, "")):
        desk.settle()
        assert shown.data() == before
        notice = desk.page.notice_bar.notice
        assert ("" if notice is None else notice.text) == (before and f"1 {before}: port0")
        exchange()
        desk.modules[0][1].open("/dev/port0", 115200)  # and another module may be there
        desk.modules[0][1].say(attitude_threshold_deg=60)


@pytest.mark.parametrize("is_enabling", [False, True])
@pytest.mark.promise("l")
def test_the_triggers_of_all_are_enabled_only_where_that_was_pressed(
    desk: Desk, is_enabling: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The check itself enables them on a locked module only."""
    begun: list[object] = []

    def noted(evidence: Evidence, **options: Any) -> Procedure[Evidence]:
        begun.append(options["is_enabling"])
        return run_preflight(evidence, **options)

    monkeypatch.setattr("ui.session.check.run_preflight", noted)
    desk.plug_in(2)
    if is_enabling:
        desk.page.enable.trigger()
    else:
        desk.click(desk.page.check)
    assert begun == [is_enabling] * 2
    desk.page.checks.cancel()


def test_a_module_that_is_being_checked_already_is_not_checked_beside_that(desk: Desk) -> None:
    desk.plug_in(2)
    second, worker = desk.modules[1]
    second.module.begin_check(NO_PROFILE, Person(), is_enabling=True)
    desk.page.checks.check(desk.page.members.connections)
    desk.settle()
    assert not desk.page.check.isEnabled()
    assert [len(one.jobs) for _, one in desk.modules] == [1, 2]
    card = given(desk.page._widgets[second].card)
    assert card.is_checking
    worker.end(EndReason.SILENT)
    worker.begin()
    desk.settle()
    assert second.module.check is None
    assert worker.jobs[-1][0].is_done  # it asks, and enables, nothing of another module


@pytest.mark.promise("g")
def test_a_profile_that_takes_protection_away_is_asked_about_before_it_is_written_to_any(desk: Desk) -> None:
    desk.plug_in(3)
    page, strip = desk.page, desk.page.notice_bar
    page.profile.open(Profile(name="Bench", settings={"attitude_trigger": False, "attitude_threshold_deg": 70}))
    desk.settle()
    page.panel.write_pressed.emit()
    desk.settle()
    assert page.profile.applied == {}
    assert strip.notice is not None
    assert strip.notice.text == "Attitude trigger: No protection when it tips over."
    cancel, anyway = (choice.act for choice in strip.notice.choices)
    cancel()
    desk.settle()
    assert (strip.notice, page.profile.applied) == (None, {})
    page.profile.open(Profile(name="Bench", settings={"attitude_trigger": False, "freefall_trigger": False}))
    anyway()  # of the former question: what is written now was not all in it
    desk.settle()
    assert page.profile.applied == {}
    assert strip.notice is not None
    assert "Free-fall trigger: No protection in free fall." in strip.notice.text
    strip.notice.choices[1].act()
    assert [page.profile.applied[one].state for one, _ in desk.modules] == [Applied.WRITING] * 3
    page.profile.cancel()


def test_the_count_is_of_what_may_be_written_and_who_is_not_written_to_is_named(desk: Desk) -> None:
    """ "Write (4)" was followed by "2 written, 1 refused" where one was ACTIVE and one was off."""
    desk.plug_in(4, attitude_threshold_deg=60)
    for number, (port, _worker) in enumerate(desk.modules):
        port.module.say_name(f"M-0{number}")
    desk.modules[1][1].say(active=True, attitude_threshold_deg=60)
    desk.modules[2][1].end(EndReason.SILENT)
    desk.settle()
    desk.page.profile.open(Profile(name="Show", settings={"attitude_threshold_deg": 70}))
    desk.settle()
    assert desk.page.panel.write.text() == "Write (2)"
    shown = [desk.page.panel.table.filter.index(row, 2).data() for row in range(4)]
    assert [bool(text) for text in shown] == [False, True, True, False]  # before anything is written
    assert "ACTIVE" in shown[1]
    asked = [len(worker.jobs) for _, worker in desk.modules]
    desk.page.profile.apply(desk.page.members.connections)
    assert [len(worker.jobs) for _, worker in desk.modules] == [asked[0] + 1, asked[1], asked[2], asked[3] + 1]
    for number in (0, 3):
        desk.modules[number][1].end_jobs(Cancelled())
    desk.wait(lambda: not desk.page.profile.is_running)
    desk.settle()
    said = given(desk.page.notice_bar.notice).text
    assert "1 refused: M-01 (The module is ACTIVE" in said
    assert "1 offline: M-02" in said
    assert "2 FAILED: M-00" in said


def test_the_settings_found_are_kept_before_the_first_write_only(desk: Desk, monkeypatch: pytest.MonkeyPatch) -> None:
    contexts = list[WriteContext]()

    def write(_changes: Sequence[SettingChange], context: WriteContext) -> Procedure[Everything]:
        contexts.append(context)
        return read_everything()

    monkeypatch.setattr("ui.pages.fleet.group_jobs.write_all", write)
    desk.plug_in(1, attitude_threshold_deg=60)
    desk.page.profile.open(Profile(name="Show", settings={"attitude_threshold_deg": 70}))
    for is_first in (True, False):
        desk.page.profile.apply(desk.page.members.connections)
        keep = contexts[-1].keep_as_found
        assert (keep is not None) is is_first
        if keep is not None:
            keep({"attitude_threshold_deg": 60}, None)
        desk.modules[0][1].end_jobs(Cancelled())
        desk.wait(lambda: not desk.page.profile.is_running)


def _filed(case: Case, trouble: StoreTrouble | None = None) -> Filed:
    assessment = assess(case)
    return Filed(assessment, make_record(assessment, at=local_now()), None, trouble)


@pytest.mark.parametrize("has_store", [False, True])
def test_a_check_that_could_not_be_stored_says_why(
    desk: Desk, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, has_store: bool
) -> None:
    full = StoreTrouble(StoreFault.FULL, tmp_path)
    filed = _filed(check().assessment.case, full if has_store else None)
    if not has_store:
        monkeypatch.setattr(type(desk.services.storage), "begun", None)
        monkeypatch.setattr(type(desk.services.storage), "store", full)
    monkeypatch.setattr("ui.session.check.file_check", lambda *_, **__: filed)
    desk.plug_in(1)
    ((connection, worker),) = desk.modules
    desk.click(desk.page.check)
    assert connection.module.check is not None
    connection.module.check.evidence.began_at = 0.0
    worker.end_jobs(Cancelled())
    desk.wait(lambda: not desk.page.checks.is_running)
    assert desk.page.checks.results[connection].trouble == full.message
    assert connection.module.check.filed is filed


def test_a_check_whose_module_got_another_name_meanwhile_is_not_kept(desk: Desk) -> None:
    desk.plug_in(1)
    ((connection, worker),) = desk.modules
    connection.module.say_name("M-1")
    desk.click(desk.page.check)
    assert connection.module.check is not None
    evidence = connection.module.check.evidence
    evidence.began_at, evidence.ended_at = desk.ports.now_s, desk.ports.now_s
    connection.module.say_name("M-2")
    worker.end_jobs()
    desk.wait(lambda: not desk.page.checks.is_running)
    member = desk.page.checks.results[connection]
    assert (member.name, member.verdict, member.trouble) == ("M-1", None, ENTRIES.message)  # void, as its card says
    assert connection.module.check.void == ENTRIES
    store = store_of(desk.services.storage)
    assert store.read(lambda facts: facts.of_kind(PreflightCheck)) == []


def test_named_silent_modules_are_said_to_be_new_by_one_press(desk: Desk) -> None:
    case = check(options={"mute_codes": "35"}).assessment.case
    store = store_of(desk.services.storage)  # only where it is open something can be said of its modules
    desk.plug_in(3)
    for (connection, _), name in zip(desk.modules, ("M-1", "", "M-2"), strict=True):
        desk.page.checks._ended[connection] = partial(SetMember, "port", name, _filed(case))
    desk.page.checks.finished.emit()
    desk.settle()
    (say,) = given(desk.page.notice_bar.notice).choices
    assert say.text == "New, no records: M-1, M-2"
    say.act()
    desk.wait(lambda: desk.page.checks.is_running)
    names = [module.name for module in modules_in(store)]
    known = store.read(lambda facts: {name: KeptTriggers(facts).is_said_new(name) for name in names})
    assert known == {"M-1": True, "M-2": True}


@pytest.mark.parametrize("change", ["another module", "disconnected"])
@pytest.mark.promise("l")
def test_what_was_said_of_a_set_ends_with_any_of_its_modules(desk: Desk, change: str) -> None:
    desk.plug_in(2)
    desk.click(desk.page.check)
    for _, worker in desk.modules:
        worker.end_jobs(Cancelled())
    desk.wait(lambda: desk.page.notice_bar.notice is not None and not desk.page.checks.is_running)
    port, worker = desk.modules[1]
    assert port is not desk.services.ports.current
    if change == "another module":
        worker.end(EndReason.ANOTHER)
        worker.begin()
    else:
        desk.page.members.disconnect_port(port)
    worker.hand_over()
    desk.settle()
    assert desk.page.notice_bar.notice is None


def test_the_report_of_all_is_exported_by_its_button(
    desk: Desk, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    desk.plug_in(2)
    assert not desk.page.report.isEnabled()  # nothing was checked
    desk.click(desk.page.check)
    for _, worker in desk.modules:
        worker.end_jobs(Cancelled())
    desk.wait(desk.page.report.isEnabled)
    asked: list[str] = []

    def choose(_parent: QWidget, title: str, _suggested: Path, _kinds: str, then: ThenPath) -> None:
        asked.append(title)
        desk.page.checks._ended = {}  # another check has begun meanwhile
        then(tmp_path / "fleet.pdf")

    def write(path: Path, members: Sequence[SetMember], printer: Printer) -> tuple[Path, ...]:
        asked.append(str(len(members)))
        return write_set_reports(path, members, printer)

    monkeypatch.setattr("ui.pages.fleet.page.write_set_reports", write)
    desk.page.ask_report = choose
    desk.page.report.trigger()
    desk.wait(lambda: "fleet.pdf" in notice_text(desk.page.notice_bar))
    assert asked == ["Export report…", "2"]
    assert [path.name for path in tmp_path.glob("fleet*")] == ["fleet.pdf"]  # neither module has a record
    assert (tmp_path / "fleet.pdf").read_bytes().startswith(b"%PDF")


# Leaving


def attention_of(desk: Desk, page: str = "fleet") -> tuple[Attention, NoticeBar]:
    """The window's, wired as there, while this page is shown."""
    bar, connector = NoticeBar(), desk.ports.ports
    desk.qtbot.addWidget(bar)
    attention = Attention(
        connector, bar, acts={}, pending_edits=desk.services.pending_edits, go_to=lambda _page: None,
        shown_page=lambda: page, is_choosing=lambda: False, left_active=LeftActiveWatch(connector), parent=desk.page,
    )  # fmt: skip
    desk.page.leave_wanted.disconnect()
    desk.page.leave_wanted.connect(lambda port, act: attention.leave_port(act, port=port))
    return attention, bar


def press(bar: NoticeBar, key: str) -> None:
    button = bar.button(key)
    assert isinstance(button, QPushButton)
    button.click()


def lock_ended(desk: Desk, worker: FakeWorker, outcome: Outcome = Outcome.CONFIRMED) -> None:
    """LOCK that was pressed has ended so."""
    if outcome is Outcome.CONFIRMED:
        worker.say(active=False)
    worker.finish(worker.wanted(is_urgent=True)[-1], Locked(outcome=outcome, sent=50))
    desk.settle()


def test_disconnecting_a_card_asks_before_edits_are_lost(desk: Desk) -> None:
    desk.plug_in(2)
    _, bar = attention_of(desk)
    (first, _), (second, _) = desk.modules
    first.module.settings.choose("freefall_time_s", 1.2)
    desk.page._widgets[first].disconnect_action.trigger()
    desk.settle()
    assert desk.ports.ports.current is first
    assert bar.notice is not None
    assert bar.notice.text == "Settings not written: 1."
    bar.notice.choices[1].act()
    desk.settle()
    assert desk.page.members.connections == (second,)


def test_disconnecting_the_card_of_an_active_module_asks_first(desk: Desk) -> None:
    desk.plug_in(2)
    _, bar = attention_of(desk)
    (first, _), (second, worker) = desk.modules
    worker.say(active=True)
    desk.settle()
    desk.page._widgets[second].disconnect_action.trigger()
    desk.settle()
    assert desk.page.members.connections == (first, second)
    assert notice_text(bar) == "/dev/port1: The module is ACTIVE: it fires also without this program."
    press(bar, "lock_and_leave")
    assert [len(one.wanted(is_urgent=True)) for _, one in desk.modules] == [0, 1]
    lock_ended(desk, worker)
    assert desk.page.members.connections == (first,)


def test_leaving_that_was_cancelled_is_not_done_when_lock_is_confirmed(desk: Desk) -> None:
    desk.plug_in(1, active=True)
    attention, bar = attention_of(desk)
    ((port, worker),) = desk.modules
    desk.page._widgets[port].disconnect_action.trigger()
    press(bar, "lock_and_leave")
    attention.stay()
    lock_ended(desk, worker)
    assert port.is_requested


@pytest.mark.promise("l")
def test_closing_asks_while_any_module_is_active_and_locks_all_of_them(desk: Desk) -> None:
    desk.plug_in(2)
    (attention, bar), closed = attention_of(desk), list[bool]()
    assert attention.may_close(lambda: closed.append(True))
    desk.modules[1][1].say(active=True)  # not the one that the pages show
    desk.settle()
    assert not attention.may_close(lambda: closed.append(True))
    press(bar, "lock_and_leave")
    assert [len(worker.wanted(is_urgent=True)) for _, worker in desk.modules] == [1, 1]
    assert not closed


def test_a_lock_that_another_port_does_not_confirm_is_said_on_every_page(desk: Desk) -> None:
    desk.plug_in(2, active=True)
    _, bar = attention_of(desk, page="live")
    (_, first), (second, worker) = desk.modules
    second.module.say_name("M-02")
    second.lock.press()
    lock_ended(desk, worker, Outcome.UNKNOWN)
    assert bar.notice is not None
    assert bar.notice.text == "NOT reported, treat as ACTIVE: M-02"
    press(bar, "lock_others")
    assert [len(one.wanted(is_urgent=True)) for one in (first, worker)] == [0, 2]
    lock_ended(desk, worker)
    assert bar.notice is None
