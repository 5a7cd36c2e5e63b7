"""A part of the adversary campaign, and proofs that its judge notices a faulty program."""

import itertools
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import msgspec
import pytest
from PySide6.QtWidgets import QApplication

from app.engine.procedure import Ask, Inspect, Pause, Procedure
from app.preflight.verdict import Assessment, Verdict
from protocol.catalogue import BY_NAME
from protocol.messages import TriggerRecord
from tests.adversary.__main__ import main, told
from tests.adversary.campaign import Desk, Plan, plan_of, plans, run_all
from tests.adversary.commands import NAMES, WINDOW
from tests.adversary.faults import DIALECTS, TROUBLES
from tests.adversary.judge import Breach

RUNS = 60

pytestmark = pytest.mark.usefixtures("qapp")


@pytest.fixture
def desk(tmp_path: Path, qapp: QApplication) -> Iterator[Desk]:
    with Desk(tmp_path) as made:
        yield made


def found(desk: Desk, trouble: str, command: str, quirks: str = "as printed") -> set[Breach]:
    return {finding.breach for finding in desk.run(Plan(quirks, trouble, command, 1)).findings}


def test_the_whole_campaign_covers_every_fault_and_command() -> None:
    planned = list(plans(5600, 1))
    assert len(set(planned)) == 5600
    assert len(TROUBLES) >= 60
    pairs = {(plan.trouble, plan.command) for plan in planned}
    assert pairs == set(itertools.product(TROUBLES, NAMES))
    assert {(plan.quirks, plan.trouble) for plan in planned} == set(itertools.product(DIALECTS, TROUBLES))
    assert {(plan.quirks, plan.command) for plan in planned} == set(itertools.product(DIALECTS, NAMES))


@pytest.mark.parametrize("command", [name for name in NAMES if name not in WINDOW])
def test_a_sound_module_on_a_perfect_line_works(command: str, desk: Desk) -> None:
    result = desk.run(Plan("as printed", "nothing", command, 1))
    assert not result.findings
    has_no_verdict = command in ("preflight", "preflight active")  # nobody knows how its triggers stand
    assert result.ran.code == (1 if has_no_verdict else 0), result.ran.err


def test_a_sound_module_at_the_window_works(desk: Desk) -> None:
    for command, gestures in WINDOW.items():
        result = desk.run(Plan("as printed", "nothing", command, 1))
        assert (result.findings, result.ran.code) == ([], 0), command
        assert gestures.acts.keys() <= result.sent.keys(), f"{command}: somebody who does nothing breaks no promise"


@pytest.mark.promise("i")
def test_a_part_of_the_campaign_finds_no_breach(tmp_path: Path) -> None:
    campaign = run_all(plans(RUNS, 1), tmp_path)
    assert campaign.breaches == [], told(campaign)
    assert campaign.said['"verified": true'] > 2, "a program that says nothing breaks no promise"


def test_a_repeated_run_is_identical(desk: Desk) -> None:
    plan = Plan("records in pieces", "corrupt both ways", "history nine", 3)
    first, second = (desk.run(plan) for _ in range(2))
    assert (first.ran.out, first.ran.took_s) == (second.ran.out, second.ran.took_s)
    assert plan_of(str(plan)) == plan


# Broken programs


def no_last_reading(patch: pytest.MonkeyPatch) -> None:
    def skipped(writing: Any) -> Procedure[None]:
        from app.procedures.write import _set_all

        yield from _set_all(writing)

    patch.setattr("app.procedures.write._write_and_read_again", skipped)


def no_reading_back(patch: pytest.MonkeyPatch) -> None:
    from protocol.messages import Reading

    def believed(command: Any) -> Procedure[Reading]:
        yield Inspect()
        return Reading(command, 70)

    patch.setattr("app.procedures.write.read_twice", believed)
    no_last_reading(patch)


def defaults_for_flags(patch: pytest.MonkeyPatch) -> None:
    from app.cli.read import json_of

    def assumed(found_: Any) -> dict[str, object]:
        answer: dict[str, Any] = msgspec.to_builtins(json_of(found_))
        answer["settings"]["attitude_trigger"] = True
        return answer

    patch.setattr("app.cli.read.json_of", assumed)


def always_ready(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(Assessment, "verdict", property(lambda _assessment: Verdict.READY))


def nothing_ends_it(patch: pytest.MonkeyPatch) -> None:
    patch.setattr("protocol.contradictions.ToldValues.contradicted", lambda *_args, **_more: None)
    patch.setattr("ui.session.check.void_reason", lambda *_args, **_more: None)


def one_pass(patch: pytest.MonkeyPatch) -> None:
    from app.procedures.history import History
    from protocol.events import Answered

    def once() -> Procedure[History]:
        outcome = yield Ask(BY_NAME["trigger_records"].query())
        messages = outcome.messages if isinstance(outcome, Answered) else ()
        records = tuple(message for message in messages if isinstance(message, TriggerRecord))
        return History(records, is_confirmed=True, is_answered=True)

    patch.setattr("app.trigger_records.filing.read_history", once)


def zero_first(patch: pytest.MonkeyPatch) -> None:
    from app.procedures.read import Everything, read_everything

    def zeroing(everything: Everything) -> Procedure[Everything]:
        yield Ask(BY_NAME["zero_sensor"].query(), is_deliberate=True)
        return (yield from read_everything(everything))

    patch.setattr("app.cli.read.read_everything", zeroing)


def never_ends(patch: pytest.MonkeyPatch) -> None:
    def waiting() -> Procedure[Any]:
        while True:
            yield Pause(1.0)

    patch.setattr("app.trigger_records.filing.read_history", waiting)


def breaks(patch: pytest.MonkeyPatch) -> None:
    def broken() -> Procedure[Any]:
        yield Inspect()
        raise KeyError("a bug")

    patch.setattr("app.trigger_records.filing.read_history", broken)


def all_is_well(patch: pytest.MonkeyPatch) -> None:
    patch.setattr("app.terminal.console.ANSWER_NO", 0)


def acknowledged_is_done(patch: pytest.MonkeyPatch) -> None:
    from app.procedures.act import _Observed
    from app.safety.journal import Outcome

    def believed(_act: Any, _raw: Any) -> Procedure[_Observed]:
        yield Inspect()
        return _Observed(Outcome.CONFIRMED)

    patch.setattr("app.procedures.act._observe", believed)


def lock_is_believed(patch: pytest.MonkeyPatch) -> None:
    from app.safety.journal import Outcome

    patch.setattr("app.procedures.lock._Proof.outcome", property(lambda _proof: Outcome.CONFIRMED))


@pytest.mark.parametrize(
    ("break_it", "trouble", "command", "breach"),
    [
        (no_last_reading, "reverts after 300 ms", "set attitude_threshold_deg", Breach.FALSE_VERIFIED),
        (nothing_ends_it, "memory changes while it stands", "window: preflight", Breach.FALSE_VERDICT),
        (no_last_reading, "time writes threshold", "set freefall_time_s", Breach.FALSE_VERIFIED),
        (no_reading_back, "keeps nothing", "set attitude_threshold_deg", Breach.FALSE_VERIFIED),
        (defaults_for_flags, "nothing", "read", Breach.WRONG_VALUE),
        (always_ready, "memory changes", "preflight triggers", Breach.FALSE_VERDICT),
        (always_ready, "somebody activates", "preflight triggers", Breach.FALSE_VERDICT),
        (one_pass, "record lost in pass 1", "history", Breach.LOST_RECORD),
        (zero_first, "nothing", "read", Breach.DANGEROUS_FRAME),
        (never_ends, "nothing", "history", Breach.HANG),
        (breaks, "nothing", "history", Breach.MISHAP),
        (all_is_well, "refuses", "set attitude_threshold_deg", Breach.EXIT_CODE),
        (lock_is_believed, "locks without effect", "lock", Breach.FALSE_OUTCOME),
        (acknowledged_is_done, "activates without effect", "activate", Breach.FALSE_OUTCOME),
        (acknowledged_is_done, "shuts down without effect", "shutdown", Breach.FALSE_OUTCOME),
    ],
)
@pytest.mark.promise("i")
def test_a_faulty_program_is_detected(
    break_it: Callable[[pytest.MonkeyPatch], None],
    trouble: str,
    command: str,
    breach: Breach,
    monkeypatch: pytest.MonkeyPatch,
    desk: Desk,
) -> None:
    break_it(monkeypatch)
    assert breach in found(desk, trouble, command)


def test_a_breach_is_reported_with_the_command_that_repeats_it(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    no_last_reading(monkeypatch)
    plan = Plan("ack one", "reverts after 300 ms", "set freefall_time_s", 4)
    said = told(run_all([plan], tmp_path))
    assert "false verified" in said
    assert f'--only "{plan}"' in said
    assert main(["--only", str(plan)]) == 1
    assert "false verified" in capsys.readouterr().out
    monkeypatch.undo()
    assert main(["--only", str(plan)]) == 0
