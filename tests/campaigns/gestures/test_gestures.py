"""No careless gesture completes an act, whatever happens meanwhile; `make hands` tries many more."""

import datetime
import random
from collections.abc import Callable
from pathlib import Path

import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QSignalSpy
from PySide6.QtWidgets import QApplication, QToolButton

from app.safety.journal import Act
from tests.campaigns.gestures.clumsy import Clumsy, Report, run
from tests.campaigns.gestures.gesture_bench import gesture_bench
from tests.campaigns.gestures.gesture_table import ACTS, is_possible
from tests.support.thorough import IS_THOROUGH
from tests.support.window.steps import find

SEQUENCES = 200 if IS_THOROUGH else 30


@pytest.mark.promise("d")
def test_the_whole_gesture_completes_each(qapp: QApplication, tmp_path: Path) -> None:
    """Without that the others would prove nothing."""
    with gesture_bench(qapp, tmp_path) as bench:
        assert [act.name for act in ACTS if not is_possible(bench, act)] == []


@pytest.mark.promise("d", "i")
def test_nothing_leaves_a_window_but_what_hands_completed(qapp: QApplication) -> None:
    """Other hands each day."""
    seed = datetime.datetime.now(datetime.UTC).date().toordinal()
    assert run(qapp, SEQUENCES, seed).faults == [], f"seed {seed}"


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


# What a person does on purpose, and what the ledger says of a program that counts it otherwise


def activate_then_lock(hands: Clumsy) -> None:
    """LOCK takes away what was confirmed and waits on a slow line."""
    hands.bench.window.go_to("commands")
    hands.bench.refresh()
    confirm = hands.bench.commands.acts[Act.ACTIVATE].confirm
    hands.do_whole(confirm.ask)
    hands.point_at(confirm.go)
    hands.disturb({"delay_ms": 220.0})
    hands.click()
    hands.press_lock()
    hands.wait(8.0)


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


@pytest.mark.parametrize("act", [activate_then_lock, let_go_early])
@pytest.mark.parametrize("hold_s", [2.0, 0.8])
@pytest.mark.promise("d")
def test_what_is_taken_back_does_not_leave(
    act: Callable[[Clumsy], None], hold_s: float, qapp: QApplication, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Were 0.8 s enough for the last step, the ledger would say so."""
    monkeypatch.setattr("app.safety.ritual.HOLD_S", hold_s)
    with gesture_bench(qapp, tmp_path) as bench:
        hands = Clumsy(bench, random.Random(1), Report())
        hands.put_in_order()
        hands.observer.poll()
        hands.wait(1.0)
        act(hands)
        assert bool(hands.report.faults) is (hold_s < 2.0 and act is let_go_early)
