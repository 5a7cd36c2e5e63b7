"""Every act that takes several steps at the window: how to come to its first step, and what its last one is."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

from PySide6.QtCore import QPoint
from PySide6.QtWidgets import QComboBox, QWidget

from app.guided.results import GuidedKind
from app.safety.journal import Act
from tests.campaigns.gestures.gesture_bench import TICK_S, GestureBench
from tests.support.window.steps import given
from ui.acts.confirm import Confirm
from ui.session.guided import Stage
from ui.widgets.notice_bar import NoticeBar
from ui.widgets.step_button import bring_into_sight

HOLD_S: Final = 2.6


@dataclass(frozen=True)
class DangerousAct:
    """An act; `prepare` leads to the button `first`, and `last` completes it."""

    name: str
    page: str
    first: Callable[[GestureBench], QWidget]
    last: Callable[[GestureBench], QWidget]
    is_active: bool = False
    prepare: Callable[[GestureBench], None] = lambda _bench: None
    is_held: bool = False
    """The last step is to hold `last`."""
    is_write: bool = False
    """The procedure itself asks for the last step, so that something is begun before it, and nothing is sent."""


def _question(
    name: str,
    page: str,
    asks: Callable[[GestureBench], Confirm],
    prepare: Callable[[GestureBench], None] = lambda _bench: None,
) -> DangerousAct:
    return DangerousAct(name, page, lambda bench: asks(bench).ask, lambda bench: asks(bench).go, prepare=prepare)


def _row(act: Act) -> DangerousAct:
    return _question(act.value, "commands", lambda bench: bench.commands.acts[act].confirm)


def _prepare_tilt(bench: GestureBench) -> None:
    """The test keeps waiting between the tries."""
    if bench.guided.work.stage is not Stage.CONFIRMING:
        bench.prepare_test(GuidedKind.TILT)


def _choice(bench: GestureBench, key: str) -> QWidget:
    bar: NoticeBar = bench.settings.strip
    return given(bar.button(key))


def _edit(bench: GestureBench) -> None:
    """Enter a threshold below the vendor's advice, which causes a warning."""
    held = bench.device.fresh("attitude_threshold_deg", bench.clock())
    bench.settings.work.choose("attitude_threshold_deg", 35 if held == 30 else 30)
    bench.refresh()


def settle(bench: GestureBench, act: DangerousAct) -> None:
    """Until a write has ended, or asks; the hands have no time meanwhile."""
    while act.is_write and bench.settings.work.job.is_running:
        bench.worker.work(TICK_S)
        bench.turn()


def _ask_to_write(bench: GestureBench) -> None:
    _edit(bench)
    bench.go_and_click(bench.settings.write)
    bench.until(lambda: bench.settings.strip.button("write_anyway") is not None)


def _choose_rate(bench: GestureBench) -> None:
    box = bench.settings.baud.editor
    assert isinstance(box, QComboBox)
    box.setCurrentIndex(box.findData(57600))
    box.activated.emit(box.currentIndex())
    bench.refresh()


def _choose(bench: GestureBench) -> None:
    bench.go_and_click(bench.commands.ritual.choose)
    bench.hand_s += 1.0


ACTS: Final = (
    *(_row(act) for act in (Act.ACTIVATE, Act.ZERO, Act.SHUTDOWN, Act.FORBID_DEPLOY)),
    _question("activate, in the tilt test", "preflight", lambda bench: bench.guided.activate.confirm, _prepare_tilt),
    _question("change_baud", "settings", lambda bench: bench.settings.baud.confirm, _choose_rate),
    DangerousAct(
        "write against advice",
        "settings",
        lambda bench: bench.settings.write,
        lambda bench: _choice(bench, "write_anyway"),
        prepare=_edit,
        is_write=True,
    ),
    DangerousAct(
        "write to an active module",
        "settings",
        lambda bench: _choice(bench, "write_anyway"),
        lambda bench: _choice(bench, "unlock_once"),
        is_active=True,
        prepare=_ask_to_write,
        is_write=True,
    ),
    DangerousAct(
        "deploy, from choosing",
        "commands",
        lambda bench: bench.commands.ritual.choose,
        lambda bench: bench.commands.ritual.arm,
        is_active=True,
    ),
    DangerousAct(
        "deploy, from arming",
        "commands",
        lambda bench: bench.commands.ritual.arm,
        lambda bench: bench.commands.ritual.hold,
        is_active=True,
        prepare=_choose,
        is_held=True,
    ),
)


def go_to(bench: GestureBench, act: DangerousAct) -> None:
    bench.window.go_to(act.page)
    if "preflight" in bench.pages:
        bench.preflight.show_view("guided")
        bench.until(lambda: not bench.guided.work.owes_lock)  # of the tilt test, which has been left
    bench.settle_module(is_active=act.is_active)
    bench.refresh()


def first_button(bench: GestureBench, act: DangerousAct) -> QWidget:
    """Restore the state before the first press; return the first button."""
    bench.reset()
    act.prepare(bench)
    bring_into_sight(act.first(bench).parentWidget() or act.first(bench))
    bench.turn()
    bench.hand_s += 1.0
    first = act.first(bench)
    assert first.isVisible(), first.objectName()
    assert first.isEnabled(), first.objectName()
    bench.sent.clear()
    bench.worker.submitted = 0
    return first


def is_possible(bench: GestureBench, act: DangerousAct) -> bool:
    """Return whether the complete gesture succeeds, without which the table would prove nothing."""
    go_to(bench, act)
    bench.go_and_click(first_button(bench, act))
    settle(bench, act)
    bench.hand_s += 1.0
    bench.turn()
    last = act.last(bench)
    bench.move(QPoint(1, 1))
    bench.move(bench.at(last))
    if act.is_held:
        bench.press()
        bench.wait(HOLD_S)
        bench.release()
        return bool(bench.worker.submitted)
    bench.click()
    if act.is_write:
        settle(bench, act)
        return bool(bench.sent)
    is_done = bool(bench.worker.submitted) or bench.commands.ritual.ritual.is_armed
    bench.worker.refuse_orders()
    bench.turn()
    return is_done
