"""Deploy ritual as a state machine on a clock: choose, arm, hold for two seconds.

    IDLE --choose--> CHOSEN --arm--> ARMED --press--> HOLDING --2 s--> FIRED
                                                   anything else, letting go too: back to IDLE

Rules that it lives by:

- The whole of it, holding included, fits into the ten seconds after arming; then it is disarmed.
- Its button lets no auto-repeat and no second press of a double click through (`ui.widgets.step_button`). A second
  press while one is held (mouse and key together) ends it, as letting go does.
- Only `tick` completes the hold, and only where ticks came all along, at most `MAX_GAP_S` apart: a window that hung
  for a moment cannot know that the button was still held, so it disarms.
- One run through gives one `Permit`. To fire again is to choose again.
"""

import logging
from enum import Enum, auto
from math import inf

from app.safety.journal import Act
from app.safety.permit import Origin, Permit

_log = logging.getLogger(__name__)

ARMED_FOR_S = 10.0
HOLD_S = 2.0
MAX_GAP_S = 0.25


class Stage(Enum):
    IDLE = auto()
    CHOSEN = auto()  # the act and its conditions are shown; the default button is Cancel
    ARMED = auto()
    HOLDING = auto()
    FIRED = auto()  # the permit was given; until FINISHED or the next CHOOSE


class Input(Enum):
    CHOOSE = auto()
    ARM = auto()
    PRESS = auto()
    RELEASE = auto()
    FINISHED = auto()  # the outcome has been shown
    # By the clock
    HELD = auto()  # held for two seconds
    HOLD_BROKEN = auto()  # it is uncertain whether it was held all the time
    RAN_OUT = auto()  # ten seconds have passed since arming
    # What disarms
    CANCEL = auto()
    FOCUS_LOST = auto()
    WINDOW_LEFT = auto()
    INTERRUPTED = auto()  # the conversation with the module ended
    OUT_OF_SIGHT = auto()  # the armed controls are not entirely visible
    CONDITION_OPENED = auto()  # a condition that held when it was armed no longer holds
    FAILED = auto()  # an exception anywhere in the window


DISARMING = (
    Input.CANCEL,
    Input.FOCUS_LOST,
    Input.WINDOW_LEFT,
    Input.INTERRUPTED,
    Input.OUT_OF_SIGHT,
    Input.CONDITION_OPENED,
    Input.FAILED,
)

# An input without an entry changes nothing.
TRANSITIONS: dict[tuple[Stage, Input], Stage] = {
    (Stage.IDLE, Input.CHOOSE): Stage.CHOSEN,
    (Stage.CHOSEN, Input.ARM): Stage.ARMED,
    (Stage.ARMED, Input.PRESS): Stage.HOLDING,
    (Stage.HOLDING, Input.RELEASE): Stage.IDLE,
    (Stage.HOLDING, Input.PRESS): Stage.IDLE,
    (Stage.HOLDING, Input.HOLD_BROKEN): Stage.IDLE,
    (Stage.HOLDING, Input.HELD): Stage.FIRED,
    (Stage.ARMED, Input.RAN_OUT): Stage.IDLE,
    (Stage.HOLDING, Input.RAN_OUT): Stage.IDLE,
    (Stage.FIRED, Input.FINISHED): Stage.IDLE,
    (Stage.FIRED, Input.CHOOSE): Stage.CHOSEN,
    # Before arming, an open condition only disables the button.
    **{
        (stage, why): Stage.IDLE
        for stage in (Stage.CHOSEN, Stage.ARMED, Stage.HOLDING)
        for why in DISARMING
        if (stage, why) != (Stage.CHOSEN, Input.CONDITION_OPENED)
    },
}


class Ritual:
    """See the module's docstring. Belongs to one thread; times are monotonic seconds of the session's clock."""

    def __init__(self) -> None:
        self.stage = Stage.IDLE
        # The input that led back to IDLE last, for the notice in the window.
        self.ended_by: Input | None = None
        # The number of the conversation in which it was chosen, as the permit will be void in any other.
        self._conversation = 0
        self._armed_at = self._pressed_at = self._ticked_at = -inf

    @property
    def is_armed(self) -> bool:
        return self.stage in (Stage.ARMED, Stage.HOLDING)

    def armed_left_s(self, now: float) -> float:
        return max(0.0, self._armed_at + ARMED_FOR_S - now) if self.is_armed else 0.0

    def held_s(self, now: float) -> float:
        """Seconds that it has been held, 0 … 2."""
        return min(HOLD_S, max(0.0, now - self._pressed_at)) if self.stage is Stage.HOLDING else 0.0

    def choose(self, conversation: int) -> None:
        """`conversation`: the number of the one that goes on."""
        if (self.stage, Input.CHOOSE) in TRANSITIONS:
            self._conversation = conversation
            self._apply(Input.CHOOSE)

    def arm(self, now: float) -> None:
        if self.stage is Stage.CHOSEN:
            self._armed_at = self._ticked_at = now
        self._apply(Input.ARM)

    def press(self, now: float) -> None:
        if self.stage is Stage.ARMED:
            self._pressed_at = self._ticked_at = now
        self._apply(Input.PRESS)

    def release(self) -> None:
        self._apply(Input.RELEASE)

    def disarm(self, why: Input) -> None:
        """Disarm for one of `DISARMING`, or `FINISHED`. Raises ValueError for anything else."""
        if why not in DISARMING and why is not Input.FINISHED:
            raise ValueError(f"{why.name} does not disarm")
        self._apply(why)

    def tick(self, now: float) -> Permit | None:
        """Look at the time; to be called at least ten times a second. Returns the permit, once, when the hold is
        complete."""
        gap_s, self._ticked_at = now - self._ticked_at, now
        # Also where the clock went back.
        if not 0.0 <= now - self._armed_at < ARMED_FOR_S:
            self._apply(Input.RAN_OUT)
        if self.stage is not Stage.HOLDING:
            return None
        if not 0.0 <= gap_s <= MAX_GAP_S:
            self._apply(Input.HOLD_BROKEN)
        elif now - self._pressed_at >= HOLD_S:
            self._apply(Input.HELD)
            return Permit(Act.DEPLOY, Origin.RITUAL, now, self._conversation)
        return None

    def _apply(self, what: Input) -> None:
        after = TRANSITIONS.get((self.stage, what), self.stage)
        if after is self.stage:
            return
        _log.debug("%s: %s -> %s", what.name, self.stage.name, after.name)
        if after is Stage.IDLE:
            self.ended_by = what
        self.stage = after
