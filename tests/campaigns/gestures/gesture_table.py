"""The table of careless gestures: every point of every first button of every act, and what is pressed there how fast.

Whatever is done at one unmoved point must never complete an act: nothing may leave, and nothing may be begun.
"""

import tempfile
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Final

from PySide6.QtCore import QPoint, QRect
from PySide6.QtWidgets import QApplication, QComboBox, QWidget

from app.guided.results import GuidedKind
from app.safety.acts import Act
from app.text.i18n import CHINESE, ENGLISH
from tests.campaigns.gestures.gesture_bench import TICK_S, GestureBench, gesture_bench
from tests.support.pseudo_language import PSEUDO
from tests.support.window.steps import given
from ui.acts.confirm import Confirm
from ui.session.guided import Stage
from ui.widgets.notice_bar import NoticeBar
from ui.widgets.step_button import bring_into_sight

SIZES: Final = ((1024, 600), (1366, 768))
LANGUAGES: Final = (ENGLISH, CHINESE, PSEUDO)
GRID_PX: Final = 4
GAPS_S: Final = (0.0, 0.06, 0.15, 0.25, 0.35, 0.45, 0.499, 0.55, 0.6)
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


def _arm(bench: GestureBench) -> None:
    _choose(bench)
    bench.go_and_click(bench.commands.ritual.arm)


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
GESTURES: Final = ("click", "double click", "click, click", "click, click, hold")


def points(widget: QWidget) -> Iterator[QPoint]:
    """Yield points of a grid over the button where a press reaches it."""
    window = widget.window()
    place = QRect(widget.mapTo(window, QPoint(0, 0)), widget.size())
    for x, y in product(
        range(place.left(), place.right() + 1, GRID_PX), range(place.top(), place.bottom() + 1, GRID_PX)
    ):
        if window.childAt(QPoint(x, y)) is widget:
            yield QPoint(x, y)


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


def attempt(bench: GestureBench, act: DangerousAct, point: QPoint, gesture: str, gap_s: float) -> bool:
    """Return whether a try had no effect."""
    bench.move(QPoint(1, 1))
    bench.move(point)
    bench.click()
    settle(bench, act)
    if gesture != "click":
        bench.hand_s += gap_s
        if gesture == "double click":
            bench.double_press()
        else:
            bench.press()
        bench.release()
        bench.turn()
    if gesture.endswith("hold"):
        bench.hand_s += gap_s
        bench.press()
        if bench.commands.ritual.ritual.is_armed:
            bench.wait(HOLD_S)
        bench.release()
        bench.turn()
    settle(bench, act)
    is_armed = bench.commands.ritual.ritual.is_armed and not act.is_held
    is_begun = bench.worker.submitted > 0 and not act.is_write
    return not bench.sent and not is_begun and not is_armed


def try_act(bench: GestureBench, act: DangerousAct, *, every: int = 1, first_try: int = 0) -> tuple[int, list[str]]:
    """Make every `every`-th try at this act, starting at `first_try`; return how many there were, and those after which
    a frame was sent or an act begun."""
    go_to(bench, act)
    left = []
    grid = list(points(first_button(bench, act)))
    tries = [(point, "click", 0.0) for point in grid]
    tries += [(point, gesture, gap) for point in grid for gesture in GESTURES[1:] for gap in GAPS_S]
    tries = tries[first_try::every]
    for number, (point, gesture, gap_s) in enumerate(tries):
        if number % 100 == 99:
            bench.wait(0.3)  # what the module reports stays fresh
        first_button(bench, act)
        if not attempt(bench, act, point, gesture, gap_s):
            left.append(f"{act.name}: {gesture} at {point.x()}, {point.y()} after {gap_s} s")
            bench.worker.refuse_orders()
            bench.wait(1.0)
            go_to(bench, act)
    bench.reset()
    return len(tries), left


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


def run_window(
    application: QApplication,
    size: tuple[int, int],
    language: str,
    *,
    every: int,
    first_try: int = 0,
    acts: Sequence[DangerousAct] = ACTS,
) -> list[tuple[int, list[str]]]:
    """Try these acts in one window, one after the other."""
    with (
        tempfile.TemporaryDirectory() as folder,
        gesture_bench(application, Path(folder), language=language, size=size) as bench,
    ):
        return [try_act(bench, act, every=every, first_try=first_try) for act in acts]
