"""No careless gesture completes an act, whatever happens meanwhile: a sample; `make gestures` runs all of it."""

import random
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any
from unittest.mock import Mock

import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QSignalSpy
from PySide6.QtWidgets import QApplication, QToolButton

from app.engine.conversation import ConversationView, Known
from app.engine.procedure import Ask, Job
from app.engine.session import Session
from app.procedures.read import read_everything
from app.safety import interlocks as safety
from app.safety.acts import Act
from app.safety.interlocks import InterlockInputs
from app.safety.permit import Permit
from app.text.messages import UserMessage
from protocol.catalogue import Hazard, Request
from protocol.link import Link
from tests.campaigns.gestures.accidents import OF_LINE, Accidents
from tests.campaigns.gestures.clumsy import Clumsy, Report
from tests.campaigns.gestures.gesture_bench import gesture_bench
from tests.campaigns.gestures.gesture_table import ACTS, LANGUAGES, SIZES, is_possible, run_window
from tests.support.line.lies import lying
from tests.support.window.steps import find

EVERY = 997
"""Of some 6,000 tries at each button."""


@pytest.mark.parametrize(("number", "language"), list(enumerate(LANGUAGES)))
@pytest.mark.promise("d")
def test_no_careless_gesture_completes_an_act(qapp: QApplication, number: int, language: str) -> None:
    """Each act is tried in one of the languages."""
    acts = ACTS[number :: len(LANGUAGES)]
    tries = run_window(qapp, SIZES[number % len(SIZES)], language, every=EVERY, first_try=7 * number, acts=acts)
    assert all(count >= 4 for count, _ in tries)
    assert [one for _, left in tries for one in left] == []


@pytest.mark.promise("d")
def test_the_whole_gesture_completes_each(qapp: QApplication, tmp_path: Path) -> None:
    """The complete gesture succeeds, without which the table would prove nothing."""
    with gesture_bench(qapp, tmp_path) as bench:
        assert [act.name for act in ACTS if not is_possible(bench, act)] == []


def test_a_menu_that_a_key_opens_is_closed(qapp: QApplication, tmp_path: Path) -> None:
    """Else it would wait for a person for ever."""
    with gesture_bench(qapp, tmp_path, pages=("commands", "settings")) as bench:
        bench.window.go_to("settings")
        bench.turn()
        more = find(bench.settings, QToolButton, "settings_more")
        more.setFocus()
        assert more.hasFocus()
        opened = QSignalSpy(more.menu().aboutToShow)
        bench.key(Qt.Key.Key_Space, is_press=True)
        bench.key(Qt.Key.Key_Space, is_press=False)
        assert opened.count() == 1
        assert QApplication.activePopupWidget() is None


# Broken programs


def go_on_after_lock(patch: pytest.MonkeyPatch) -> None:
    why_not = safety._why_not_permitted

    def permit_all(act: Act, inputs: InterlockInputs, missing: str, **more: Any) -> UserMessage | None:
        return why_not(act, replace(inputs, overtaken_at=None), missing, **more)

    def may_change(session: Session, _job: Job[object], _ask: Ask) -> bool:
        return session._link.allows_commands

    patch.setattr(safety, "_why_not_permitted", permit_all)
    patch.setattr(Session, "_may_change", may_change)


def send_sets_again(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(Request, "is_repeatable", property(lambda request: request.hazard is not Hazard.DANGEROUS))


def keep_values(patch: pytest.MonkeyPatch) -> None:
    def known(view: ConversationView, key: str, _now: float) -> Known | None:
        return view.values.get(key)

    patch.setattr(ConversationView, "known", known)


def miss_restarts(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(Link, "_end", lambda *_args: None)


def hold_lock_back(patch: pytest.MonkeyPatch) -> None:
    run = Session.run

    def run_in_turn(session: Session, job: Job[object], *, is_urgent: bool = False) -> None:
        run(session, job)

    patch.setattr(Session, "run", run_in_turn)


def hold_briefly(patch: pytest.MonkeyPatch) -> None:
    patch.setattr("app.safety.ritual.HOLD_S", 0.8)


def forget_age(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(Permit, "age_s", lambda permit, now: 0.0)


def activate(hands: Clumsy, *, is_behind_a_reading: bool) -> None:
    hands.accidents.put_in_order(hands.wait)
    hands.bench.window.go_to("commands")
    hands.bench.refresh()
    confirm = hands.bench.commands.acts[Act.ACTIVATE].confirm
    hands.do_whole(confirm.ask)
    hands.point_at(confirm.go)
    hands.accidents.slow_down()
    for _ in range(2 if is_behind_a_reading else 0):
        hands.bench.assembly.ports.module.run(read_everything(), lambda _job: None)
    hands.click()


def activate_then_lock(hands: Clumsy) -> None:
    activate(hands, is_behind_a_reading=False)
    hands.press_lock()
    hands.wait(8.0)


def activate_late(hands: Clumsy) -> None:
    activate(hands, is_behind_a_reading=True)
    hands.wait(30.0)


def let_go_early(hands: Clumsy) -> None:
    ritual = hands.bench.commands.ritual
    hands.bench.window.go_to("commands")
    hands.bench.settle_module(is_active=True)
    hands.bench.refresh()
    hands.do_whole(ritual.choose)
    hands.do_whole(ritual.arm)
    hands.point_at(ritual.hold)
    hands.press_down()
    hands.wait(1.2)
    hands.let_go()
    hands.wait(2.0)


def write_to_the_deaf(hands: Clumsy) -> None:
    settings, judge = hands.bench.settings, hands.bench.on_leaving

    def fall_silent(request: Request) -> None:
        judge(request)
        if request.is_set:
            hands.bench.bench.change(mute=True)

    hands.bench.on_leaving = fall_silent
    hands.bench.window.go_to("settings")
    hands.bench.refresh()
    settings.work.choose("attitude_threshold_deg", 62)
    hands.bench.refresh()
    hands.do_whole(settings.write)
    hands.wait(6.0)


def restart_it(hands: Clumsy) -> None:
    hands.wait(5.0)
    hands.accidents.restart()
    hands.wait(0.6)


def pull_the_plug(hands: Clumsy) -> None:
    hands.bench.bench.unplug()
    hands.wait(1.0)


HAPPENINGS = (activate_then_lock, activate_late, let_go_early, write_to_the_deaf, restart_it, pull_the_plug)


def test_a_sound_program_is_never_found_at_fault(qapp: QApplication, tmp_path: Path) -> None:
    with gesture_bench(qapp, tmp_path) as bench:
        hands = Clumsy(bench, random.Random(1), Report())
        for happens in HAPPENINGS:
            hands.recover()
            hands.observer.poll()
            hands.wait(1.0)
            happens(hands)
            hands.look()
            assert hands.report.faults == [], happens.__name__


@pytest.mark.parametrize(
    ("break_it", "happens"),
    [
        (go_on_after_lock, activate_then_lock),
        (hold_lock_back, activate_then_lock),
        (forget_age, activate_late),
        (hold_briefly, let_go_early),
        (send_sets_again, write_to_the_deaf),
        (miss_restarts, restart_it),
        (keep_values, pull_the_plug),
    ],
)
@pytest.mark.promise("i")
def test_a_faulty_program_is_detected(
    break_it: Callable[[pytest.MonkeyPatch], None],
    happens: Callable[[Clumsy], None],
    qapp: QApplication,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    with gesture_bench(qapp, tmp_path) as bench:
        report = Report()
        hands = Clumsy(bench, random.Random(1), report)
        hands.observer.poll()
        hands.wait(1.0)
        break_it(monkeypatch)
        happens(hands)
        hands.look()
        monkeypatch.undo()
    assert report.faults


def test_every_fault_of_the_line_can_happen_and_ends(qapp: QApplication, tmp_path: Path) -> None:
    with gesture_bench(qapp, tmp_path, pages=("commands",)) as bench:
        accidents = Accidents(bench, random.Random(1))
        honest = lying(bench.bench).lies
        for options in OF_LINE:
            accidents._dice = Mock(choice=Mock(return_value=options))
            accidents.disturb()
            assert (lying(bench.bench).lies != honest) is bool({"min_gap_ms", "half_duplex"} & options.keys())
            accidents.heal()
            assert lying(bench.bench).lies == honest
