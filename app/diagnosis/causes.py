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
    """Observations of one port since it was opened, or why it was not."""

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
    platform: str = sys.platform
    # What was counted before it: evidence of a conversation counts from its beginning, that of a silence from the last
    # answer. Bytes that came at another rate are no evidence.
    mark: Counters = Counters()

    def after(self, batch: Batch) -> "PortEvidence":
        """Return it with what a batch tells; to be called with every batch, in order."""
        connection, counters, mark = batch.connection, batch.counters, self.mark
        is_open = connection.state is PortState.OPEN
        is_answering = is_open and batch.conversation.is_going
        is_new = connection.baud_rate != self.baud_rate or is_answering is not self.is_answering
        if connection.state is PortState.OPENING:
            mark = Counters()
        elif counters is not None and is_new:
            mark = counters
        return self._replace(
            port=connection.port or self.port,
            baud_rate=connection.baud_rate or self.baud_rate,
            trouble=connection.trouble,
            is_open=is_open,
            is_answering=is_answering,
            was_online=self.was_online or is_answering,
            counters=self.counters if counters is None else counters - mark,
            noise=self.noise if counters is None else batch.noise,
            mark=mark,
        )

    def has(self, *kinds: PortErrorKind) -> bool:
        return self.trouble is not None and self.trouble.kind in kinds

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
        """Whether a flight controller answers, or nothing was ever heard on the port of one."""
        is_quiet = self.came() is Silence.NOTHING and not self.was_online and is_flight_controller(self.adapter)
        return is_quiet or self.came() is Silence.FLIGHT_CONTROLLER


class NextStep(Enum):
    """The value is English, translatable."""

    CHOOSE_PORT = marked("Choose a port")
    FIND_RATE = marked("Find the baud rate")
    CONNECT_AGAIN = marked("Connect again")
    COPY_COMMAND = marked("Copy")
    WHY = marked("Why?")


class Diagnosis(NamedTuple):
    """What is wrong, and what to do. The texts are in the language in use; in `CAUSES` they are marked, with the
    place-holders that `diagnose` fills."""

    # Empty for what `CAUSES` does not have.
    cause: str
    what: str
    next_step: str
    # The shell command that is the next step.
    command: str = ""
    # A command of this program, for the command line.
    terminal_command: str = ""
    # The next step brings a hand near the module.
    is_at_module: bool = False
    step: NextStep = NextStep.CONNECT_AGAIN

    @property
    def terminal_sentence(self) -> str:
        sentence = join_sentences((self.what, self.next_step))
        if not self.terminal_command:
            return sentence
        return sentence[:-1] + in_brackets(self.terminal_command) + sentence[-1]  # before the full stop


def diagnose(evidence: PortEvidence) -> Diagnosis | None:
    """The cause and what to do; None where nothing is wrong or nothing was asked yet."""
    found = next((diagnosis for fits, diagnosis in CAUSES if fits(evidence)), None)
    if found is None:
        return None
    values: dict[str, object] = {
        "port": evidence.port,
        "rate": evidence.baud_rate,
        "bytes": evidence.counters.bytes_received,
        "rejected": evidence.counters.rejected,
        "command": found.command,
    }
    next_step = tr(found.next_step, **values)
    if evidence.was_active and not evidence.is_answering:
        next_step = keep_away("" if found.is_at_module else next_step)
    return found._replace(what=tr(found.what, **values), next_step=next_step)


def explain(error: Exception | PortEvidence) -> Diagnosis:
    """Explains a `PortError`, an `Interrupted` or what was seen of a silent port; any other error is reported as
    unexpected."""
    evidence = PortEvidence(error.port, trouble=error) if isinstance(error, PortError) else error
    explanation = diagnose(evidence) if isinstance(evidence, PortEvidence) else None
    if explanation is not None:
        return explanation
    if isinstance(error, Interrupted):
        return Diagnosis("", error.sentence, tr(_AFTER_END[error.reason]))
    what = tr("Unexpected error: {error}.", error=error)
    return Diagnosis("", what, tr("Connect again. If it fails, save a support bundle (Diagnosis)."))


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


_OF_A_NETWORK = PortErrorKind.MISSING, PortErrorKind.UNUSABLE, PortErrorKind.LOST
CAUSES: tuple[tuple[Callable[[PortEvidence], bool], Diagnosis], ...] = (
    # The port cannot be opened
    (lambda seen: _is_on_linux(seen, PortErrorKind.BUSY), Diagnosis(
        "held", marked("{port} is in use by another program, perhaps ModemManager."),
        marked("Close it, or type: {command} — then plug the adapter in again."),
        "sudo systemctl stop ModemManager", step=NextStep.COPY_COMMAND)),
    (lambda seen: seen.has(PortErrorKind.BUSY), Diagnosis(
        "held", marked("{port} is in use by another program."), marked("Close it and connect again."))),
    (lambda seen: _is_on_linux(seen, PortErrorKind.NOT_ALLOWED), Diagnosis(
        "no permission", marked("No permission for {port}."), marked("Type: {command} — then log out and in again."),
        "sudo usermod -aG dialout $USER", step=NextStep.COPY_COMMAND)),
    (lambda seen: seen.has(PortErrorKind.NOT_ALLOWED), Diagnosis(
        "no permission", marked("No permission for {port}."),
        marked("Ask the administrator for access to serial ports."))),
    (lambda seen: is_network_address(seen.port) and seen.has(*_OF_A_NETWORK), Diagnosis(
        "unreachable", marked("{port} cannot be reached."),
        marked("Check the network and the program that offers the port, then connect again."))),
    (lambda seen: seen.has(PortErrorKind.MISSING), Diagnosis(
        "missing", marked("There is no port {port}."),
        marked("Plug the adapter in. On Linux brltty may take it: remove that. If no port comes, install its driver."),
        terminal_command="dps-s ports", step=NextStep.CHOOSE_PORT)),
    (lambda seen: seen.has(PortErrorKind.LOST), Diagnosis(
        "unplugged", marked("{port} was unplugged, or its driver failed."),
        marked("Unplug the adapter and plug it in again."))),
    (lambda seen: seen.has(PortErrorKind.UNUSABLE, PortErrorKind.UNSUPPORTED), Diagnosis(
        "unusable", marked("{port} is no serial port."),
        marked("Use a device name, socket://HOST:PORT or rfc2217://HOST:PORT; dps-s FILE opens a file."),
        step=NextStep.CHOOSE_PORT)),
    # The port is open
    (PortEvidence.is_at_flight_controller, Diagnosis(
        "flight controller", marked("No module answers on {port}, a flight controller's port."),
        marked(
            "Switch its passthrough on: guide or docs/adapters.md, “Through the flight controller”. Its restart ends "
            "that."
        ))),
    (lambda seen: seen.came() is Silence.ECHO, Diagnosis(
        "echo", marked("Only an echo on {port}."),
        marked("Check the wiring: TX and RX touch, or no module is connected."), is_at_module=True,
        step=NextStep.CHOOSE_PORT)),
    (PortEvidence.is_bad_line, Diagnosis(
        "bad line", marked("Damaged frames: {rejected} of {bytes} bytes are invalid."),
        marked("Use a shorter cable, connect ground, avoid motors and antennas."), is_at_module=True)),
    (lambda seen: _is_socket(seen, Silence.GARBAGE), Diagnosis(
        "wrong rate", marked("No readable frames on {port}."),
        marked("Check the address, and the baud rate in the program that offers the port."))),
    (lambda seen: seen.came() is Silence.GARBAGE, Diagnosis(
        "wrong rate", marked("No readable frames on {port} at {rate} baud."), marked("Find the baud rate."),
        terminal_command="dps-s find, or --baud auto", step=NextStep.FIND_RATE)),
    (lambda seen: seen.came() is Silence.OTHER_FRAMES and seen.counters.by_role[Role.LATE] > 0, Diagnosis(
        "too slow", marked("The module on {port} answers later than a second."),
        marked("Use the cable, or a quicker line. LOCK works."), is_at_module=True)),
    (lambda seen: seen.came() is Silence.OTHER_FRAMES and not seen.was_online, Diagnosis(
        "deaf", marked("The module on {port} sends, but does not answer."),
        marked("Check the wire to the module's RX."), is_at_module=True, step=NextStep.CHOOSE_PORT)),
    (lambda seen: seen.came() is not None and seen.was_online, Diagnosis(
        "fell silent", marked("The module does not answer."),
        marked("Check its power and cable; hold its switch for 2 s."), is_at_module=True)),
    (lambda seen: _is_socket(seen, Silence.NOTHING) and not seen.was_online, Diagnosis(
        "nothing", marked("No module answers on {port}."),
        marked("Check the address, the baud rate at the other end, and the module's power and wires."),
        is_at_module=True)),
    (lambda seen: seen.came() is Silence.NOTHING, Diagnosis(
        "nothing", marked("No module answers on {port} at {rate} baud."),
        marked("Check power, ground and crossed TX and RX, or find the baud rate."),
        terminal_command="dps-s find", is_at_module=True, step=NextStep.FIND_RATE)),
)  # fmt: skip
