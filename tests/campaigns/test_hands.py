"""No careless gesture completes an act, whatever happens meanwhile; `make hands` tries many more."""

import datetime
import random
from collections.abc import Iterator
from pathlib import Path

import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QApplication

from app.safety.journal import Act
from tests.campaigns.hands import WHOLE, Hands, Report, at_the_window, deploy, run
from tests.campaigns.ledger import ENABLED
from tests.support.thorough import IS_THOROUGH

SEQUENCES = 200 if IS_THOROUGH else 30


@pytest.fixture
def hands(qapp: QApplication, tmp_path: Path) -> Iterator[Hands]:
    with at_the_window(qapp, tmp_path, Report(), random.Random(1)) as hands:
        yield hands


@pytest.mark.parametrize("name", WHOLE)
@pytest.mark.promise("d")
def test_a_whole_gesture_completes_each_once(name: str, hands: Hands) -> None:
    """Without that the others would prove nothing."""
    act, leaves = WHOLE[name]
    act(hands)
    hands.wait(9.0 if leaves is ENABLED else 3.0)
    left = {kind: count for kind, count in hands.report.frames.items() if kind not in ("LOCK", "write")}
    assert left == dict.fromkeys(leaves, 1)
    assert hands.report.faults == []


@pytest.mark.promise("d", "i")
def test_nothing_leaves_a_window_but_what_hands_completed(qapp: QApplication) -> None:
    """Other hands each day."""
    seed = datetime.datetime.now(datetime.UTC).date().toordinal()
    assert run(qapp, SEQUENCES, seed).faults == [], f"seed {seed}"


@pytest.mark.promise("d")
def test_while_a_key_is_down_since_before_a_step_appeared_no_key_completes_it(hands: Hands) -> None:
    ask = hands.commands.acts[Act.ACTIVATE].confirm
    hands.window.go_to("commands")
    hands.bring(ask.ask)
    hands.key(Qt.Key.Key_Return, is_press=True)
    hands.do_whole(ask.ask)
    hands.wait(1.0)
    for is_held in (True, False):
        if not is_held:
            hands.key(Qt.Key.Key_Return, is_press=False)
        ask.go.setFocus()
        for is_press in (True, False):
            hands.key(Qt.Key.Key_Space, is_press=is_press)
            hands.look()
        assert ask.is_asking is is_held


@pytest.mark.promise("d")
def test_lock_takes_away_what_was_confirmed_and_waits_on_a_slow_line(hands: Hands) -> None:
    ask = hands.commands.acts[Act.ACTIVATE].confirm
    hands.window.go_to("commands")
    hands.bring(ask.ask)
    hands.do_whole(ask.ask)
    hands.bench.change(delay_ms=220.0)
    hands.do_whole(ask.go)
    hands.press_lock()
    hands.wait(8.0)
    assert hands.report.faults == []


@pytest.mark.parametrize("needed_s", [2.0, 0.8])
@pytest.mark.promise("d")
def test_who_lets_go_early_deploys_nothing(needed_s: float, hands: Hands, monkeypatch: pytest.MonkeyPatch) -> None:
    """Were 0.8 s enough for the last step, the ledger would say so."""
    monkeypatch.setattr("app.safety.ritual.HOLD_S", needed_s)
    deploy(hands, held_s=1.2)
    hands.wait(2.0)
    assert bool(hands.report.faults) is (needed_s < 2.0)
