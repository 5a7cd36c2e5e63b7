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
from dataclasses import dataclass
from typing import Final

from PySide6.QtCore import QPoint, QRect, Qt
from PySide6.QtWidgets import QPushButton, QWidget

from app.procedures.write import SettingChange
from protocol.catalogue import LOCK, Request
from tests.support.line.sim_line import SimulatedLine
from tests.support.window.hand import Hand
from ui.widgets.step_button import gestures

# What the program promises, in seconds: a step is dead after it appeared, is held, and a question waits for so long.
DEAD_S: Final = 0.5
HOLD_S: Final = 2.0
ASKED_S: Final = 10.0
# Within so long what was granted has to leave; a check takes longer until it enables the triggers, 80 s on a slow line.
COUNTS_FOR_S: Final = 5.0
DEPLOYS_WITHIN_S: Final = 1.0
CHECK_LASTS_S: Final = 120.0
# A module that was LOCKED when it was asked so long ago may have become ACTIVE since.
TOLD_S: Final = 1.1
MAX_LOCKS: Final = 50
LOCKS_FOR_S: Final = 10.0
SLACK_S: Final = 0.05
# For so long LOCK may follow an activation whose conversation ended.
OWED_FOR_S: Final = 70.0

# By the name of the button whose press completes the act: what leaves then.
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
# Each of these starts a check that enables both triggers, once.
ENABLE: Final = frozenset({"preflight_enable", "check_attitude_trigger_act", "check_freefall_trigger_act"})
ENABLED: Final = ("16 02", "17 02")
UNLOCK: Final = "notice_unlock_once"
UNLOCKED: Final = "unlocked write"
# A press on one of these writes what stands there as changed, each once.
WRITES: Final = frozenset({"settings_write", "notice_write_anyway", UNLOCK})
HOLD: Final = "ritual_hold"
BEFORE: Final = {
    **{go: f"{go.removesuffix('_go')}_ask" for go in GO},
    "ritual_arm": "ritual_choose",
    HOLD: "ritual_arm",
}
WATCHED: Final = frozenset({*BEFORE, *BEFORE.values(), *ENABLE, UNLOCK})


@dataclass
class Sight:
    """A button since it appeared or moved."""

    place: QRect
    since_s: float
    is_entered: bool = False  # by the pointer, since
    has_key: bool = False  # a key was down when it appeared, and has not been released


@dataclass
class Press:
    """A press of a button that counts so far."""

    name: str
    at_s: float
    key: Qt.Key | None = None


class Ledger:
    """`is_checking`, `owes_lock`: a check runs, and a guided test locks."""

    def __init__(self, hand: Hand) -> None:
        self.hand, self.clock = hand, hand.clock
        self.is_checking = self.owes_lock = False
        self.press: Press | None = None
        self._sights: dict[str, Sight] = {}
        # When the last press of a button that counted was; dropped when the next step disappears.
        self._chosen: dict[str, float] = {}
        self._keys_down: set[Qt.Key] = set()
        # By frame: from when and until when it is granted.
        self._grants: defaultdict[str, list[tuple[float, float]]] = defaultdict(list)
        self._writes, self._gone = Counter[bytes](), Counter[bytes]()
        self._locks, self._locked_at, self._owed_until = 0, -math.inf, -math.inf

    def look(self) -> None:
        """What is on the screen; called after every event."""
        if self.press and self.press.name == HOLD and self.clock() - self.press.at_s >= HOLD_S - 1e-6:
            if "ritual_arm" in self._chosen:
                self._grant(DEPLOY, DEPLOYS_WITHIN_S)
            self.press = None
            self._chosen.pop("ritual_arm", None)
        visible = {name: one for one in self.hand.window.findChildren(QPushButton)
                   if (name := one.objectName()) in WATCHED and one.isVisible()}  # fmt: skip
        seen: dict[str, Sight] = {}
        for name, button in visible.items():
            if button.isEnabled():
                place = QRect(button.mapTo(self.hand.window, QPoint(0, 0)), button.size())
                before = self._sights.get(name)
                is_same = before is not None and before.place == place
                seen[name] = before if before and is_same else Sight(place, self.clock(), has_key=bool(self._keys_down))
        if self.press and seen.get(self.press.name) is not self._sights.get(self.press.name):
            self.press = None
        self._sights = seen
        for name, first in BEFORE.items():
            # On X11 the release of a key reaches the button a moment later.
            if name not in visible and not gestures().is_release_uncertain:
                self._chosen.pop(first, None)

    # What the hands do

    def _under(self, place: QPoint | None = None) -> str:
        under = self.hand.window.childAt(place or self.hand.pointer)
        name = under.objectName() if under is not None else ""
        return name if name in self._sights else ""

    def moved(self, to: QPoint) -> None:
        old = self.hand.pointer
        for sight in self._sights.values():
            sight.is_entered = sight.place.contains(to) and (sight.is_entered or not sight.place.contains(old))
        if self.press and self.press.key is None and self._under(to) != self.press.name:
            self.press = None

    def mouse_down(self, *, is_double: bool) -> None:
        self._note_write(self.hand.window.childAt(self.hand.pointer))
        name = self._under()
        sight = self._sights.get(name)
        is_good = sight is not None and sight.is_entered and self._is_old(sight) and not is_double
        self._begin(name, is_good=is_good, key=None)

    def mouse_up(self) -> None:
        if self.press and self.press.key is None:
            self._end_press(self._under())

    def key_down(self, key: Qt.Key) -> None:
        self._keys_down.add(key)
        focused: QWidget | None = self.hand.window.focusWidget()
        self._note_write(focused)
        name = focused.objectName() if focused is not None else ""
        sight = self._sights.get(name)
        # Return presses only what is held; elsewhere it belongs to dialogs.
        presses = key == Qt.Key.Key_Space or (key == Qt.Key.Key_Return and name == HOLD)
        is_good = presses and sight is not None and not sight.has_key and self._is_old(sight)
        self._begin(name, is_good=is_good, key=key)

    def key_up(self, key: Qt.Key) -> None:
        if self.press and self.press.key == key:
            focused: QWidget | None = self.hand.window.focusWidget()
            self._end_press(focused.objectName() if focused is not None else "")
        self._keys_down.discard(key)
        if not self._keys_down:
            for sight in self._sights.values():
                sight.has_key = False

    def lock_pressed(self) -> None:
        """LOCK may leave, and nothing dangerous that was decided before."""
        self._locks, self._locked_at = MAX_LOCKS, self.clock()
        for kind in (*GO.values(), DEPLOY):
            self._grants[kind].clear()

    def _changes(self) -> Sequence[SettingChange]:
        return self.hand.settings.work.changes

    def _is_old(self, sight: Sight) -> bool:
        return self.clock() - sight.since_s >= DEAD_S - 1e-6

    def _note_write(self, pressed: QWidget | None) -> None:
        """A plain button counts however it is pressed."""
        name = pressed.objectName() if pressed is not None and pressed.isEnabled() else ""
        self.owes_lock |= name in ENABLE  # it locks an active module first
        if name in WRITES:
            self._writes = Counter(change.command.set(change.value).encode() for change in self._changes())

    def _begin(self, name: str, *, is_good: bool, key: Qt.Key | None) -> None:
        """Begin a press; a second one of the same button ends the first and does not count."""
        if self.press is not None and self.press.name == name:
            self.press = None
        elif is_good:
            self.press = Press(name, self.clock(), key)

    def _end_press(self, where: str) -> None:
        """The press counts if it ends where it began, and what comes before it was chosen."""
        press, self.press = self.press, None
        name = press.name if press is not None and press.name == where else ""
        first = BEFORE.get(name)
        if not name or (first and first not in self._chosen):
            return
        if name == UNLOCK:
            # One press allows one write, which is of every setting that stands there as changed; each once.
            for change in self._changes():
                self._grant(f"{UNLOCKED} {change.command.code:02x}", COUNTS_FOR_S)
        elif name in ENABLE:
            for kind in ENABLED:
                self._grants[kind].clear()
                self._grant(kind, CHECK_LASTS_S)
        elif name not in GO:
            self._chosen[name] = self.clock()
        elif first and self.clock() - self._chosen.pop(first) < ASKED_S:
            self._grant(GO[name], COUNTS_FOR_S)

    def _grant(self, kind: str, for_s: float) -> None:
        self._grants[kind].append((self.clock(), self.clock() + for_s))

    def _take(self, kind: str) -> bool:
        """Use a grant up; one that was given before the port was opened is none."""
        now = self.clock()
        opened_at = self.hand.lines[-1].opened_at
        left = [grant for grant in self._grants[kind] if opened_at <= grant[0] and now <= grant[1]]
        self._grants[kind] = left[1:]
        return bool(left)

    # What leaves

    def feed(self, request: Request, *, is_active: bool) -> tuple[str, str]:
        """Return the kind of a frame as it is sent, and what is wrong with it, else nothing. `is_active`: the module
        is."""
        frame = request.encode()
        text = frame[2:].hex(" ")
        if request == LOCK:
            return "LOCK", self._feed_lock()
        for kind in (*GO.values(), DEPLOY):
            if text.startswith(kind):
                self._gone[frame] += 1
                if kind == GO["act_activate_go"]:
                    self._owed_until = self.clock() + OWED_FOR_S
                intended = sum(intent[1] == frame for intent in self.hand.journal.intents)
                is_right = self._take(kind) and self._gone[frame] <= intended
                return kind, "" if is_right else "without a whole gesture, or not in the log"
        if text[:5] in ENABLED and self.is_checking and not self._writes[frame]:
            return text[:5], "" if self._take(text[:5]) else "without a whole gesture"
        self._writes[frame] -= 1
        wrong = "" if self._writes[frame] >= 0 else "written by nobody, or twice"
        # A module that turns ACTIVE after it was asked cannot be known to be: the answer is on its way.
        line = self.hand.lines[-1]
        told = line.told_active if isinstance(line, SimulatedLine) else None
        could_know = told is not None and (told[1] or self.clock() - told[0] > TOLD_S)
        if is_active and could_know:
            return UNLOCKED, wrong or ("" if self._take(f"{UNLOCKED} {text[:2]}") else "to an active module")
        return "write", wrong

    def _feed_lock(self) -> str:
        now = self.clock()
        if now < self._owed_until:
            return ""
        if self.owes_lock and now > self._locked_at + LOCKS_FOR_S:
            self.owes_lock = False
            self.lock_pressed()  # the test does it itself, also once a lost port is back
        self._locks -= 1
        is_late = now > self._locked_at + LOCKS_FOR_S + SLACK_S
        return "LOCK that nobody pressed, too often or too late" if self._locks < 0 or is_late else ""
