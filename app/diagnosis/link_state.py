"""The link as a person sees it: its state with the next action, and the statistics of one connection."""

import time
from collections import deque
from enum import Enum
from typing import Final, NamedTuple

from app.diagnosis.causes import NextStep, PortEvidence, explain
from app.diagnosis.silence import Silence
from app.engine.conversation import ConversationView, reason_message
from app.engine.procedure import SHARED, TOO_SLOW
from app.engine.reconnect import LOSSES, Absence
from app.engine.target import is_shared
from app.engine.transport import PortError
from app.engine.worker import Batch, Connection, PortState
from app.safety.last_known import keep_away
from app.text.i18n import tr
from app.text.messages import capitalised, duration
from protocol.events import Answered, Counters, Ended, EndReason


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
    """A phase with what is known in it."""

    phase: Phase
    port: str = ""
    baud_rate: int = 0
    # Why the conversation ended (OFFLINE).
    ended: Ended | None = None
    # What came instead of an answer (SILENT).
    silence: Silence | None = None
    # Of the port (FAILED, LOST).
    trouble: PortError | None = None
    # The `time.time()` of a shutdown by command since which the module has not answered (SWITCHED_OFF).
    off_at: float | None = None
    # Why a lost port is not open again (LOST).
    absence: Absence | None = None
    # Its USB identity.
    adapter: str = ""
    # The module was ACTIVE when it was last heard.
    was_active: bool = False

    @property
    def is_fine(self) -> bool:
        """Whether there is nothing for a person to do."""
        return self.phase in _FINE


class LinkText(NamedTuple):
    """A text in the language in use. `word` is one or two words, `what` a sentence, and `next_step` may be empty."""

    word: str
    what: str
    next_step: str = ""
    step: NextStep | None = None


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
    """`silence`: what came instead of an answer, as far as is known. The others are those of `LinkState`."""
    has_answered = conversation.number > 0
    if absence is not None:
        phase = Phase.LOST
    elif connection.state is PortState.OPENING:
        phase = Phase.OPENING
    elif connection.state is PortState.CLOSED:
        phase = Phase.CLOSED if connection.trouble is None else Phase.FAILED
    elif is_finding:
        phase = Phase.FINDING
    elif conversation.is_going:
        phase = Phase.LATE if conversation.is_slow else Phase.ONLINE
    elif switched_off_at is not None and (has_answered or silence in (None, Silence.NOTHING)):
        phase = Phase.SWITCHED_OFF
    elif has_answered:
        phase = Phase.OFFLINE
    else:
        phase = Phase.ASKING if silence is None else Phase.SILENT
    return LinkState(
        phase,
        connection.port,
        connection.baud_rate,
        ended=conversation.ended if phase is Phase.OFFLINE else None,
        silence=silence if phase is Phase.SILENT else None,
        trouble=connection.trouble,
        off_at=switched_off_at if phase is Phase.SWITCHED_OFF else None,
        absence=absence,
        adapter=adapter,
        was_active=was_active,
    )


def link_text(state: LinkState, now: float) -> LinkText:
    """Texts for `state` at this time of the program's clock."""
    text = _link_text(state, now)
    if not state.was_active or state.is_fine or state.phase is Phase.CLOSED:
        return text
    return text._replace(next_step=keep_away(text.next_step if state.phase in _AT_THE_COMPUTER else ""))


def _link_text(state: LinkState, now: float) -> LinkText:
    ended, trouble = state.ended, state.trouble
    switch_on = tr("Check its power and cable; hold its switch for 2 s.")
    match state.phase:
        case Phase.CLOSED:
            return LinkText(tr("Not connected"), tr("Not connected"), tr("Choose a port."), NextStep.CHOOSE_PORT)
        case Phase.OPENING:
            return LinkText(tr("Opening…"), tr("Opening…"))
        case Phase.FINDING:
            trying = tr("Trying {rate} baud", rate=state.baud_rate)
            return LinkText(trying, trying)
        case Phase.ASKING:
            return LinkText(tr("Asking the module…"), tr("Asking the module…"))
        case Phase.ONLINE:
            if is_shared(state.port):
                return LinkText(tr("Shared, read-only"), tr(SHARED))
            return LinkText(capitalised(tr("connected")), tr("The module answers."))
        case Phase.LATE:
            return LinkText(capitalised(tr("late")), tr(TOO_SLOW))
        case Phase.OFFLINE if ended is not None:
            word = tr("Offline for {time}", time=duration(now - ended.at))
            if ended.reason is EndReason.RATE_CHANGED:  # by us, and no rate was found since
                return LinkText(word, tr("The module does not answer."), switch_on, NextStep.FIND_RATE)
            return LinkText(word, reason_message(ended.reason, ended.contradiction).translated(), switch_on)
        case Phase.OFFLINE:
            return LinkText(capitalised(tr("offline")), tr("The module does not answer."), switch_on)
        case Phase.SILENT:
            silence = state.silence or Silence.NOTHING
            seen = explain(PortEvidence(state.port, state.baud_rate, silence=silence, adapter=state.adapter))
            words = {Silence.GARBAGE: tr("Wrong rate?"), Silence.ECHO: capitalised(tr("echo"))}
            return LinkText(words.get(silence, tr("No reply")), seen.what, seen.next_step, seen.step)
        case Phase.LOST:
            what = tr("Port lost") if trouble is None else explain(trouble).what
            next_step = tr((state.absence or Absence.AWAY).value)
            return LinkText(tr("Port lost"), what, next_step, NextStep.CHOOSE_PORT)
        case Phase.SWITCHED_OFF:
            word = tr("Switched off at {time}", time=time.strftime("%H:%M", time.localtime(state.off_at)))
            return LinkText(word, word, tr("Hold its switch for 2 s, or connect external power."))
        case Phase.FAILED if trouble is not None:
            seen = explain(trouble)
            word = tr("Port lost") if trouble.kind in LOSSES else tr("Not connected")
            return LinkText(word, seen.what, seen.next_step, NextStep.CONNECT_AGAIN)
        case Phase.FAILED:
            what = tr("A program error closed the port.")
            return LinkText(tr("Not connected"), what, tr("Connect again"), NextStep.CONNECT_AGAIN)


MAX_TRIPS = 4096


class LinkStatistics:
    """They belong to one thread."""

    def __init__(self) -> None:
        self._trips_s: deque[float] = deque(maxlen=MAX_TRIPS)
        # Since the port was opened.
        self.totals = Counters()

    def on_batch(self, batch: Batch) -> None:
        """Processes one batch; to be called for every batch, in order."""
        if batch.counters is not None:
            self.totals = batch.counters
        for event in batch.events:
            if isinstance(event, Answered) and event.round_trip_s is not None:
                self._trips_s.append(event.round_trip_s)

    def quantile_s(self, share: float) -> float | None:
        """Quantile (`share` 0 … 1) of the last 4,096 round trips; None without any."""
        ordered = sorted(self._trips_s)
        return ordered[min(len(ordered) - 1, int(share * len(ordered)))] if ordered else None
