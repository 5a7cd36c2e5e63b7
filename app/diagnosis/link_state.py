"""State of the link and the next action, as the top bar and the connect panel show them."""

import time
from enum import Enum
from functools import partial
from typing import NamedTuple

from app.diagnosis.causes import NextStep, explain
from app.diagnosis.symptoms import PortEvidence
from app.engine.device import DeviceView
from app.engine.reconnect import LOSSES, Absence
from app.engine.transport import PortError
from app.engine.worker import Connection, PortState
from app.procedures.handshake import Silence
from app.safety.last_known import keep_away
from app.text.durations import duration
from app.text.i18n import tr
from app.text.sentences import capitalised
from protocol.link_states import Presence


class Phase(Enum):
    CLOSED = "closed"
    OPENING = "opening"
    FINDING = "finding"
    """Trying baud rates."""
    ASKING = "asking"
    """Open, with no answer yet."""
    SILENT = "silent"
    """Open, and no module has ever answered."""
    ONLINE = "online"
    LATE = "late"
    """Answers arrive so late that they may be out of date."""
    OFFLINE = "offline"
    """It answered before and no longer does."""
    LOST = "lost"
    """The port was lost; it is reopened when the same adapter returns."""
    FAILED = "failed"
    """The port could not be opened."""
    SWITCHED_OFF = "switched_off"
    """It was shut down by command, which is not a fault."""


class LinkState(NamedTuple):
    phase: Phase
    port: str = ""
    baud_rate: int = 0
    since: float | None = None
    """Monotonic seconds; for OFFLINE."""
    silence: Silence | None = None
    """For SILENT: what arrived instead of an answer."""
    lag_s: float | None = None
    """For LATE."""
    trouble: PortError | None = None
    """For FAILED and LOST."""
    off_at: float | None = None
    """`time.time()`; for SWITCHED_OFF."""
    absence: Absence | None = None
    """For LOST, and for FAILED after a loss: why the port is not open again."""
    was_active: bool = False
    """The module was ACTIVE when it was last heard."""

    @property
    def is_fine(self) -> bool:
        """Whether there is nothing for a person to do."""
        return self.phase in (Phase.OPENING, Phase.FINDING, Phase.ASKING, Phase.ONLINE)


class LinkText(NamedTuple):
    """In the language in use. `word`: one or two words; `what`: a sentence; `next_step`: may be empty."""

    word: str
    what: str
    next_step: str = ""
    step: NextStep | None = None


def link_state(
    connection: Connection,
    device: DeviceView,
    silence: Silence | None,
    *,
    is_finding: bool,
    absence: Absence | None = None,
    switched_off_at: float | None = None,
    was_active: bool = False,
) -> LinkState:
    """`silence`: what came instead of an answer, as far as is known. `absence`: why a lost port is not open again.
    `switched_off_at`: `time.time()` of a shutdown by command since which the module has not answered. `was_active`: it
    was ACTIVE when it was last heard."""
    state = partial(LinkState, port=connection.port, baud_rate=connection.baud_rate, was_active=was_active)
    if absence is not None and absence.is_waiting:
        return state(Phase.LOST, trouble=connection.trouble, absence=absence)
    if connection.state is PortState.OPENING:
        return state(Phase.OPENING)
    if connection.state is PortState.CLOSED:
        phase = Phase.CLOSED if connection.trouble is None else Phase.FAILED
        return state(phase, trouble=connection.trouble, absence=absence)
    if is_finding:
        return state(Phase.FINDING)
    if device.presence is Presence.ONLINE and device.is_late:
        # In steps of 0.5 s, so that the text does not change with every answer.
        return state(Phase.LATE, lag_s=round((device.lag_s or 0.0) * 2) / 2)
    if device.presence is Presence.ONLINE:
        return state(Phase.ONLINE)
    is_mute = silence in (None, Silence.NOTHING)
    if switched_off_at is not None and (device.values or is_mute):
        return state(Phase.SWITCHED_OFF, off_at=switched_off_at)
    if device.values:
        return state(Phase.OFFLINE, since=device.presence_since)
    if silence is not None:
        return state(Phase.SILENT, silence=silence)
    return state(Phase.ASKING)


_AT_THE_COMPUTER = (Phase.LOST, Phase.FAILED)
"""The next step needs nothing done at the module."""


def link_text(state: LinkState, now: float) -> LinkText:
    """Texts for `state` at the monotonic time `now`."""
    text = _link_text(state, now)
    if not state.was_active or state.is_fine or state.phase is Phase.CLOSED:
        return text
    return text._replace(next_step=keep_away(text.next_step if state.phase in _AT_THE_COMPUTER else ""))


def _link_text(state: LinkState, now: float) -> LinkText:
    match state.phase:
        case Phase.CLOSED:
            return LinkText(tr("Not connected"), tr("Not connected"), tr("Choose a port."), NextStep.CHOOSE_PORT)
        case Phase.OPENING:
            return _progress(tr("Opening…"))
        case Phase.FINDING:
            return _progress(tr("Trying {rate} baud", rate=state.baud_rate))
        case Phase.ASKING:
            return _progress(tr("Asking the module…"))
        case Phase.ONLINE:
            return LinkText(capitalised(tr("connected")), tr("The module answers."))
        case Phase.LATE:
            late = duration(state.lag_s or 0.0)
            return LinkText(
                tr("{time} late", time=late),
                tr("Data arrives {seconds:.1f} s late.", seconds=state.lag_s or 0.0),
                tr("Only LOCK is possible. Use a cable or a closer radio link."),
            )
        case Phase.OFFLINE:
            since = state.since
            word = capitalised(tr("offline")) if since is None else tr("Offline for {time}", time=duration(now - since))
            next_step = tr("Check its power and cable; hold its switch for 2 s.")
            return LinkText(word, tr("The module does not answer."), next_step)
        case Phase.SILENT:
            return _silent_text(state)
        case Phase.LOST:
            what = tr("Port lost") if state.trouble is None else explain(state.trouble).what
            next_step = tr((state.absence or Absence.AWAY).value)
            return LinkText(tr("Port lost"), what, next_step, NextStep.CHOOSE_PORT)
        case Phase.SWITCHED_OFF:
            word = tr("Switched off at {time}", time=time.strftime("%H:%M", time.localtime(state.off_at)))
            return LinkText(word, word, tr("Hold its switch for 2 s, or connect external power."))
        case Phase.FAILED:
            return _failed_text(state.trouble, state.absence)


def _progress(word: str) -> LinkText:
    return LinkText(word, word)


def _silent_text(state: LinkState) -> LinkText:
    silence = state.silence or Silence.NOTHING
    explanation = explain(PortEvidence(state.port, state.baud_rate, silence=silence))
    words = {Silence.GARBAGE: tr("Wrong rate?"), Silence.ECHO: capitalised(tr("echo"))}
    return LinkText(words.get(silence, tr("No reply")), explanation.what, explanation.next_step, explanation.step)


def _failed_text(trouble: PortError | None, absence: Absence | None) -> LinkText:
    if trouble is None:
        what = tr("A program error closed the port.")
        return LinkText(tr("Not connected"), what, tr("Connect again"), NextStep.CONNECT_AGAIN)
    explanation = explain(trouble)
    word = tr("Not connected") if trouble.trouble not in LOSSES else tr("Port lost")
    next_step = explanation.next_step if absence is None else tr(absence.value)
    return LinkText(word, explanation.what, next_step, NextStep.CONNECT_AGAIN)
