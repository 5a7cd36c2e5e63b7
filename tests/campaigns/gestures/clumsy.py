"""A clumsy person at the real window: pointer and keys at random, on a simulated module to which accidents happen.

Beside it stands a second account of what the hands did (`observer.py`): a dangerous frame without a whole gesture of
its own is a fault, and so is a LOCK that does not leave.
"""

import random
import tempfile
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtGui import QWheelEvent
from PySide6.QtWidgets import QApplication, QComboBox, QPushButton, QWidget

from app.guided.results import GuidedKind
from protocol.catalogue import BY_NAME, LOCK, Command, Hazard, Request
from protocol.fields import Value
from tests.campaigns.gestures.gesture_bench import TICK_S, GestureBench, gesture_bench
from tests.campaigns.gestures.observer import DEAD_S, HOLD, WATCHED, Observer
from tests.support.line.odd_module import end_faults
from ui.widgets.gestures import gestures

SIZES: Final = ((900, 520), (1024, 600), (1180, 720), (1366, 768))
LANGUAGES: Final = ("en", "zh_CN")
KEYS: Final = (Qt.Key.Key_Space, Qt.Key.Key_Return, Qt.Key.Key_Tab, Qt.Key.Key_Backtab, Qt.Key.Key_Escape)
VALUES: Final[Mapping[Command, tuple[Value, ...]]] = {
    BY_NAME["attitude_threshold"]: (30, 58, 62, 130),
    BY_NAME["freefall_time"]: (0.2, 1.2, 1.8),
    BY_NAME["light_threshold"]: (0.5, 2.0),
    BY_NAME["attitude_trigger"]: (True, False),
}
FAULTS: Final[tuple[Mapping[str, object], ...]] = ({"drop": 0.2}, {"delay_ms": 220.0}, {"echo": True}, {"mute": True})
"""Of the line. An act waits behind a slow one; slower, it would not leave at all."""
ONLINE_WITHIN_S: Final = 8.0
CHECK_S: Final = 13.0
"""Longer than a pre-flight check takes."""
WINDOW_LASTS: Final = 400
"""Sequences per window; the next one has another language and size."""


@dataclass
class Report:
    sequences: int = 0
    frames: Counter[str] = field(default_factory=Counter)
    faults: list[str] = field(default_factory=list)


class Clumsy:
    """Random actions in one window."""

    def __init__(self, bench: GestureBench, dice: random.Random, report: Report) -> None:
        self.bench, self.dice, self.report = bench, dice, report
        self.observer = Observer(bench)
        self.trail: list[str] = []
        self._is_down = False
        self._key: Qt.Key | None = None
        bench.on_leaving = self._judge

    def sequence(self) -> None:
        """Perform some random actions, and check the promises after each."""
        self.trail = []
        for _ in range(self.dice.randint(3, 9)):
            self._act()
        self.let_go()
        self._key_up()
        self.wait(0.3)
        self.report.sequences += 1
        if not self.is_in_order or self.dice.random() < 0.1:
            self.put_in_order()

    def _act(self) -> None:
        actions = (
            (self._go_somewhere, 6), (self.click, 7), (self._double_click, 3), (self.press_down, 2), (self.let_go, 2),
            (self._pause, 6), (self._press_key, 4), (self._key_up, 3), (self._repeat_key, 2), (self._scroll, 1),
            (self._resize, 1), (self._turn_page, 1), (self._edit, 1), (self._change_module, 1), (self.press_lock, 0.5),
            (self._accident, 1),
        )  # fmt: skip
        whole = (
            (self._whole_gesture, 1), (self._hurry, 3), (self._check, 0.15), (self._guided_test, 0.5), (self._write, 3),
            (self._act_and_then, 2),
        )  # fmt: skip
        has_free_hands = not self._is_down and self._key is None
        possible = [*actions, *whole] if has_free_hands else [*actions]
        action = self.dice.choices([one for one, _ in possible], [weight for _, weight in possible])[0]
        self.trail.append(action.__name__)
        action()
        self._settle()

    def _settle(self) -> None:
        self.bench.turn()
        self.observer.poll()

    def wait(self, seconds: float) -> None:
        end_s = self.bench.hand_s + seconds
        tick_s = TICK_S if self._is_down or self._key is not None else 0.4
        while self.bench.hand_s < end_s - 1e-9:
            self.bench.wait(min(tick_s, end_s - self.bench.hand_s), tick_s=tick_s)
            self.observer.passed()
            self.observer.poll()
        self.bench.refresh()
        self.observer.poll()

    def _judge(self, request: Request) -> None:
        """Compare a frame, as it is sent, with the gestures before it."""
        if request.hazard is Hazard.NONE:
            return
        kind, wrong = self.observer.feed(request)
        self.report.frames[kind] += 1
        if wrong:
            self.report.faults.append(f"{request.encode().hex(' ')} {wrong} after {', '.join(self.trail)}")

    # The pointer

    def _go_somewhere(self) -> None:
        window = self.bench.window
        buttons = self.bench.buttons()
        if buttons and self.dice.random() < 0.85:
            one = self.dice.choice(buttons)
            offset = QPoint(self.dice.randrange(one.width()), self.dice.randrange(one.height()))
            self._move(one.mapTo(window, offset))
        elif self.dice.random() < 0.5:
            self._move(self.bench.pointer + QPoint(self.dice.randint(-3, 3), self.dice.randint(-3, 3)))
        else:
            self._move(QPoint(self.dice.randrange(window.width()), self.dice.randrange(window.height())))

    def _move(self, to: QPoint) -> None:
        window = self.bench.window
        to = QPoint(min(max(to.x(), 1), window.width() - 2), min(max(to.y(), 60), window.height() - 2))
        old = self.bench.pointer
        self.bench.move(to)
        self.observer.moved(old)

    def _is_safe_place(self) -> bool:
        """Return whether a press is allowed here: menus would grab the mouse, the top bar would end the connection."""
        under: QWidget | None = self.bench.window.childAt(self.bench.pointer)
        while under is not None:
            if under.objectName() in ("top_bar", "navigation", "status_line"):
                return False
            if any(under.inherits(kind) for kind in ("QMenuBar", "QToolButton", "QComboBox")):
                return False
            under = under.parentWidget()
        return True

    def press_down(self, *, is_double: bool = False) -> None:
        if self._is_down or not self._is_safe_place():
            return
        self._is_down = True
        self.observer.mouse_down(is_double=is_double)
        (self.bench.double_press if is_double else self.bench.press)()

    def let_go(self) -> None:
        if self._is_down:
            self._is_down = False
            self.observer.mouse_up()
            self.bench.release()

    def click(self) -> None:
        self.press_down()
        self._settle()
        self.let_go()

    def _double_click(self) -> None:
        self.click()
        self._settle()
        self.bench.hand_s += self.dice.choice((0.0, 0.06, 0.2, 0.35))
        self.press_down(is_double=True)
        self._settle()
        self.let_go()

    def _pause(self) -> None:
        self.wait(self.dice.choice((0.0, 0.05, 0.2, 0.4, 0.5, 0.6, 0.6, 0.9, 2.3)))

    def _scroll(self) -> None:
        place = QPointF(self.bench.pointer)
        event = QWheelEvent(
            place, self.bench.window.mapToGlobal(place), QPoint(), QPoint(0, self.dice.choice((-360, -120, 120, 360))),
            Qt.MouseButton.NoButton, Qt.KeyboardModifier.NoModifier, Qt.ScrollPhase.NoScrollPhase, False,
        )  # fmt: skip
        QApplication.sendEvent(self.bench.handle, event)

    # Keys

    def _press_key(self) -> None:
        if self._key is None:
            self._key = self.dice.choice(KEYS)
            self.observer.key_down(self._key)
            self.bench.key(self._key, is_press=True)

    def _repeat_key(self) -> None:
        self._press_key()
        for _ in range(self.dice.randint(1, 20)):
            if self._key is not None:
                is_marked = not gestures().has_paired_repeats or self.dice.random() < 0.9
                self.bench.key(self._key, is_press=False, is_repeat=True, is_marked=is_marked)
                self.bench.key(self._key, is_press=True, is_repeat=True, is_marked=is_marked)

    def _key_up(self) -> None:
        if self._key is not None:
            key, self._key = self._key, None
            self.observer.key_up(key)
            self.bench.key(key, is_press=False)

    # The window

    def _resize(self) -> None:
        self.bench.window.resize(*self.dice.choice(SIZES))

    def _turn_page(self) -> None:
        self.bench.window.go_to(self.dice.choice(("commands", "commands", "settings", "preflight", "preflight")))
        self.bench.preflight.show_view(self.dice.choice(("checks", "checks", "guided")))

    def _edit(self) -> None:
        settings = self.bench.settings
        settings.work.choose("attitude_threshold_deg", self.dice.choice((30, 58, 62)))
        box = settings.baud.editor
        if isinstance(box, QComboBox):
            box.setCurrentIndex(self.dice.randrange(box.count()))
            box.activated.emit(box.currentIndex())

    # What is done on purpose

    def point_at(self, one: QPushButton) -> None:
        """As a careful person does, from elsewhere and after a while."""
        self._move(QPoint(1, 60))
        self._settle()
        self.wait(0.6)
        if one.isVisible():
            self._move(self.bench.at(one))
            self._settle()

    def do_whole(self, one: QPushButton) -> None:
        self.point_at(one)
        if not one.isVisible():
            return
        self.press_down()
        if one.objectName() == HOLD:
            self.wait(2.4)
        self._settle()
        self.let_go()

    def _whole_gesture(self) -> None:
        """Complete a gesture properly now and then, which proves that the rest tests something."""
        buttons = [button for button in self.bench.buttons() if button.isEnabled() and button.objectName() in WATCHED]
        if buttons:
            self.do_whole(self.dice.choice(buttons))

    def _hurry(self) -> None:
        """Two steps in a hurry: the second one sooner than half a second after it appeared, or without leaving it."""
        before = {one.objectName() for one in self.bench.buttons()}
        self._whole_gesture()
        self._settle()
        appeared = [one for one in self.bench.buttons() if one.objectName() not in before]
        if not appeared:
            return
        step = self.dice.choice(appeared)
        if self.dice.random() < 0.3:
            step.setFocus()
        self._move(self.bench.at(step))
        self.bench.hand_s += self.dice.choice((0.0, 0.1, 0.25, 0.35, 0.45, 0.49, 0.6))
        self._settle()
        if self.dice.random() < 0.3:
            self._press_key()
            self._settle()
            self._key_up()
        else:
            self.click()

    def _check(self) -> None:
        """Run a whole pre-flight check of a locked module, which leads to the activation if it ends READY."""
        self.bench.bench.module.activate(is_active=False)
        self.bench.window.go_to("preflight")
        self.bench.preflight.show_view("checks")
        enable = self.bench.preflight.enable
        if not enable.isVisible():
            self.wait(CHECK_S)
        self.do_whole(enable)
        self.wait(CHECK_S)

    def _guided_test(self) -> None:
        """Run a guided test up to the activation, which takes a whole gesture, too."""
        module = self.bench.bench.module
        if not self.bench.assembly.ports.current.is_open or not module.is_on or module.is_triggered:
            return
        self.bench.show_guided()
        page = self.bench.guided
        module.activate(is_active=False)
        page.work.choose(GuidedKind.TILT)
        page.work.state_safe(True)
        self.wait(1.0)
        page.work.start()
        self.wait(3.0)

    def press_lock(self) -> None:
        """By its key, which counts whatever is open; it leaves at once."""
        before = self.bench.sent.count(LOCK)
        is_possible = self.is_reachable
        self.observer.lock_pressed()
        self.bench.key(Qt.Key.Key_F12, is_press=True)
        self.bench.key(Qt.Key.Key_F12, is_press=False)
        self.wait(0.1)
        if is_possible and self.bench.sent.count(LOCK) == before:
            self.report.faults.append(f"LOCK did not leave after {', '.join(self.trail)}")

    def _write(self) -> None:
        """Edit some values and write them; risks are accepted, and perhaps something happens at once."""
        if self.dice.random() < 0.7:
            self.put_in_order()
        settings = self.bench.settings
        self.bench.window.go_to("settings")
        values = {command.key: self.dice.choice(choices) for command, choices in VALUES.items()}
        chosen = self.dice.sample(sorted(values), self.dice.randint(1, len(values)))
        settings.work.fill({key: values[key] for key in chosen})
        self.bench.refresh()
        if self.dice.random() < 0.5:
            self._accident()
        if settings.write.isEnabled():
            self.do_whole(settings.write)
            self.bench.refresh()
        anyway = settings.strip.button("write_anyway")
        if anyway is not None and anyway.isVisible():
            self.do_whole(anyway)
        self.wait(self.dice.choice((0.1, 1.0, 8.0)))

    def _act_and_then(self) -> None:
        """Confirm an act on a module in order, and let something follow at once."""
        self.put_in_order()
        self.bench.window.go_to("commands")
        self.bench.refresh()
        confirm = self.dice.choice(list(self.bench.commands.acts.values())).confirm
        if self.dice.random() < 0.5:
            self.disturb({"delay_ms": 220.0})
            self.bench.settings.work.read_all()
        for button in (confirm.ask, confirm.go):
            if button.isVisible() and button.isEnabled():
                self.do_whole(button)
        self.wait(self.dice.choice((0.0, 0.02, 0.1)))
        follows = self.dice.choice((self.press_lock, self._accident, self.slip, self.restart))
        self.trail.append(follows.__name__)
        follows()
        self.wait(3.0)

    # What happens to the module and its line

    @property
    def is_reachable(self) -> bool:
        bench, port = self.bench, self.bench.assembly.ports.current
        return port.is_open and bench.bench.plug_number == bench.line.plug and bench.bench.is_plugged_in

    @property
    def is_in_order(self) -> bool:
        module, port = self.bench.bench.module, self.bench.assembly.ports.current
        return self.is_reachable and module.is_on and not module.is_triggered and port.module.is_read

    def _accident(self) -> None:
        what = self.dice.choice((self._disturb, self._disturb, self.heal, self.restart, self.slip, self._exchange))
        self.trail.append(what.__name__)
        what()

    def _disturb(self) -> None:
        self.heal()
        self.disturb(self.dice.choice(FAULTS))

    def disturb(self, faults: Mapping[str, object]) -> None:
        self.bench.bench.change(**faults)

    def heal(self) -> None:
        end_faults(self.bench.bench)

    def restart(self) -> None:
        self.bench.bench.restart()

    def slip(self) -> None:
        """The plug slips out and in again; the port is opened again."""
        self.bench.bench.unplug()
        self.bench.wait(self.dice.choice((0.02, 0.3)))
        self.bench.bench.plug()
        self.bench.connect()

    def _exchange(self) -> None:
        """Another module hangs at the port."""
        self.bench.disconnect()
        self.bench.exchange({"uptime": 60, "noise": 0, "seed": self.dice.randrange(1000)})
        self.bench.connect()

    def _change_module(self) -> None:
        self.bench.bench.module.activate(is_active=self.dice.random() < 0.6)

    def put_in_order(self) -> None:
        """No fault, connected, switched on, locked and read."""
        bench = self.bench
        self.heal()
        if not bench.bench.module.is_on:
            bench.bench.press_switch()
        bench.bench.module.activate(is_active=False)  # locked once, it is triggered no more
        if not self.is_reachable:
            bench.bench.plug()
            bench.disconnect()
            bench.connect(bench.bench.module.baud_rate)
        ends_at_s = bench.clock() + ONLINE_WITHIN_S
        while bench.clock() < ends_at_s and not bench.assembly.ports.module.is_read:
            self.wait(0.4)


def run(application: QApplication, sequences: int, seed: int) -> Report:
    """Run this many sequences, in one window after the other, or until something is wrong."""
    report, number = Report(), 0
    while report.sequences < sequences and not report.faults:
        dice = random.Random(f"{seed} {number}")
        language, size = LANGUAGES[number % len(LANGUAGES)], SIZES[number // 2 % len(SIZES)]
        number += 1
        with (
            tempfile.TemporaryDirectory() as folder,
            gesture_bench(application, Path(folder), language=language, size=size) as bench,
        ):
            hands = Clumsy(bench, dice, report)
            hands.observer.poll()
            hands.wait(DEAD_S)  # what the window shows has been there for a while
            for _ in range(min(WINDOW_LASTS, sequences - report.sequences)):
                hands.sequence()
                if report.faults:
                    break
    return report
