"""What is done with several modules at once: checks, their reports, one profile."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest
from PySide6.QtWidgets import QWidget

from app.engine.identity import Identity, Trust
from app.engine.procedure import Cancelled, Procedure
from app.fleet.check_set import SetMember, write_set_reports
from app.fleet.profile_table import Applied
from app.preflight.evidence import Disturbance, Evidence
from app.preflight.run import run_preflight
from app.preflight.verdict import assess
from app.records.check_store import CheckStore
from app.records.filing import Filed
from app.records.labels import Printer
from app.settings.profiles import Profile
from app.store.database import StoreFault, StoreTrouble
from app.store.store import Store
from tests.support.records.preflight_rig import check
from tests.support.window.fakes_ui import speak_chinese
from tests.ui.pages.fleet.conftest import Desk
from ui.files.file_dialogs import ThenPath
from ui.pages.fleet import group_jobs


def test_a_group_act_sends_questions_and_settings_only_where_it_may(desk: Desk) -> None:
    """The check asks; the profile writes settings. Nothing else that a person does here reaches several modules."""
    desk.plug_in(3)
    desk.modules[1][1].hand_over(identity=Identity(Trust.REFUTED))
    desk.settle()
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
    assert {one.verdict for one in results.values()} <= {None}
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
    assert shown.data() == "FAILED: Link lost: the rest is unknown."
    speak_chinese()
    assert shown.data().endswith("通信中断：其余未知。")


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


@pytest.mark.parametrize("is_enabling", [False, True])
def test_the_triggers_of_all_are_enabled_only_where_that_was_pressed(
    desk: Desk, is_enabling: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The check itself enables them on a locked module only."""
    begun: list[object] = []

    def noted(evidence: Evidence, **options: Any) -> Procedure[Evidence]:
        begun.append(options["is_enabling"])
        return run_preflight(evidence, **options)

    monkeypatch.setattr(group_jobs, "run_preflight", noted)
    desk.plug_in(2)
    if is_enabling:
        desk.page.enable.trigger()
    else:
        desk.click(desk.page.check)
    assert begun == [is_enabling] * 2
    desk.page.checks.cancel()


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


def test_a_check_that_could_not_be_stored_says_why(desk: Desk, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    full = StoreTrouble(StoreFault.FULL, tmp_path)
    filed = Filed(assess(check().assessment.case), {}, full)
    monkeypatch.setattr(group_jobs, "file_in_background", lambda *_, then, **__: then(filed))
    desk.plug_in(1)
    ((connection, worker),) = desk.modules
    desk.click(desk.page.check)
    desk.page.checks._running[connection].evidence.began_at = 0.0
    worker.end_jobs(Cancelled())
    desk.wait(lambda: not desk.page.checks.is_running)
    assert desk.page.checks.results[connection].trouble == full.message
    assert connection.kept.check is not None
    assert connection.kept.check.filed is filed


def test_a_check_whose_module_got_another_name_meanwhile_is_not_kept(
    desk: Desk, monkeypatch: pytest.MonkeyPatch
) -> None:
    kept: list[tuple[bool, object]] = []
    monkeypatch.setattr(
        group_jobs, "file_in_background",
        lambda _task, evidence, *_, is_stored, **__: kept.append((is_stored, evidence.disturbance)),
    )  # fmt: skip
    desk.plug_in(1)
    ((connection, worker),) = desk.modules
    desk.click(desk.page.check)
    evidence = desk.page.checks._running[connection].evidence
    evidence.began_at, evidence.ended_at = desk.ports.now_s, desk.ports.now_s
    connection.module.choose("M-2")
    worker.end_jobs()
    desk.wait(lambda: bool(kept))
    assert kept == [(False, Disturbance.CHANGED)]


def test_named_silent_modules_are_said_to_be_new_by_one_press(desk: Desk) -> None:
    case = check(options={"mute_codes": "35"}).assessment.case
    desk.plug_in(3)
    for (connection, _), name in zip(desk.modules, ("M-1", "", "M-2"), strict=True):
        desk.page.checks.results[connection] = SetMember("port", name, Filed(assess(case), {}))
    desk.page.checks.finished.emit()
    desk.settle()
    assert desk.page.notice_bar.notice is not None
    (say,) = desk.page.notice_bar.notice.choices
    assert say.text == "New, no records: M-1, M-2"
    say.act()
    desk.wait(lambda: desk.page.checks.is_running)
    store = desk.services.storage.store
    assert isinstance(store, Store)
    known = {module.name: CheckStore(store.database).is_said_new(module.name) for module in store.modules()}
    assert known == {"M-1": True, "M-2": True}


@pytest.mark.parametrize("change", ["another module", "disconnected"])
def test_what_was_said_of_a_set_ends_with_any_of_its_modules(desk: Desk, change: str) -> None:
    desk.plug_in(2)
    desk.click(desk.page.check)
    for _, worker in desk.modules:
        worker.end_jobs(Cancelled())
    desk.wait(lambda: desk.page.notice_bar.notice is not None and not desk.page.checks.is_running)
    port, worker = desk.modules[1]
    assert port is not desk.services.connector.current
    if change == "another module":
        port.module.treat_as_new()
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
        desk.page.checks.results = {}  # another check has begun meanwhile
        then(tmp_path / "fleet.pdf")

    def write(path: Path, members: Sequence[SetMember], printer: Printer) -> tuple[Path, ...]:
        asked.append(str(len(members)))
        return write_set_reports(path, members, printer)

    monkeypatch.setattr("ui.pages.fleet.page.write_set_reports", write)
    desk.page.ask_report = choose
    desk.page.report.trigger()
    desk.wait(lambda: desk.page.notice_bar.notice is not None and "fleet.pdf" in desk.page.notice_bar.notice.text)
    assert asked == ["Export report…", "2"]
    assert [path.name for path in tmp_path.glob("fleet*")] == ["fleet.pdf"]  # neither module has a record
    assert (tmp_path / "fleet.pdf").read_bytes().startswith(b"%PDF")
