"""Random hands at the real window, on a simulated module to which accidents happen; on a clock that they alone move.

Events go to the window's `QWindow`, as a platform sends them: Qt finds the widget under the pointer itself. Beside it
stands a second account of what the hands did (`ledger.py`): a dangerous frame without a whole gesture of its own is a
fault, and so is a LOCK that does not leave.
"""

import random
import tempfile
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Final

from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtGui import QWheelEvent
from PySide6.QtWidgets import QApplication, QComboBox, QPushButton, QWidget
from shiboken6 import isValid

from app.engine.target import Target
from app.guided.results import GuidedKind
from app.preflight.verdict import Standing
from app.safety.journal import Act
from app.simulator import bench as benches
from app.simulator.setup import Setup
from app.text.i18n import set_language
from protocol.catalogue import LOCK, Request
from protocol.fields import Value
from tests.campaigns.ledger import DEAD_S, DEPLOY, ENABLED, GO, HOLD, HOLD_S, UNLOCKED, WATCHED, Ledger
from tests.support.line.frames import echo
from tests.support.window.hand import NO_BUTTON, NO_KEY, Hand, hand_at
from tests.support.window.rig import TURN_S, is_act
from tests.support.window.steps import given
from ui.acts.confirm import Confirm
from ui.widgets.step_button import bring_into_sight, gestures

SIZES: Final = ((900, 520), (1024, 600), (1180, 720), (1366, 768))
LANGUAGES: Final = ("en", "zh_CN")
KEYS: Final = (Qt.Key.Key_Space, Qt.Key.Key_Return, Qt.Key.Key_Tab, Qt.Key.Key_Backtab, Qt.Key.Key_Escape)
VALUES: Final[Mapping[str, tuple[Value, ...]]] = {
    "attitude_threshold_deg": (30, 58, 62, 130),
    "freefall_time_s": (0.2, 1.2, 1.8),
    "light_threshold_v": (0.5, 2.0),
    "attitude_trigger": (True, False),
}
# Of the line; None is an echo. An act waits behind a slow one; slower, it would not leave at all.
FAULTS: Final[tuple[Mapping[str, object] | None, ...]] = ({"drop": 0.2}, {"lag_ms": 220.0}, {"mute": True}, None)
# Menus would grab the mouse, and the top bar would end the connection.
UNSAFE_NAMES: Final = ("top_bar", "navigation", "status_line")
UNSAFE_KINDS: Final = ("QMenuBar", "QToolButton", "QComboBox")
WINDOW_LASTS: Final = 400  # sequences; the next window has another language and size


@dataclass
class Report:
    sequences: int = 0
    frames: Counter[str] = field(default_factory=Counter)
    faults: list[str] = field(default_factory=list)


@dataclass
class Hands(Hand):
    """One pair, at one window."""

    dice: random.Random = field(default_factory=lambda: random.Random(1))
    report: Report = field(default_factory=Report)
    trail: list[str] = field(default_factory=list)
    end_echo: Callable[[], object] = bool
    _key: Qt.Key | None = None
    _is_begun = False

    def __post_init__(self) -> None:
        self.ledger = Ledger(self)

    def begin(self, report: Report, dice: random.Random) -> None:
        self.report, self.dice, self._is_begun = report, dice, True
        self.on_leaving = self.note
        self.put_in_order()
        self.wait(DEAD_S)  # what the window shows has been there for a while

    def buttons(self) -> list[QPushButton]:
        """Those in sight on the page that is shown."""
        pages = [page for page in (self.commands, self.preflight, self.settings) if page.isVisible()]
        return [one for page in pages for one in page.findChildren(QPushButton) if one.isVisible()]

    def turn(self, longest_s: float = TURN_S) -> None:
        super().turn(longest_s)
        self._look()

    def _look(self) -> None:
        if self._is_begun:
            self.ledger.is_checking = self.preflight.state.standing is Standing.CHECKING
            self.ledger.owes_lock |= self.guided.work.owes_lock
            self.ledger.look()

    def note(self, request: Request) -> None:
        """Compare a frame, as it is sent, with the gestures before it."""
        if is_act(request):
            self._look()
            kind, wrong = self.ledger.feed(request, is_active=self.bench.module.state.is_active)
            self.report.frames[kind] += 1
            if wrong:
                self.report.faults.append(f"{request.encode().hex(' ')} {wrong} after {', '.join(self.trail)}")

    # Pointer and keys

    def move(self, to: QPoint) -> None:
        window = self.window
        to = QPoint(min(max(to.x(), 1), window.width() - 2), min(max(to.y(), 60), window.height() - 2))
        self.ledger.moved(to)
        super().move(to)

    def press(self, *, is_double: bool = False) -> None:
        under: QWidget | None = self.window.childAt(self.pointer)
        while under is not None:
            if under.objectName() in UNSAFE_NAMES or any(under.inherits(kind) for kind in UNSAFE_KINDS):
                return
            under = under.parentWidget()
        if not self.is_down:
            self.ledger.mouse_down(is_double=is_double)
            super().press(is_double=is_double)

    def release(self) -> None:
        if self.is_down:
            self.ledger.mouse_up()
            super().release()

    def _double_click(self) -> None:
        self.click()
        self.wait(self.dice.choice((0.0, 0.06, 0.2, 0.35)))
        self.click(is_double=True)

    def _press_key(self) -> None:
        if self._key is None:
            self._key = self.dice.choice(KEYS)
            self.ledger.key_down(self._key)
            self.key(self._key, is_press=True)

    def _repeat_key(self) -> None:
        self._press_key()
        for _ in range(self.dice.randint(1, 20)):
            if self._key is not None:
                is_marked = not gestures().has_paired_repeats or self.dice.random() < 0.9
                self.key(self._key, is_press=False, is_repeat=True, is_marked=is_marked)
                self.key(self._key, is_press=True, is_repeat=True, is_marked=is_marked)

    def _key_up(self) -> None:
        if self._key is not None:
            key, self._key = self._key, None
            self.ledger.key_up(key)
            self.key(key, is_press=False)

    # At random

    def sequence(self) -> None:
        """Some random actions."""
        self.trail = []
        actions: dict[Callable[[], None], float] = {
            self._go_somewhere: 6, self.click: 7, self._double_click: 3, self.press: 2, self.release: 2,
            self._pause: 6, self._press_key: 4, self._key_up: 3, self._repeat_key: 2, self._scroll: 1,
            self._resize: 1, self._turn_page: 1, self._edit: 1, self._change_state: 1, self.press_lock: 0.5,
            self._accident: 1,
        }  # fmt: skip
        with_free_hands = actions | {
            self._whole_gesture: 1, self._hurry: 3, self._act_and_then: 2.5, self._write: 3,
        }  # fmt: skip
        for _ in range(self.dice.randint(3, 9)):
            possible = actions if self.is_down or self._key is not None else with_free_hands
            (action,) = self.dice.choices(list(possible), list(possible.values()))
            self.trail.append(action.__name__)
            action()
            self.look()
        self.release()
        self._key_up()
        self.wait(0.3)
        self.report.sequences += 1
        module = self.bench.module
        is_in_order = self.is_reachable and module.is_on and not module.is_triggered
        if not (is_in_order and self.assembly.ports.module.is_read) or self.dice.random() < 0.1:
            self.put_in_order()

    def _go_somewhere(self) -> None:
        buttons = self.buttons()
        if buttons and self.dice.random() < 0.85:
            one = self.dice.choice(buttons)
            self.move(
                one.mapTo(self.window, QPoint(self.dice.randrange(one.width()), self.dice.randrange(one.height())))
            )
        elif self.dice.random() < 0.5:
            self.move(self.pointer + QPoint(self.dice.randint(-3, 3), self.dice.randint(-3, 3)))
        else:
            self.move(QPoint(self.dice.randrange(self.window.width()), self.dice.randrange(self.window.height())))

    def _pause(self) -> None:
        self.wait(self.dice.choice((0.0, 0.05, 0.2, 0.4, 0.5, 0.6, 0.6, 0.9, 2.3)))

    def _scroll(self) -> None:
        place, way = QPointF(self.pointer), QPoint(0, self.dice.choice((-360, -120, 120, 360)))
        phase = Qt.ScrollPhase.NoScrollPhase
        event = QWheelEvent(place, self.window.mapToGlobal(place), QPoint(), way, NO_BUTTON, NO_KEY, phase, False)
        QApplication.sendEvent(given(self.window.windowHandle()), event)

    def _resize(self) -> None:
        self.window.resize(*self.dice.choice(SIZES))

    def _turn_page(self) -> None:
        self.window.go_to(self.dice.choice(("commands", "commands", "settings", "preflight", "preflight")))
        self.preflight.show_view(self.dice.choice(("checks", "checks", "guided")))

    def _edit(self) -> None:
        self.settings.work.fill({"attitude_threshold_deg": self.dice.choice((30, 58, 62))})
        box = self.settings.baud.editor
        if isinstance(box, QComboBox):
            box.setCurrentIndex(self.dice.randrange(box.count()))
            box.activated.emit(box.currentIndex())

    # On purpose

    def do_whole(self, one: QWidget) -> None:
        """Press it as a careful person does, from elsewhere and after a while."""
        self.move(QPoint(1, 60))
        self.wait(0.6)
        if isValid(one) and one.isVisible():  # a notice may have taken its button away meanwhile
            self.move(self.at(one))
            self.look()
            self.press()
            self.wait(HOLD_S + 0.4 if one.objectName() == HOLD else 0.0)
            self.release()
            self.look()

    def _whole_gesture(self) -> None:
        """Complete a gesture properly now and then, which proves that the rest tests something."""
        buttons = [button for button in self.buttons() if button.isEnabled() and button.objectName() in WATCHED]
        if buttons:
            self.do_whole(self.dice.choice(buttons))

    def _hurry(self) -> None:
        """Two steps in a hurry: the second one sooner than half a second after it appeared, or without leaving it."""
        before = set(self.buttons())
        self._whole_gesture()
        appeared = [one for one in self.buttons() if one not in before]
        if not appeared:
            return
        step = self.dice.choice(appeared)
        if self.dice.random() < 0.3:
            step.setFocus()
        self.move(self.at(step))
        self.wait(self.dice.choice((0.0, 0.1, 0.25, 0.35, 0.4, 0.44, 0.6)))
        if self.dice.random() < 0.3:
            self._press_key()
            self.look()
            self._key_up()
        else:
            self.click()

    def press_lock(self) -> None:
        """By its key, which counts whatever is open; it leaves at once."""
        before, is_possible = self.requests.count(LOCK), self.is_reachable
        self.ledger.lock_pressed()
        self.key(Qt.Key.Key_F12, is_press=True)
        self.key(Qt.Key.Key_F12, is_press=False)
        self.wait(0.1)
        if is_possible and self.requests.count(LOCK) == before:
            self.report.faults.append(f"LOCK did not leave after {', '.join(self.trail)}")

    def _write(self) -> None:
        """Edit some values and write them; risks are accepted, and perhaps something happens at once."""
        if self.dice.random() < 0.7:
            self.put_in_order()
        self.window.go_to("settings")
        chosen = self.dice.sample(sorted(VALUES), self.dice.randint(1, len(VALUES)))
        self.settings.work.fill({key: self.dice.choice(VALUES[key]) for key in chosen})
        self.settings.refresh()
        self.look()
        if self.dice.random() < 0.5:
            self._accident()
        self.press_write()
        self.wait(self.dice.choice((0.1, 1.0, 8.0)))

    def press_write(self) -> None:
        """And accept what it asks."""
        settings = self.settings
        settings.refresh()
        for key in ("", "write_anyway", "unlock_once"):
            button = settings.strip.button(key) if key else settings.write
            if button is not None and button.isVisible() and button.isEnabled():
                self.do_whole(button)
                ends_at_s = self.clock() + 4.0
                while settings.work.job.is_running and self.clock() < ends_at_s:
                    self.wait(TURN_S)

    def _act_and_then(self) -> None:
        """Complete an act at a module in order, perhaps on a slow line, and let something follow at once."""
        self.put_in_order()
        if self.dice.random() < 0.5:
            self.bench.change(lag_ms=220.0)
            self.settings.work.read_all()
        act = self.dice.choice(sorted(WHOLE))
        with suppress(AssertionError):  # it is not offered to this module
            WHOLE[act][0](self)
        self.wait(self.dice.choice((0.0, 0.02, 0.1)))
        follows = self.dice.choice((self.press_lock, self._accident, self.slip, self.bench.restart))
        self.trail += [act, follows.__name__]
        follows()
        self.wait(3.0)
        self.window.go_to("commands")

    # What happens to the module and its line

    @property
    def is_reachable(self) -> bool:
        bench, is_open = self.bench, self.assembly.ports.current.is_open
        return is_open and bench.holder is self.lines[-1]

    def _accident(self) -> None:
        what = self.dice.choice(
            (self._disturb, self._disturb, self._heal, self.bench.restart, self.slip, self._exchange)
        )
        self.trail.append(what.__name__)
        what()

    def _heal(self) -> None:
        self.bench.change(mute=False, drop=0.0, lag_ms=0.0)
        self.end_echo()
        self.end_echo = bool

    def _disturb(self) -> None:
        self._heal()
        fault = self.dice.choice(FAULTS)
        if fault is None:
            self.end_echo = echo(self.bench)
        else:
            self.bench.change(**fault)

    def slip(self) -> None:
        """The plug slips out and in again; the port is opened again."""
        self.bench.unplug()
        self.wait(self.dice.choice((0.02, 0.3)))
        self.bench.plug()
        self._open()

    def _open(self) -> None:
        self.assembly.ports.connect_to(Target(self.url, self.bench.module.baud_rate))
        self.turn()

    def _exchange(self) -> None:
        """Another module hangs at the port."""
        self.assembly.ports.current.disconnect_port()
        self.turn()
        name = self.url.removeprefix("sim://")
        benches.remove_bench(name)
        self.bench = benches.module(name, Setup(seed=self.dice.randrange(1000), rate=20))
        self._open()

    def _change_state(self) -> None:
        self.bench.module.activate(is_active=self.dice.random() < 0.6)

    def put_in_order(self, *, is_active: bool = False) -> None:
        """No fault, nothing asked, connected, switched on and read; LOCKED, or ACTIVE."""
        self._heal()
        bench, ports = self.bench, self.assembly.ports
        if not bench.module.is_on:
            bench.restart()
            self.wait(1.0)  # until it is noticed
        bench.module.activate(is_active=False)  # locked once, it is triggered no more
        bench.module.activate(is_active=is_active)
        if not self.is_reachable:
            bench.plug()
            ports.current.disconnect_port()
            self.turn()
            self._open()
        ends_at_s = self.clock() + 8.0
        while self.clock() < ends_at_s and not (ports.module.is_read and ports.current.is_active is is_active):
            self.wait(0.4)

    def bring(self, one: QWidget) -> None:
        """Into sight, once it can be pressed."""
        self.until(lambda: one.isVisible() and one.isEnabled())
        bring_into_sight(one.parentWidget() or one)
        self.turn()


# Whole gestures, each of which completes an act


def confirm(hands: Hands, question: Confirm) -> None:
    hands.bring(question.ask)
    hands.do_whole(question.ask)
    hands.do_whole(question.go)


def confirm_act(hands: Hands, act: Act) -> None:
    hands.window.go_to("commands")
    confirm(hands, hands.commands.acts[act].confirm)


def change_baud(hands: Hands) -> None:
    hands.window.go_to("settings")
    box = hands.settings.baud.editor
    assert isinstance(box, QComboBox)
    box.setCurrentIndex(box.findData(57600))
    box.activated.emit(box.currentIndex())
    confirm(hands, hands.settings.baud.confirm)


def enable_in_a_check(hands: Hands) -> None:
    hands.window.go_to("preflight")
    hands.preflight.show_view("checks")
    hands.bring(hands.preflight.enable)
    hands.do_whole(hands.preflight.enable)


def activate_after_a_check(hands: Hands) -> None:
    enable_in_a_check(hands)
    confirm(hands, hands.preflight.activation.confirm)


def activate_in_the_tilt_test(hands: Hands) -> None:
    hands.show_guided()
    work = hands.guided.work
    work.choose(GuidedKind.TILT)
    work.state_safe(True)
    hands.until(lambda: work.can_start)
    work.start()
    confirm(hands, hands.guided.activate.confirm)


def write_to_an_active_module(hands: Hands) -> None:
    hands.put_in_order(is_active=True)
    hands.window.go_to("settings")
    hands.settings.work.fill({"attitude_threshold_deg": 30})
    hands.wait(0.4)
    hands.press_write()


def deploy(hands: Hands) -> None:
    hands.put_in_order(is_active=True)
    ritual = hands.commands.ritual
    hands.window.go_to("commands")
    hands.until(ritual.choose.isEnabled)
    hands.do_whole(ritual.choose)
    hands.do_whole(ritual.arm)
    hands.do_whole(ritual.hold)


# What is done, and what leaves for it.
WHOLE: Final[Mapping[str, tuple[Callable[[Hands], None], tuple[str, ...]]]] = {
    **{
        f"act_{act.value}": (partial(confirm_act, act=act), (GO[f"act_{act.value}_go"],))
        for act in (Act.ACTIVATE, Act.ZERO, Act.SHUTDOWN, Act.FORBID_DEPLOY)
    },
    "change of the baud rate": (change_baud, (GO["baud_go"],)),
    "activation in the tilt test": (activate_in_the_tilt_test, (GO["guided_activate_go"],)),
    "enabling in a check": (enable_in_a_check, ENABLED),
    "activation after a check": (activate_after_a_check, (*ENABLED, GO["preflight_activate_go"])),
    "write to an active module, against advice": (write_to_an_active_module, (UNLOCKED,)),
    "deployment": (deploy, (DEPLOY,)),
}


@contextmanager
def at_the_window(qapp: QApplication, folder: Path, report: Report, dice: random.Random) -> Iterator[Hands]:
    with hand_at(Hands, qapp, folder, "commands", "preflight", "settings") as hands:
        hands.begin(report, dice)
        yield hands


def run(qapp: QApplication, sequences: int, seed: int) -> Report:
    """Run this many sequences, in one window after the other, or until something is wrong."""
    report, number = Report(), 0
    while report.sequences < sequences and not report.faults:
        dice = random.Random(f"{seed} {number}")
        set_language(LANGUAGES[number % len(LANGUAGES)])
        with (
            tempfile.TemporaryDirectory() as folder,
            at_the_window(qapp, Path(folder), report, dice) as hands,
        ):
            hands.window.resize(*SIZES[number // 2 % len(SIZES)])
            number += 1
            for _ in range(min(WINDOW_LASTS, sequences - report.sequences)):
                hands.sequence()
                if report.faults:
                    break
    return report
