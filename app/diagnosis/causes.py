"""Infers the most likely cause of a failed connection, and the next action, from the evidence: what the batches of the
worker tell of the port. The first row of `CAUSES` that fits counts."""

import sys
from collections.abc import Callable, Mapping
from enum import Enum
from typing import NamedTuple

from app.diagnosis.silence import Silence, what_came
from app.engine.conversation import Interrupted
from app.engine.ports import is_flight_controller
from app.engine.session import MAX_NOISE_BYTES
from app.engine.target import is_network_address, is_socket
from app.engine.transport import PortError, PortErrorKind
from app.engine.worker import Batch, PortState
from app.safety.last_known import keep_away
from app.text.i18n import tr
from app.text.messages import in_brackets, join_sentences
from protocol.events import Counters, EndReason, Role
from protocol.messages import Reason
from protocol.translatable import marked

# Of the rejected bytes: at a wrong rate hardly any reach the checksum.
CHECKSUM_SHARE = 0.25
# Of all bytes while frames arrive: more is a bad line.
REJECTED_SHARE = 0.02


class PortEvidence(NamedTuple):
    """Observations of one port since it was opened, or why it was not. Times in seconds."""

    port: str = ""
    baud_rate: int = 115200
    trouble: PortError | None = None
    # What a handshake received instead of an answer, where that is the only evidence.
    silence: Silence | None = None
    is_open: bool = False
    # A module answers requests; one that only sends unasked does not.
    is_answering: bool = False
    # A module has answered since the connection began.
    was_online: bool = False
    # The module was ACTIVE when it was last heard.
    was_active: bool = False
    counters: Counters = Counters()
    # The last rejected bytes, up to `MAX_NOISE_BYTES`.
    noise: bytes = b""
    # Its USB identity, where it is known.
    adapter: str = ""
    round_trip_median_s: float | None = None
    # As `sys.platform`.
    platform: str = "linux"

    def has(self, *kinds: PortErrorKind, is_address: bool = False) -> bool:
        """Whether the port has one of these troubles; with `is_address` only one that is a network address."""
        is_one = self.trouble is not None and self.trouble.kind in kinds
        return is_one and (not is_address or is_network_address(self.port))

    def is_silent(self) -> bool:
        """Whether requests were sent on the open port and no module answers."""
        return self.is_open and not self.is_answering and self.counters.time_outs > 0

    def came(self) -> Silence | None:
        """What came instead of an answer; None where a module answers or nothing was asked."""
        if self.silence is not None:
            return self.silence
        return what_came(self.counters, self.noise) if self.is_silent() else None

    def is_bad_line(self) -> bool:
        """Whether frames are damaged, rather than bytes of another rate."""
        counters = self.counters
        if not self.is_open or not counters.rejected:
            return False
        if counters.frames > counters.by_role[Role.ECHO]:
            is_much = counters.rejected > REJECTED_SHARE * counters.bytes_received
            return is_much and counters.rejected > MAX_NOISE_BYTES // 8
        begun = sum(counters.rejected_bytes[reason] for reason in (Reason.CHECKSUM, Reason.INCOMPLETE, Reason.VALUE))
        return self.is_silent() and begun >= CHECKSUM_SHARE * counters.rejected

    def is_at_flight_controller(self) -> bool:
        """Whether no module was ever heard on the port of a flight controller, nor anything else."""
        return self.came() is Silence.NOTHING and not self.was_online and is_flight_controller(self.adapter)


class EvidenceCollector:
    """Collects evidence from every batch. Belongs to one thread."""

    def __init__(self) -> None:
        self.begin("")

    def begin(self, port: str) -> None:
        """Discards all evidence: a new connection to `port`."""
        self.seen = PortEvidence(port=port, platform=sys.platform)
        # Evidence of a conversation counts from its beginning, that of a silence from the last answer. Bytes that came
        # at another rate are no evidence.
        self._mark = Counters()

    def on_batch(self, batch: Batch) -> None:
        """Processes one batch; to be called for every batch, in order."""
        connection, seen, counters = batch.connection, self.seen, batch.counters
        is_open = connection.state is PortState.OPEN
        is_answering = is_open and batch.conversation.is_going
        is_new = connection.baud_rate != seen.baud_rate or is_answering is not seen.is_answering
        if connection.state is PortState.OPENING:
            self._mark = Counters()
        elif counters is not None and is_new:
            self._mark = counters
        self.seen = seen._replace(
            port=connection.port or seen.port,
            baud_rate=connection.baud_rate or seen.baud_rate,
            trouble=connection.trouble,
            is_open=is_open,
            is_answering=is_answering,
            was_online=seen.was_online or is_answering,
            counters=seen.counters if counters is None else counters - self._mark,
            round_trip_median_s=seen.round_trip_median_s if counters is None else batch.conversation.lag_s,
            noise=seen.noise if counters is None else batch.noise,
        )


class NextStep(Enum):
    CHOOSE_PORT = "choose_port"
    FIND_RATE = "find_rate"
    CONNECT_AGAIN = "connect_again"
    COPY_COMMAND = "copy_command"
    WHY = "why"


STEP_WORDS: Mapping[NextStep, str] = {
    NextStep.CHOOSE_PORT: marked("Choose a port"),
    NextStep.FIND_RATE: marked("Find the baud rate"),
    NextStep.CONNECT_AGAIN: marked("Connect again"),
    NextStep.COPY_COMMAND: marked("Copy"),
    NextStep.WHY: marked("Why?"),
}


class Diagnosis(NamedTuple):
    """Texts in the language in use; to be made when they are shown."""

    what: str
    next_step: str
    # A command of this program, for the command line.
    terminal_command: str = ""
    step: NextStep = NextStep.CONNECT_AGAIN
    # For tests; empty for what no row of `CAUSES` is about.
    cause: str = ""
    # The shell command that is the next step.
    command: str = ""

    @property
    def terminal_sentence(self) -> str:
        sentence = join_sentences((self.what, self.next_step))
        if not self.terminal_command:
            return sentence
        return sentence[:-1] + in_brackets(self.terminal_command) + sentence[-1]  # before the full stop


class CauseRow(NamedTuple):
    """`what` and `next_step` are English, marked, with the place-holders that `diagnose` fills."""

    cause: str
    fits: Callable[[PortEvidence], bool]
    what: str
    next_step: str
    command: str = ""
    terminal_command: str = ""
    # The next step brings a hand near the module.
    is_at_module: bool = False
    # Where no command is the next step.
    step: NextStep = NextStep.CONNECT_AGAIN


def diagnose(evidence: PortEvidence) -> Diagnosis | None:
    """The cause and what to do; None where nothing is wrong or nothing was asked yet."""
    row = next((row for row in CAUSES if row.fits(evidence)), None)
    if row is None:
        return None
    trouble = evidence.trouble
    values: dict[str, object] = {
        "port": evidence.port or ("" if trouble is None else trouble.port),
        "rate": evidence.baud_rate,
        "bytes": evidence.counters.bytes_received,
        "rejected": evidence.counters.rejected,
        "command": row.command,
    }
    next_step = tr(row.next_step, **values)
    if evidence.was_active and not evidence.is_answering:
        next_step = keep_away("" if row.is_at_module else next_step)
    step = NextStep.COPY_COMMAND if row.command else row.step
    return Diagnosis(tr(row.what, **values), next_step, row.terminal_command, step, row.cause, row.command)


def explain(error: Exception | PortEvidence) -> Diagnosis:
    """Explains a `PortError`, an `Interrupted` or what was seen of a silent port; any other error is reported as
    unexpected."""
    evidence = error if isinstance(error, PortEvidence) else None
    if isinstance(error, PortError):
        evidence = PortEvidence(port=error.port, trouble=error, platform=sys.platform)
    explanation = None if evidence is None else diagnose(evidence)
    if explanation is not None:
        return explanation
    if isinstance(error, Interrupted):
        return Diagnosis(error.sentence, tr(_AFTER_END[error.reason]))
    return Diagnosis(
        tr("Unexpected error: {error}.", error=error),
        tr("Connect again. If it fails, save a support bundle (Diagnosis)."),
    )


# What to do when the conversation ended before what was asked for was done.
_AFTER_END: Mapping[EndReason, str] = {
    **dict.fromkeys(EndReason, marked("Do it again.")),
    EndReason.SILENT: marked("Check its power and cable, then do it again."),
    EndReason.CONTRADICTED: marked("Leave only one module on this line, then do it again."),
    EndReason.PORT_LOST: marked("Plug the adapter in, then do it again."),
}


def _is_socket(seen: PortEvidence, came: Silence) -> bool:
    """Over a plain socket this program sets no baud rate; over RFC 2217 it does."""
    return is_socket(seen.port) and seen.came() is came


def _is_on_linux(seen: PortEvidence, kind: PortErrorKind) -> bool:
    return seen.platform.startswith("linux") and seen.has(kind)


_PASSTHROUGH = marked(
    "Switch its passthrough on: guide or docs/adapters.md, “Through the flight controller”. Its restart ends that."
)
_OF_A_NETWORK = PortErrorKind.MISSING, PortErrorKind.UNUSABLE, PortErrorKind.LOST, PortErrorKind.STUCK
CAUSES: tuple[CauseRow, ...] = (
    # The port cannot be opened
    CauseRow("held", lambda seen: _is_on_linux(seen, PortErrorKind.BUSY),
             marked("{port} is in use by another program, perhaps ModemManager."),
             marked("Close it, or type: {command} — then plug the adapter in again."),
             "sudo systemctl stop ModemManager"),
    CauseRow("held", lambda seen: seen.has(PortErrorKind.BUSY),
             marked("{port} is in use by another program."), marked("Close it and connect again.")),
    CauseRow("no permission", lambda seen: _is_on_linux(seen, PortErrorKind.NOT_ALLOWED),
             marked("No permission for {port}."), marked("Type: {command} — then log out and in again."),
             "sudo usermod -aG dialout $USER"),
    CauseRow("no permission", lambda seen: seen.has(PortErrorKind.NOT_ALLOWED),
             marked("No permission for {port}."), marked("Ask the administrator for access to serial ports.")),
    CauseRow("unreachable", lambda seen: seen.has(*_OF_A_NETWORK, is_address=True),
             marked("{port} cannot be reached."),
             marked("Check the network and the program that offers the port, then connect again.")),
    CauseRow("missing", lambda seen: seen.has(PortErrorKind.MISSING), marked("There is no port {port}."),
             marked(
                 "Plug the adapter in. On Linux brltty may take it: remove that. If no port comes, install its driver."
             ),
             terminal_command="dps-s ports", step=NextStep.CHOOSE_PORT),
    CauseRow("unplugged", lambda seen: seen.has(PortErrorKind.LOST, PortErrorKind.STUCK),
             marked("{port} was unplugged, or its driver failed."), marked("Unplug the adapter and plug it in again.")),
    CauseRow("unusable", lambda seen: seen.has(PortErrorKind.UNUSABLE),
             marked("{port} is no serial port."), marked("Choose a port."), terminal_command="dps-s ports",
             step=NextStep.CHOOSE_PORT),
    CauseRow("unusable", lambda seen: seen.has(PortErrorKind.UNSUPPORTED),
             marked("{port} is no serial port."),
             marked("Use a device name, socket://HOST:PORT or rfc2217://HOST:PORT; dps-s FILE opens a file."),
             step=NextStep.CHOOSE_PORT),
    # The port is open
    CauseRow("flight controller", lambda seen: seen.came() is Silence.FLIGHT_CONTROLLER,
             marked("A flight controller answers on {port}, not a module."), _PASSTHROUGH),
    CauseRow("flight controller", PortEvidence.is_at_flight_controller,
             marked("No module answers on {port}, a flight controller's port."), _PASSTHROUGH),
    CauseRow("echo", lambda seen: seen.came() is Silence.ECHO, marked("Only an echo on {port}."),
             marked("Check the wiring: TX and RX touch, or no module is connected."), is_at_module=True,
             step=NextStep.CHOOSE_PORT),
    CauseRow("bad line", PortEvidence.is_bad_line,
             marked("Damaged frames: {rejected} of {bytes} bytes are invalid."),
             marked("Use a shorter cable, connect ground, avoid motors and antennas."), is_at_module=True),
    CauseRow("wrong rate", lambda seen: _is_socket(seen, Silence.GARBAGE), marked("No readable frames on {port}."),
             marked("Check the address, and the baud rate in the program that offers the port.")),
    CauseRow("wrong rate", lambda seen: seen.came() is Silence.GARBAGE,
             marked("No readable frames on {port} at {rate} baud."), marked("Find the baud rate."),
             terminal_command="dps-s find, or --baud auto", step=NextStep.FIND_RATE),
    CauseRow("too slow",
             lambda seen: seen.came() is Silence.OTHER_FRAMES and seen.counters.by_role[Role.LATE] > 0,
             marked("The module on {port} answers later than a second."),
             marked("Use the cable, or a quicker line. LOCK works."), is_at_module=True),
    CauseRow("deaf", lambda seen: seen.came() is Silence.OTHER_FRAMES and not seen.was_online,
             marked("The module on {port} sends, but does not answer."), marked("Check the wire to the module's RX."),
             is_at_module=True, step=NextStep.CHOOSE_PORT),
    CauseRow("fell silent", lambda seen: seen.came() is not None and seen.was_online,
             marked("The module does not answer."), marked("Check its power and cable; hold its switch for 2 s."),
             is_at_module=True),
    CauseRow("nothing", lambda seen: _is_socket(seen, Silence.NOTHING) and not seen.was_online,
             marked("No module answers on {port}."),
             marked("Check the address, the baud rate at the other end, and the module's power and wires."),
             is_at_module=True),
    CauseRow("nothing", lambda seen: seen.came() is Silence.NOTHING,
             marked("No module answers on {port} at {rate} baud."),
             marked("Check power, ground and crossed TX and RX, or find the baud rate."),
             terminal_command="dps-s find", is_at_module=True, step=NextStep.FIND_RATE),
)  # fmt: skip
