"""A clumsy person at the real window: pointer and keys at random, on a simulated module that counts what it is told.

Beside it stands a second account of what the hands did (`Observer`): a dangerous frame without a whole gesture of its
own is a fault.

python -m tests.clumsy --sequences 20000 --seed 1
"""

import argparse
import os
import random
import sys
import tempfile
import time
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

from PySide6.QtCore import QEvent, QPoint, QPointF, QRect, Qt
from PySide6.QtGui import QWheelEvent
from PySide6.QtWidgets import QApplication, QPushButton, QWidget

from protocol.catalogue import Request
from protocol.link_states import Presence
from tests.gesture_bench import GestureBench, gesture_bench

DEAD_S: Final = 0.5
HOLD_S: Final = 2.0
SIZES: Final = ((900, 520), (1024, 600), (1180, 720), (1366, 768))
LANGUAGES: Final = ("en", "zh_CN")
KEYS: Final = (Qt.Key.Key_Space, Qt.Key.Key_Return, Qt.Key.Key_Tab, Qt.Key.Key_Backtab, Qt.Key.Key_Escape)
WINDOW_LASTS: Final = 400
"""Sequences; then another window begins, in another language and size."""

# By the name of the button whose press completes the act; what leaves then.
_GO: Final = {
    "act_activate_go": "10 02 01",
    "act_zero_go": "25 01 00",
    "act_shutdown_go": "12 02 01",
    "act_forbid_deploy_go": "11 02 00",
    "baud_go": "24 02",
    "notice_unlock_once": "unlocked write",
}
_DEPLOY: Final = "11 02 01"
_BEFORE: Final = {
    "act_activate_go": "act_activate_ask",
    "act_zero_go": "act_zero_ask",
    "act_shutdown_go": "act_shutdown_ask",
    "act_forbid_deploy_go": "act_forbid_deploy_ask",
    "baud_go": "baud_ask",
    "notice_unlock_once": "",
    "ritual_arm": "ritual_choose",
    "ritual_hold": "ritual_arm",
}
_WATCHED: Final = frozenset(_BEFORE) | frozenset(_BEFORE.values()) - {""}


def kind_of(request: Request, *, is_active: bool) -> str:
    """As the grants are named; empty for what is not dangerous."""
    frame = request.encode().hex(" ")
    for kind in (*_GO.values(), _DEPLOY):
        if frame[6:].startswith(kind):
            return kind
    return "unlocked write" if is_active and frame[6:8] != "10" else ""


@dataclass
class Sight:
    """Since when a button has been as it is, and whether the pointer has moved onto it since."""

    place: QRect
    since_s: float
    is_entered: bool = False
    has_key: bool = False
    """A key was down when it appeared, and has not been released."""


@dataclass
class Observer:
    """Only looks at the window and remembers what the hands did."""

    bench: GestureBench
    grants: Counter[str] = field(default_factory=Counter)
    sights: dict[str, Sight] = field(default_factory=dict)
    chosen: dict[str, float] = field(default_factory=dict)
    """When the press of a button counted last."""
    pressed: str = ""
    pressed_at: float = 0.0
    keys_down: set[Qt.Key] = field(default_factory=set)

    def __post_init__(self) -> None:
        self._buttons: dict[str, QPushButton] = {}

    def look(self) -> None:
        """After every event."""
        window, now = self.bench.window, self.bench.hand_s
        seen: dict[str, Sight] = {}
        for button in self.bench.buttons():
            name = button.objectName()
            if name not in _WATCHED or not button.isEnabled():
                continue
            place = QRect(button.mapTo(window, QPoint(0, 0)), button.size())
            before = self.sights.get(name)
            if before is not None and before.place == place:
                seen[name] = before
            else:
                seen[name] = Sight(place, now, has_key=bool(self.keys_down))
            self._buttons[name] = button
        self.sights = seen
        if self.pressed and self.pressed not in seen:
            self.pressed = ""

    def _under(self) -> str:
        under = self.bench.window.childAt(self.bench.pointer)
        name = under.objectName() if under is not None else ""
        return name if name in self.sights else ""

    def moved(self, old: QPoint) -> None:
        for sight in self.sights.values():
            if sight.place.contains(self.bench.pointer):
                sight.is_entered |= not sight.place.contains(old)
            else:
                sight.is_entered = False
        if self.pressed and not self.keys_down and self._under() != self.pressed:
            self.pressed = ""

    def mouse_down(self, *, is_double: bool) -> None:
        name = self._under()
        sight = self.sights.get(name)
        is_good = sight is not None and sight.is_entered and self._is_old(sight) and not is_double
        self.pressed, self.pressed_at = (name if is_good and not self.pressed else ""), self.bench.hand_s

    def mouse_up(self) -> None:
        if self.pressed and self._under() == self.pressed:
            self._count(self.pressed)
        self.pressed = ""

    def key_down(self, key: Qt.Key) -> None:
        self.keys_down.add(key)
        focused = QApplication.focusWidget()
        name = focused.objectName() if focused is not None else ""
        sight = self.sights.get(name)
        is_good = sight is not None and not sight.has_key and self._is_old(sight) and key in KEYS[:2]
        self.pressed, self.pressed_at = (name if is_good and not self.pressed else ""), self.bench.hand_s

    def key_up(self, key: Qt.Key) -> None:
        if self.pressed:
            self._count(self.pressed)
        self.pressed = ""
        self.keys_down.discard(key)
        if not self.keys_down:
            for sight in self.sights.values():
                sight.has_key = False

    def _is_old(self, sight: Sight) -> bool:
        return self.bench.hand_s - sight.since_s >= DEAD_S - 1e-6

    def passed(self) -> None:
        """Time went on: a hold may be complete."""
        if self.pressed == "ritual_hold" and self.bench.hand_s - self.pressed_at >= HOLD_S - 1e-6:
            if "ritual_arm" in self.chosen:
                self.grants[_DEPLOY] += 1
            self.pressed = ""
            self.chosen.clear()

    def _count(self, name: str) -> None:
        before = _BEFORE.get(name)
        if name in _GO and (not before or before in self.chosen):
            self.grants[_GO[name]] += 1
            self.chosen.clear()
        elif before is None or not before or before in self.chosen:
            self.chosen[name] = self.bench.hand_s


@dataclass
class Report:
    sequences: int = 0
    events: int = 0
    frames: Counter[str] = field(default_factory=Counter)
    faults: list[str] = field(default_factory=list)


class Clumsy:
    """Hands in one window."""

    def __init__(self, bench: GestureBench, dice: random.Random, report: Report) -> None:
        self.bench, self.dice, self.report = bench, dice, report
        self.observer = Observer(bench)
        self.trail: list[str] = []
        self._is_down = False
        self._key: Qt.Key | None = None

    def sequence(self) -> None:
        """Some careless actions, and what must hold after each."""
        self.trail = []
        for _ in range(self.dice.randint(3, 9)):
            self._act()
            self._judge()
        if self._is_down:
            self._up()
        self._key_up()
        self._wait(0.3)
        self._judge()
        self.report.sequences += 1

    def _act(self) -> None:
        actions = (
            (self._go_somewhere, 6), (self._click, 7), (self._double_click, 3), (self._down, 2), (self._up, 2),
            (self._pause, 6), (self._press_key, 4), (self._key_up, 3), (self._repeat_key, 2), (self._scroll, 1),
            (self._resize, 1), (self._turn_page, 1), (self._edit, 1), (self._change_module, 1),
            (self._whole_gesture, 1),
        )  # fmt: skip
        action = self.dice.choices([one for one, _ in actions], [weight for _, weight in actions])[0]
        self.trail.append(action.__name__)
        action()
        self._settle()

    def _settle(self) -> None:
        self.report.events += 1
        self.bench.turn()
        self.observer.look()

    def _go_somewhere(self) -> None:
        window = self.bench.window
        buttons = self.bench.buttons()
        if buttons and self.dice.random() < 0.85:
            one = self.dice.choice(buttons)
            offset = QPoint(self.dice.randrange(one.width()), self.dice.randrange(one.height()))
            self._move(one.mapTo(window, offset))
        elif self.dice.random() < 0.5:
            step = QPoint(self.dice.randint(-3, 3), self.dice.randint(-3, 3))
            self._move(self.bench.pointer + step)
        else:
            self._move(QPoint(self.dice.randrange(window.width()), self.dice.randrange(window.height())))

    def _move(self, to: QPoint) -> None:
        window = self.bench.window
        to = QPoint(min(max(to.x(), 1), window.width() - 2), min(max(to.y(), 60), window.height() - 2))
        old = self.bench.pointer
        self.bench.move(to)
        self.observer.moved(old)

    def _is_safe_place(self) -> bool:
        """Menus would take the mouse away, and the bar above ends the connection: not what this is about."""
        under: QWidget | None = self.bench.window.childAt(self.bench.pointer)
        while under is not None:
            if under.objectName() in ("top_bar", "navigation", "status_line") or under.metaObject().className() in (
                "QComboBox", "QMenuBar", "QToolButton"):  # fmt: skip
                return False
            under = under.parentWidget()
        return True

    def _down(self, *, is_double: bool = False) -> None:
        if self._is_down or not self._is_safe_place():
            return
        self._is_down = True
        self.observer.mouse_down(is_double=is_double)
        (self.bench.double_press if is_double else self.bench.press)()

    def _up(self) -> None:
        if self._is_down:
            self._is_down = False
            self.observer.mouse_up()
            self.bench.release()

    def _click(self) -> None:
        self._down()
        self._settle()
        self._up()

    def _double_click(self) -> None:
        self._click()
        self._settle()
        self.bench.hand_s += self.dice.choice((0.0, 0.06, 0.2, 0.35))
        self._down(is_double=True)
        self._settle()
        self._up()

    def _pause(self) -> None:
        self._wait(self.dice.choice((0.0, 0.05, 0.2, 0.4, 0.5, 0.6, 0.6, 0.9, 2.3)))

    def _wait(self, seconds: float) -> None:
        end_s = self.bench.hand_s + seconds
        while self.bench.hand_s < end_s - 1e-9:
            self.bench.wait(min(0.1, end_s - self.bench.hand_s))
            self.observer.look()
            self.observer.passed()
            self._judge()
        self.bench.refresh()

    def _press_key(self) -> None:
        if self._key is None:
            self._key = self.dice.choice(KEYS)
            self.observer.key_down(self._key)
            self.bench.key(self._key, is_press=True)

    def _repeat_key(self) -> None:
        if self._key is None:
            self._press_key()
        for _ in range(self.dice.randint(1, 20)):
            if self._key is not None:
                self.bench.key(self._key, is_press=False, is_repeat=True)
                self.bench.key(self._key, is_press=True, is_repeat=True)

    def _key_up(self) -> None:
        if self._key is not None:
            key, self._key = self._key, None
            self.observer.key_up(key)
            self.bench.key(key, is_press=False)

    def _scroll(self) -> None:
        place = QPointF(self.bench.pointer)
        event = QWheelEvent(
            place, self.bench.window.mapToGlobal(place), QPoint(), QPoint(0, self.dice.choice((-360, -120, 120, 360))),
            Qt.MouseButton.NoButton, Qt.KeyboardModifier.NoModifier, Qt.ScrollPhase.NoScrollPhase, False,
        )  # fmt: skip
        assert event.type() == QEvent.Type.Wheel
        QApplication.sendEvent(self.bench.handle, event)

    def _resize(self) -> None:
        self.bench.window.resize(*self.dice.choice(SIZES))

    def _turn_page(self) -> None:
        self.bench.window.go_to(self.dice.choice(("commands", "commands", "settings")))

    def _edit(self) -> None:
        settings = self.bench.settings
        form = settings.work.form
        value = self.dice.choice(("30", "58", "62"))
        settings.work.edit(lambda: form.type_text("attitude_threshold_deg", value))
        box = settings.baud.editor.box
        box.setCurrentIndex(self.dice.randrange(box.count()))

    def _change_module(self) -> None:
        self.bench.bench.module.activate(is_active=self.dice.random() < 0.6)

    def _whole_gesture(self) -> None:
        """Now and then somebody does it right: what leaves then shows that the rest is about something."""
        buttons = [one for one in self.bench.buttons() if one.isEnabled() and one.objectName() in _WATCHED]
        if not buttons or self._is_down or self._key is not None:
            return
        one = self.dice.choice(buttons)
        self._move(QPoint(1, 60))
        self._settle()
        self._wait(0.6)
        if not one.isVisible():
            return
        self._move(self.bench.at(one))
        self._settle()
        self._down()
        if one.objectName() == "ritual_hold":
            self._wait(2.4)
        self._settle()
        self._up()

    def _judge(self) -> None:
        sent, self.bench.sent = list(self.bench.sent), []
        for request in sent:
            kind = kind_of(request, is_active=self._was_active)
            if not kind:
                continue
            self.report.frames[kind] += 1
            if self.observer.grants[kind] <= 0:
                self.report.faults.append(f"{request.encode().hex(' ')} after {', '.join(self.trail)}")
            else:
                self.observer.grants[kind] -= 1
        self._was_active = self.bench.bench.module.state.is_active

    _was_active = False

    def recover(self) -> bool:
        """The module as it was, where that is possible without another window."""
        device = self.bench.device
        is_there = device.presence is Presence.ONLINE and self.bench.bench.module.is_on
        if is_there and self.bench.bench.module.is_triggered:
            return False
        return is_there and self.bench.assembly.connector.is_open


def run(application: QApplication, sequences: int, seed: int, *, is_told: bool = False) -> Report:
    """So many sequences, in one window after the other."""
    report, number = Report(), 0
    while report.sequences < sequences:
        dice = random.Random(f"{seed} {number}")
        language, size = LANGUAGES[number % len(LANGUAGES)], SIZES[number // 2 % len(SIZES)]
        number += 1
        with (
            tempfile.TemporaryDirectory() as folder,
            gesture_bench(application, Path(folder), language=language, size=size) as bench,
        ):
            bench.sent.clear()
            hands = Clumsy(bench, dice, report)
            hands.observer.look()
            for _ in range(min(WINDOW_LASTS, sequences - report.sequences)):
                hands.sequence()
                if not hands.recover():
                    break
        if is_told:
            frames = ", ".join(f"{count} x {kind}" for kind, count in sorted(report.frames.items()))
            print(f"{report.sequences:,} sequences, {report.events:,} events; left: {frames}", flush=True)
    return report


def main() -> int:
    """Run from the command line."""
    parser = argparse.ArgumentParser(prog="python -m tests.clumsy")
    parser.add_argument("--sequences", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=1)
    args = parser.parse_args()
    if not os.environ.keys() & {"DISPLAY", "WAYLAND_DISPLAY"}:
        os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
    application = QApplication.instance() or QApplication(sys.argv[:1])
    assert isinstance(application, QApplication)
    began = time.monotonic()
    report = run(application, args.sequences, args.seed, is_told=True)
    print("\n".join(report.faults[:10]))
    print(f"{len(report.faults)} without a whole gesture ({time.monotonic() - began:.0f} s)")
    return 1 if report.faults else 0


if __name__ == "__main__":
    sys.exit(main())
