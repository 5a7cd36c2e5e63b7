"""The link as a person sees it: its state with the next action, and the statistics of one connection."""

import time
from collections import deque
from enum import Enum
from typing import Final, NamedTuple

from app.diagnosis.causes import NextStep, PortEvidence, explain
from app.diagnosis.silence import Silence
from app.engine.conversation import ConversationView, reason_message
from app.engine.procedure import SHARED, TOO_SLOW
from app.engine.reconnect import Absence
from app.engine.target import is_shared
from app.engine.transport import PortErrorKind
from app.engine.worker import Batch, Connection, PortState
from app.safety.last_known import keep_away
from app.text.i18n import tr
from app.text.messages import capitalised, duration
from protocol.events import Answered, Counters, EndReason


class Phase(Enum):
    """How far the link is."""

    CLOSED = "closed"
    OPENING = "opening"
    FINDING = "finding"  # trying baud rates
    ASKING = "asking"  # open, with no answer yet
    SILENT = "silent"  # open, and no module has ever answered
    ONLINE = "online"
    LATE = "late"  # answers arrive so late that they may be out of date
    OFFLINE = "offline"  # it answered before and no longer does
    LOST = "lost"  # the port; it is reopened when the same adapter returns
    FAILED = "failed"  # the port could not be opened
    SWITCHED_OFF = "switched_off"  # by command, which is not a fault


_FINE: Final = (Phase.OPENING, Phase.FINDING, Phase.ASKING, Phase.ONLINE)
# The next step needs nothing done at the module.
_AT_THE_COMPUTER: Final = (Phase.LOST, Phase.FAILED)


class LinkState(NamedTuple):
    """A phase and what is said of it, in the language in use: `word` is one or two words, `what` a sentence, and
    `next_step` may be empty."""

    phase: Phase
    word: str
    what: str
    next_step: str = ""
    step: NextStep | None = None
    # When the conversation ended (OFFLINE).
    ended_at: float | None = None

    @property
    def is_fine(self) -> bool:
        """Whether there is nothing for a person to do."""
        return self.phase in _FINE

    def word_at(self, now: float) -> str:
        return self.word if self.ended_at is None else tr("Offline for {time}", time=duration(now - self.ended_at))


def link_state(
    connection: Connection,
    conversation: ConversationView,
    silence: Silence | None,
    *,
    is_finding: bool,
    absence: Absence | None = None,
    switched_off_at: float | None = None,
    adapter: str = "",
    was_active: bool = False,
) -> LinkState:
    """`silence`: what came instead of an answer, as far as is known. `absence`: why a lost port is not open again.
    `switched_off_at`: the `time.time()` of a shutdown by command since which the module has not answered. `adapter`:
    the port's USB identity. `was_active`: the module was ACTIVE when it was last heard."""
    trouble, ended = connection.trouble, conversation.ended

    def state(phase: Phase, word: str, what: str = "", next_step: str = "", step: NextStep | None = None) -> LinkState:
        if was_active and phase not in (*_FINE, Phase.CLOSED):
            next_step = keep_away(next_step if phase in _AT_THE_COMPUTER else "")
        ended_at = ended.at if ended is not None and phase is Phase.OFFLINE else None
        return LinkState(phase, word, what or word, next_step, step, ended_at)

    if absence is not None:
        what = "" if trouble is None else explain(trouble).what
        return state(Phase.LOST, tr("Port lost"), what, tr(absence.value), NextStep.CHOOSE_PORT)
    if connection.state is PortState.OPENING:
        return state(Phase.OPENING, tr("Opening…"))
    if connection.state is PortState.CLOSED and trouble is not None:
        why = explain(trouble)
        word = tr("Port lost") if trouble.kind is PortErrorKind.LOST else tr("Not connected")
        return state(Phase.FAILED, word, why.what, why.next_step, NextStep.CONNECT_AGAIN)
    if connection.state is PortState.CLOSED:
        return state(Phase.CLOSED, tr("Not connected"), "", tr("Choose a port."), NextStep.CHOOSE_PORT)
    if is_finding:
        return state(Phase.FINDING, tr("Trying {rate} baud", rate=connection.baud_rate))
    if conversation.is_going and conversation.is_slow:
        return state(Phase.LATE, capitalised(tr("late")), tr(TOO_SLOW))
    if conversation.is_going and is_shared(connection.port):
        return state(Phase.ONLINE, tr("Shared, read-only"), tr(SHARED))
    if conversation.is_going:
        return state(Phase.ONLINE, capitalised(tr("connected")), tr("The module answers."))
    if switched_off_at is not None and (ended is not None or silence in (None, Silence.NOTHING)):
        word = tr("Switched off at {time}", time=time.strftime("%H:%M", time.localtime(switched_off_at)))
        return state(Phase.SWITCHED_OFF, word, "", tr("Hold its switch for 2 s, or connect external power."))
    if ended is not None:
        word, switch_on = capitalised(tr("offline")), tr("Check its power and cable; hold its switch for 2 s.")
        if ended.reason is EndReason.RATE_CHANGED:  # by us, and no rate was found since
            return state(Phase.OFFLINE, word, tr("The module does not answer."), switch_on, NextStep.FIND_RATE)
        reason = reason_message(ended.reason, ended.contradiction)
        return state(Phase.OFFLINE, word, reason.translated(), switch_on)
    if silence is None:
        return state(Phase.ASKING, tr("Asking the module…"))
    why = explain(PortEvidence(connection.port, connection.baud_rate, silence=silence, adapter=adapter))
    words = {Silence.GARBAGE: tr("Wrong rate?"), Silence.ECHO: capitalised(tr("echo"))}
    return state(Phase.SILENT, words.get(silence, tr("No reply")), why.what, why.next_step, why.step)


MAX_TRIPS = 4096


class LinkStatistics:
    """Counts and round trips. For one thread."""

    def __init__(self) -> None:
        self._trips_s: deque[float] = deque(maxlen=MAX_TRIPS)
        # Since the port was opened.
        self.totals = Counters()

    def on_batch(self, batch: Batch) -> None:
        if batch.counters is not None:
            self.totals = batch.counters
        for event in batch.events:
            if isinstance(event, Answered) and event.round_trip_s is not None:
                self._trips_s.append(event.round_trip_s)

    def quantile_s(self, share: float) -> float | None:
        """Quantile (`share` 0 … 1) of the last 4,096 round trips; None without any."""
        ordered = sorted(self._trips_s)
        return ordered[min(len(ordered) - 1, int(share * len(ordered)))] if ordered else None
