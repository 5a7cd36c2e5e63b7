"""What is done with several modules at once: checks, reports, one profile; what is asked before one is left."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import pytest

from app.engine.procedure import Cancelled, Procedure
from app.preflight.checks import Person
from app.preflight.evidence import Evidence
from app.preflight.run import run_preflight
from app.procedures.read import Readings, read_everything
from app.procedures.write import SettingChange, WriteContext
from app.settings.profiles import NO_PROFILE, Profile
from protocol.events import EndReason
from tests.support.window.fake_ports import stand
from tests.support.window.steps import given
from tests.window.pages.fleet.conftest import Desk
from ui.pages.fleet.board import NEXT

STEEPER = Profile(name="Show", settings={"attitude_threshold_deg": 70})


def open_profile(desk: Desk, profile: Profile = STEEPER) -> None:
    desk.page.result.dismiss()
    desk.page.profile.open(profile)
    desk.settle()


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
    assert desk.page.checks.verdicts == [None] * 3
    open_profile(desk)
    desk.press("write")
    assert [desk.cell(number, NEXT) for number in range(3)] == ["offline", "writing", "writing"]
    desk.modules[1][1].unplug()
    desk.settle()
    assert [desk.cell(number, NEXT) for number in range(3)] == ["offline", "FAILED: The port was lost.", "writing"]
    port = desk.modules[1][0]
    reports = [one.text.in_english() for one in port.interruptions.remainders if one.text is not None]
    assert reports == ["Profile: The port was lost."]
    desk.modules[1][1].open("/dev/port1", 115200)
    desk.modules[1][1].say(attitude_threshold_deg=60)
    desk.settle()
    assert desk.cell(1, NEXT) == "Attitude threshold 60° → 70°"  # another module may be there
    assert "1 FAILED: port1 (The port was lost.)" in desk.notice  # it is told until the next writing


def test_only_what_is_ticked_is_checked_and_written(desk: Desk) -> None:
    desk.plug_in(3)
    desk.tick(1, is_ticked=False)
    desk.click(desk.page.check)
    assert [len(worker.jobs) for _, worker in desk.modules] == [2, 1, 2]
    assert len(desk.page.checks.verdicts) == 0
    for _, worker in desk.modules:
        worker.end_jobs(Cancelled())
    desk.wait(lambda: len(desk.page.checks.verdicts) == 2)
    open_profile(desk)
    asked = [len(worker.jobs) for _, worker in desk.modules]
    desk.press("write")
    assert [len(worker.jobs) for _, worker in desk.modules] == [asked[0] + 1, asked[1], asked[2] + 1]
    assert "→" not in desk.cell(1, NEXT)
    desk.page.profile.cancel()
    for number in (0, 2):
        desk.tick(number, is_ticked=False)
    desk.settle()
    assert not desk.page.check.isEnabled()


def test_a_profile_is_opened_and_what_is_wrong_with_a_file_is_said(desk: Desk, tmp_path: Path) -> None:
    desk.plug_in(1, attitude_threshold_deg=70)
    path = tmp_path / "show.toml"
    desk.page.ask_profile = lambda _parent, _folder, then: then(path)
    path.write_text('name = "Show"\nattitude_threshold_deg = "steep"\n', encoding="utf-8")
    desk.click(desk.page.open_profile)
    desk.settle()
    assert "show.toml" in desk.notice
    assert desk.page.profile.profile is None
    path.write_text('name = "Show"\n[settings]\nattitude_threshold_deg = 70\n', encoding="utf-8")
    desk.click(desk.page.open_profile)
    desk.settle()
    assert desk.notice.startswith("Profile: Show · ")
    assert desk.cell(0, NEXT) == "unchanged"
    assert [choice.is_enabled for choice in given(desk.page.notice_bar.notice).choices] == [True, False]
    assert desk.page.on_escape()
    desk.settle()
    assert desk.notice == ""
    assert desk.cell(0, NEXT) == "Start the check."


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
    desk.page.checks.check(None)
    desk.settle()
    assert not desk.page.check.isEnabled()
    assert [len(one.jobs) for _, one in desk.modules] == [1, 2]
    worker.end(EndReason.SILENT)
    worker.begin()
    desk.settle()
    assert second.module.check is None
    assert worker.jobs[-1][0].is_done  # it asks, and enables, nothing of another module


@pytest.mark.promise("g")
def test_a_profile_that_takes_protection_away_is_asked_about_before_it_is_written_to_any(desk: Desk) -> None:
    desk.plug_in(3)
    asked = [len(worker.jobs) for _, worker in desk.modules]
    open_profile(desk, Profile(name="Bench", settings={"attitude_trigger": False, "attitude_threshold_deg": 70}))
    desk.press("write")
    assert desk.notice == "Attitude trigger: No protection when it tips over."
    desk.press("not_now")
    assert [len(worker.jobs) for _, worker in desk.modules] == asked
    desk.press("write")
    anyway = given(desk.page.notice_bar.notice).choices[1].act
    open_profile(desk, Profile(name="Bench", settings={"attitude_trigger": False, "freefall_trigger": False}))
    anyway()  # of the former question: what is written now was not all in it
    desk.settle()
    assert [len(worker.jobs) for _, worker in desk.modules] == asked
    assert "Free-fall trigger: No protection in free fall." in desk.notice
    desk.press("write_anyway")
    assert [desk.cell(number, NEXT) for number in range(3)] == ["writing"] * 3
    desk.page.profile.cancel()


def test_the_count_is_of_what_may_be_written_and_who_is_not_written_to_is_named(desk: Desk) -> None:
    """ "Write (4)" was followed by "2 written, 1 refused" where one was ACTIVE and one was off."""
    desk.plug_in(4, attitude_threshold_deg=60)
    for number, (port, _worker) in enumerate(desk.modules):
        port.module.say_name(f"M-0{number}")
    desk.modules[1][1].say(active=True, attitude_threshold_deg=60)
    desk.modules[2][1].end(EndReason.SILENT)
    desk.settle()
    open_profile(desk)
    assert given(desk.page.notice_bar.notice).choices[1].text == "Write (2)"
    assert desk.cell(0, NEXT) == desk.cell(3, NEXT) == "Attitude threshold 60° → 70°"
    assert "ACTIVE" in desk.cell(1, NEXT)
    asked = [len(worker.jobs) for _, worker in desk.modules]
    desk.press("write")
    assert [len(worker.jobs) for _, worker in desk.modules] == [asked[0] + 1, asked[1], asked[2], asked[3] + 1]
    for number in (0, 3):
        desk.modules[number][1].end_jobs(Cancelled())
    desk.wait(lambda: not desk.page.profile.is_running)
    desk.settle()
    assert "1 refused: M-01 (The module is ACTIVE" in desk.notice
    assert "1 offline: M-02" in desk.notice
    assert "2 FAILED: M-00" in desk.notice


def test_the_settings_found_are_kept_before_the_first_write_only(desk: Desk, monkeypatch: pytest.MonkeyPatch) -> None:
    contexts = list[WriteContext]()

    def write(_changes: Sequence[SettingChange], context: WriteContext) -> Procedure[Readings]:
        contexts.append(context)
        return read_everything()

    monkeypatch.setattr("ui.pages.fleet.group_jobs.write_all", write)
    desk.plug_in(1, attitude_threshold_deg=60)
    open_profile(desk)
    for is_first in (True, False):
        desk.page.profile.apply()
        keep = contexts[-1].keep_as_found
        assert contexts[-1].accepted_risks == frozenset()
        assert (keep is not None) is is_first
        if keep is not None:
            keep({"attitude_threshold_deg": 60}, None)
        desk.modules[0][1].end_jobs(Cancelled())
        desk.wait(lambda: not desk.page.profile.is_running)


@pytest.mark.promise("l")
def test_what_is_void_of_a_set_is_not_said_any_more(desk: Desk) -> None:
    desk.plug_in(3)
    desk.click(desk.page.check)
    for connection, _ in desk.modules:
        stand(given(connection.module.check), desk.filed())
    desk.settle()
    (first, _), (second, worker), (third, _) = desk.modules
    assert desk.notice == "3 NO-GO"
    worker.end(EndReason.SILENT)
    worker.begin()  # perhaps another module
    desk.page.members.disconnect_port(third)
    desk.settle()
    assert desk.notice == "1 NO-GO, 2 not checked"
    first.treat_as_another()
    desk.settle()
    assert desk.page.checks.verdicts == [None] * 3
    assert second.module.check is None


def test_disconnecting_asks_the_window_first(desk: Desk) -> None:
    """It knows what is not written yet, and what is ACTIVE."""
    desk.plug_in(2, active=True)
    asked: list[Callable[[], object]] = []
    desk.page.leave_wanted.disconnect()
    desk.page.leave_wanted.connect(lambda port, act: asked.append(act) if port is desk.modules[1][0] else None)
    desk.board.selectRow(desk.row(1))
    desk.page.disconnect_marked.trigger()
    desk.settle()
    assert len(desk.page.members.connections) == 2
    (leave,) = asked
    leave()
    assert desk.page.members.connections == (desk.modules[0][0],)
