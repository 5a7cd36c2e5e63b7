"""The ledger: what the hands at a window did, and what left for it.

A dangerous frame is granted only by a whole gesture of its own on the same connection, which LOCK revokes, and its
intent is in the log first; each setting leaves once for a press on Write; LOCK leaves at most fifty times within ten
seconds of a press.

It sees the buttons on the screen and the events that the hands make, and asks the code that it judges nothing but
whether the release of a key has reached the button, whether a check runs, and whether a guided test locks.
"""

import math
from collections import Counter, defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final

from PySide6.QtCore import QPoint, QRect, Qt
from PySide6.QtWidgets import QWidget

from app.procedures.write import SettingChange
from protocol.catalogue import LOCK, Request
from tests.campaigns.gestures.gesture_bench import GestureBench
from ui.session.check import Standing
from ui.widgets.gestures import gestures

DEAD_S: Final = 0.5
HOLD_S: Final = 2.0
ASKED_S: Final = 10.0
"""Time after which an unanswered question is cancelled."""
COUNTS_FOR_S: Final = 5.0
"""Time within which a granted frame must be sent."""
DEPLOYS_WITHIN_S: Final = 1.0
TOLD_S: Final = 1.1
"""A module that was locked when it was queried within this time may have become ACTIVE since."""

# By the name of the button whose press completes the act; what leaves then.
GO: Final = {
    "act_activate_go": "10 02 01",
    "preflight_activate_go": "10 02 01",
    "guided_activate_go": "10 02 01",
    "act_zero_go": "25 01 00",
    "act_shutdown_go": "12 02 01",
    "act_forbid_deploy_go": "11 02 00",
    "baud_go": "24 02",
}
DEPLOY: Final = "11 02 01"
ENABLE: Final = frozenset({"preflight_enable", "check_attitude_trigger_act", "check_freefall_trigger_act"})
ENABLED: Final = ("16 02", "17 02")
"""Each of these buttons starts a check that enables both triggers, once."""
CHECK_LASTS_S: Final = 60.0
"""The longest time until a check enables the triggers."""
UNLOCK: Final = "notice_unlock_once"
UNLOCKED: Final = "unlocked write"
WRITES: Final = frozenset({"settings_write", "notice_write_anyway", UNLOCK})
"""A press on one of these writes what stands there as changed, each once."""
MAX_LOCKS: Final = 50
LOCKS_FOR_S: Final = 10.0
SLACK_S: Final = 0.05
OWED_FOR_S: Final = 70.0
"""Time for which LOCK may follow an activation whose conversation ended."""
HOLD: Final = "ritual_hold"
_BEFORE: Final = {
    **{go: f"{go.removesuffix('_go')}_ask" for go in GO},
    "ritual_arm": "ritual_choose",
    HOLD: "ritual_arm",
}
WATCHED: Final = frozenset({*_BEFORE, *_BEFORE.values(), *ENABLE, UNLOCK, "ritual_rehearse"})


@dataclass
class Sight:
    """State of a button since it appeared or moved, and whether the pointer has entered it since."""

    place: QRect
    since_s: float
    is_entered: bool = False
    has_key: bool = False
    """A key was down when it appeared, and has not been released."""


@dataclass
class Press:
    """A press of a button that counts so far."""

    name: str
    at_s: float
    key: Qt.Key | None = None


@dataclass
class Observer:
    """Observes the window, and records the gestures."""

    bench: GestureBench
    sights: dict[str, Sight] = field(default_factory=dict)
    chosen: dict[str, float] = field(default_factory=dict)
    """When the last counted press of a button was; dropped when the next step disappears."""
    press: Press | None = None
    keys_down: set[Qt.Key] = field(default_factory=set)

    def __post_init__(self) -> None:
        self._grants: defaultdict[str, list[tuple[float, float]]] = defaultdict(list)
        """By frame: from when and until when it is granted."""
        self._writes = Counter[bytes]()
        self._locks, self._locked_at, self._owes_lock = 0, -math.inf, False
        self._gone = Counter[bytes]()
        self._owed_until = -math.inf

    # What is on the screen

    def poll(self) -> None:
        """Update the state; called after every event."""
        window, now = self.bench.window, self.bench.hand_s
        self._owes_lock |= self.bench.guided.work.owes_lock
        seen: dict[str, Sight] = {}
        visible = {one.objectName(): one for one in self.bench.buttons() if one.objectName() in WATCHED}
        for name, button in visible.items():
            if button.isEnabled():
                place = QRect(button.mapTo(window, QPoint(0, 0)), button.size())
                before = self.sights.get(name)
                is_same = before is not None and before.place == place
                seen[name] = before if before and is_same else Sight(place, now, has_key=bool(self.keys_down))
        if self.press and seen.get(self.press.name) is not self.sights.get(self.press.name):
            self.press = None
        self.sights = seen
        for name, first in _BEFORE.items():
            # On X11 the release of a key reaches the button a moment later.
            if name not in visible and not gestures().is_release_uncertain:
                self.chosen.pop(first, None)

    def _under(self) -> str:
        under = self.bench.window.childAt(self.bench.pointer)
        name = under.objectName() if under is not None else ""
        return name if name in self.sights else ""

    def _now(self, name: str) -> float:
        """Return the time: the deployment panel uses the clock of the line, questions that of the gestures."""
        return self.bench.clock() if name.startswith("ritual_") else self.bench.hand_s

    # What the hands do

    def moved(self, old: QPoint) -> None:
        for sight in self.sights.values():
            if sight.place.contains(self.bench.pointer):
                sight.is_entered |= not sight.place.contains(old)
            else:
                sight.is_entered = False
        if self.press and self.press.key is None and self._under() != self.press.name:
            self.press = None

    def mouse_down(self, *, is_double: bool) -> None:
        self._note_write(self.bench.window.childAt(self.bench.pointer))
        name = self._under()
        sight = self.sights.get(name)
        is_good = sight is not None and sight.is_entered and self._is_old(sight) and not is_double
        self._begin(name, is_good=is_good, key=None)

    def mouse_up(self) -> None:
        press = self.press
        if press and press.key is None:
            self.press = None
            if self._under() == press.name:
                self._count(press.name)

    def key_down(self, key: Qt.Key) -> None:
        self.keys_down.add(key)
        focused: QWidget | None = self.bench.window.focusWidget()
        self._note_write(focused)
        name = focused.objectName() if focused is not None else ""
        sight = self.sights.get(name)
        # Return presses only what is held; elsewhere it belongs to dialogs.
        presses = key == Qt.Key.Key_Space or (key == Qt.Key.Key_Return and name == HOLD)
        is_good = presses and sight is not None and not sight.has_key and self._is_old(sight)
        self._begin(name, is_good=is_good, key=key)

    def key_up(self, key: Qt.Key) -> None:
        press = self.press
        if press and press.key == key:
            self.press = None
            focused: QWidget | None = self.bench.window.focusWidget()
            if focused is not None and focused.objectName() == press.name:
                self._count(press.name)
        self.keys_down.discard(key)
        if not self.keys_down:
            for sight in self.sights.values():
                sight.has_key = False

    def _note_write(self, pressed: QWidget | None) -> None:
        """A plain button counts however it is pressed."""
        name = pressed.objectName() if pressed is not None and pressed.isEnabled() else ""
        self._owes_lock |= name in ENABLE  # it locks an active module first
        if name in WRITES:
            self._writes = Counter(change.command.set(change.value).encode() for change in self._changes())

    def _changes(self) -> Sequence[SettingChange]:
        return self.bench.settings.work.form.changes(self.bench.device, self.bench.clock())

    def lock_pressed(self) -> None:
        """LOCK may leave, and nothing dangerous that was decided before."""
        self._locks, self._locked_at = MAX_LOCKS, self.bench.clock()
        for kind in (*GO.values(), DEPLOY):
            self._grants[kind].clear()

    def _begin(self, name: str, *, is_good: bool, key: Qt.Key | None) -> None:
        """Begin a press; a second one of the same button ends the first and does not count."""
        if self.press is not None and self.press.name == name:
            self.press = None
        elif is_good:
            self.press = Press(name, self._now(name), key)

    def _is_old(self, sight: Sight) -> bool:
        return self.bench.hand_s - sight.since_s >= DEAD_S - 1e-6

    def passed(self) -> None:
        """Complete a hold if it has lasted long enough."""
        press = self.press
        if press and press.name == HOLD and self.bench.clock() - press.at_s >= HOLD_S - 1e-6:
            if "ritual_arm" in self.chosen:
                self._grant(DEPLOY, DEPLOYS_WITHIN_S)
            self.press = None
            self.chosen.pop("ritual_arm", None)

    def _count(self, name: str) -> None:
        first = _BEFORE.get(name)
        if first and first not in self.chosen:
            return
        if name == "ritual_rehearse":
            self.chosen.pop("ritual_choose", None)
        elif name == UNLOCK:
            # One press allows one write, which is of every setting that stands there as changed; each once.
            for change in self._changes():
                self._grant(f"{UNLOCKED} {change.command.code:02x}", COUNTS_FOR_S)
        elif name in ENABLE:
            for kind in ENABLED:
                self._grants[kind].clear()
                self._grant(kind, CHECK_LASTS_S)
        elif name not in GO:
            self.chosen[name] = self._now(name)
        elif first and self._now(name) - self.chosen.pop(first) < ASKED_S:
            self._grant(GO[name], COUNTS_FOR_S)

    # What leaves

    def _grant(self, kind: str, for_s: float) -> None:
        now = self.bench.clock()
        self._grants[kind].append((now, now + for_s))

    def _take(self, kind: str) -> bool:
        """Use a grant up; one that was given before the port was opened is none."""
        now, opened_at = self.bench.clock(), self.bench.line.opened_at
        left = [grant for grant in self._grants[kind] if opened_at <= grant[0] and now <= grant[1]]
        self._grants[kind] = left[1:]
        return bool(left)

    def feed(self, request: Request) -> tuple[str, str]:
        """Return the kind of a frame as it is sent, and what is wrong with it, else nothing."""
        frame = request.encode()
        text = frame[2:].hex(" ")
        if request == LOCK:
            return "LOCK", self._feed_lock()
        for kind in (*GO.values(), DEPLOY):
            if text.startswith(kind):
                self._gone[frame] += 1
                if kind == GO["act_activate_go"]:
                    self._owed_until = self.bench.clock() + OWED_FOR_S
                intended = sum(intent[1] == frame for intent in self.bench.journal.intents)
                is_intended = self._gone[frame] <= intended
                return kind, "" if self._take(kind) and is_intended else "without a whole gesture, or not in the log"
        is_checking = self.bench.preflight.work.standing is Standing.CHECKING
        if text[:5] in ENABLED and is_checking and not self._writes[frame]:
            return text[:5], "" if self._take(text[:5]) else "without a whole gesture"
        self._writes[frame] -= 1
        wrong = "" if self._writes[frame] >= 0 else "written by nobody, or twice"
        if self.bench.bench.module.state.is_active and self._could_know():
            return UNLOCKED, wrong or ("" if self._take(f"{UNLOCKED} {text[:2]}") else "to an active module")
        return "write", wrong

    def _could_know(self) -> bool:
        """A module that turns ACTIVE after it was asked cannot be known to be: the answer is on its way."""
        told = self.bench.line.told_active
        return told is not None and (told[1] or self.bench.clock() - told[0] > TOLD_S)

    def _feed_lock(self) -> str:
        if self.bench.clock() < self._owed_until:
            return ""
        if self._owes_lock and self.bench.clock() > self._locked_at + LOCKS_FOR_S:
            self._owes_lock = False
            self.lock_pressed()  # the test does it itself, also once a lost port is back
        self._locks -= 1
        is_late = self.bench.clock() > self._locked_at + LOCKS_FOR_S + SLACK_S
        return "LOCK that nobody pressed, too often or too late" if self._locks < 0 or is_late else ""
