"""No careless gesture completes an act, whatever happens meanwhile; `make hands` tries many more."""

import datetime
import random
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

import pytest
from PySide6.QtCore import Qt
from PySide6.QtWidgets import QApplication, QComboBox

from app.guided.results import GuidedKind
from app.safety.journal import Act
from tests.campaigns.hands import Hands, Report, at_the_window, run
from tests.campaigns.ledger import DEPLOY, ENABLED, GO, UNLOCKED
from tests.support.thorough import IS_THOROUGH
from ui.pages.preflight.guided import GuidedPanel

SEQUENCES = 200 if IS_THOROUGH else 30


@pytest.fixture
def hands(qapp: QApplication, tmp_path: Path) -> Iterator[Hands]:
    with at_the_window(qapp, tmp_path, Report(), random.Random(1)) as hands:
        yield hands


def confirm(hands: Hands, act: Act) -> None:
    hands.window.go_to("commands")
    hands.confirm(hands.commands.acts[act].confirm)


def change_baud(hands: Hands) -> None:
    hands.window.go_to("settings")
    box = hands.settings.baud.editor
    assert isinstance(box, QComboBox)
    box.setCurrentIndex(box.findData(57600))
    box.activated.emit(box.currentIndex())
    hands.confirm(hands.settings.baud.confirm)


def activate_in_the_tilt_test(hands: Hands) -> None:
    hands.window.go_to("preflight")
    hands.preflight.show_view("guided")
    panel = hands.find(GuidedPanel)
    panel.work.choose(GuidedKind.TILT)
    panel.work.state_safe(True)
    hands.until(lambda: panel.work.can_start)
    panel.work.start()
    hands.confirm(panel.activate.confirm)


def enable_in_a_check(hands: Hands) -> None:
    hands.window.go_to("preflight")
    hands.bring(hands.preflight.enable)
    hands.do_whole(hands.preflight.enable)


def write_to_an_active_module(hands: Hands) -> None:
    hands.put_in_order(is_active=True)
    hands.window.go_to("settings")
    hands.settings.work.fill({"attitude_threshold_deg": 30})
    hands.wait(0.4)
    hands.press_write()


def deploy(hands: Hands, *, holds: bool = True) -> None:
    hands.put_in_order(is_active=True)
    ritual = hands.commands.ritual
    hands.window.go_to("commands")
    hands.until(ritual.choose.isEnabled)
    hands.do_whole(ritual.choose)
    hands.do_whole(ritual.arm)
    if holds:
        hands.do_whole(ritual.hold)
    else:
        hands.move(hands.at(ritual.hold))
        hands.wait(0.6)
        hands.press()
        hands.wait(1.2)
        hands.release()


# What is done, and what leaves for it.
WHOLE: dict[str, tuple[Callable[[Hands], None], tuple[str, ...]]] = {
    **{
        f"act_{act.value}": (partial(confirm, act=act), (GO[f"act_{act.value}_go"],))
        for act in (Act.ACTIVATE, Act.ZERO, Act.SHUTDOWN, Act.FORBID_DEPLOY)
    },
    "change of the baud rate": (change_baud, (GO["baud_go"],)),
    "activation in the tilt test": (activate_in_the_tilt_test, (GO["guided_activate_go"],)),
    "enabling in a check": (enable_in_a_check, ENABLED),
    "write to an active module, against advice": (write_to_an_active_module, (UNLOCKED,)),
    "deployment": (deploy, (DEPLOY,)),
}


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
    hands.window.go_to("commands")
    ask = hands.commands.acts[Act.ACTIVATE].confirm
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


def activate_then_lock(hands: Hands) -> None:
    """LOCK takes away what was confirmed and waits on a slow line."""
    hands.window.go_to("commands")
    ask = hands.commands.acts[Act.ACTIVATE].confirm
    hands.bring(ask.ask)
    hands.do_whole(ask.ask)
    hands.bench.change(delay_ms=220.0)
    hands.do_whole(ask.go)
    hands.press_lock()
    hands.wait(8.0)


def let_go_early(hands: Hands) -> None:
    deploy(hands, holds=False)
    hands.wait(2.0)


@pytest.mark.parametrize("act", [activate_then_lock, let_go_early])
@pytest.mark.parametrize("hold_s", [2.0, 0.8])
@pytest.mark.promise("d")
def test_what_is_taken_back_does_not_leave(
    act: Callable[[Hands], None], hold_s: float, hands: Hands, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Were 0.8 s enough for the last step, the ledger would say so."""
    monkeypatch.setattr("app.safety.ritual.HOLD_S", hold_s)
    act(hands)
    assert bool(hands.report.faults) is (hold_s < 2.0 and act is let_go_early)
