"""A second account of what the hands at a window did: it grants a dangerous frame only for a whole gesture of its own.

It sees the buttons on the screen and the events that the hands make, and asks the code that it judges nothing but
whether the release of a key has reached the button, and whether a check runs.
"""

from collections import defaultdict
from dataclasses import dataclass, field
from typing import Final

from PySide6.QtCore import QPoint, QRect, Qt
from PySide6.QtWidgets import QApplication

from protocol.catalogue import STATUS, Request
from tests.gestures.gesture_bench import GestureBench
from ui.pages.preflight.controller import Standing
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
    "tests_activate_go": "10 02 01",
    "act_zero_go": "25 01 00",
    "tests_zero_go": "25 01 00",
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
HOLD: Final = "ritual_hold"
_BEFORE: Final = {
    "act_activate_go": "act_activate_ask",
    "preflight_activate_go": "preflight_activate_ask",
    "tests_activate_go": "tests_activate_ask",
    "tests_zero_go": "tests_zero_ask",
    "act_zero_go": "act_zero_ask",
    "act_shutdown_go": "act_shutdown_ask",
    "act_forbid_deploy_go": "act_forbid_deploy_ask",
    "baud_go": "baud_ask",
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
        self._grants: defaultdict[str, list[float]] = defaultdict(list)
        """By frame: the times until which it is granted."""
        self._told_at, self._told_active = self.bench.clock(), True

    # What is on the screen

    def poll(self) -> None:
        """Update the state; called after every event."""
        window, now = self.bench.window, self.bench.hand_s
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
        focused = QApplication.focusWidget()
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
            focused = QApplication.focusWidget()
            if focused is not None and focused.objectName() == press.name:
                self._count(press.name)
        self.keys_down.discard(key)
        if not self.keys_down:
            for sight in self.sights.values():
                sight.has_key = False

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
            for change in self.bench.settings.work.form.changes(self.bench.device, self.bench.clock()):
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
        self._grants[kind].append(self.bench.clock() + for_s)

    def _kind(self, request: Request) -> str:
        """Return the key of a frame in the grants; empty if it is not dangerous."""
        frame = request.encode().hex(" ")
        for kind in (*GO.values(), DEPLOY):
            if frame[6:].startswith(kind):
                return kind
        # A module that turns ACTIVE after it was asked cannot be known to be: the answer is on its way.
        could_know = self._told_active or self.bench.clock() - self._told_at > TOLD_S
        is_write = self.bench.bench.module.state.is_active and could_know and frame[6:8] != "10"
        if is_write:
            return f"{UNLOCKED} {frame[6:8]}"
        # Settings writes the triggers of a locked module, too, as any other setting.
        is_checking = self.bench.preflight.work.standing is Standing.CHECKING
        return frame[6:11] if frame[6:11] in ENABLED and is_checking else ""

    def asked(self, request: Request) -> None:
        """Note the state of the module when its status is queried."""
        if request.encode() == STATUS.query().encode():
            self._told_at, self._told_active = self.bench.clock(), self.bench.bench.module.state.is_active

    def feed(self, request: Request) -> tuple[str, bool]:
        """Return the kind of a frame as it is sent, and whether a gesture granted it."""
        kind = self._kind(request)
        if not kind:
            return "", True
        left = [until for until in self._grants[kind] if until >= self.bench.clock()]
        self._grants[kind] = left[1:]
        return kind.removesuffix(kind[-3:]) if kind.startswith(UNLOCKED) else kind, bool(left)
