"""Infers the most likely cause of a failed connection, and the next action, from the evidence.

The first row of `CAUSES` that fits counts. `app.diagnosis.symptoms` and `app.diagnosis.adapter_facts` collect the
evidence.
"""

import shlex
import sys
from collections.abc import Callable, Mapping
from enum import Enum
from typing import NamedTuple

from app.diagnosis.symptoms import PortEvidence
from app.engine.conversation import Interrupted
from app.engine.target import is_network_address
from app.engine.transport import PortError, PortTrouble
from app.procedures.find import Silence
from app.safety.last_known import keep_away
from app.text.i18n import tr
from app.text.sentences import in_brackets, join_sentences
from protocol.events import EndReason, Role
from protocol.translatable import marked


class Cause(Enum):
    """What is wrong. The value is for logs and tests."""

    BRAILLE = "brltty takes the adapter"
    MODEM_PROBER = "a modem prober has the port"
    FLAPPING = "the adapter appears and vanishes"
    HELD = "another program has the port"
    LOG_IN_AGAIN = "the group is not yet effective"
    NO_PERMISSION = "no permission"
    REFUSED = "connection refused"
    OTHER_SERVER = "not an RFC 2217 server"
    UNREACHABLE = "host not reached"
    CUT_OFF = "connection closed"
    MISSING = "no such port"
    UNPLUGGED = "unplugged"
    STUCK = "takes no bytes"
    UNUSABLE = "no serial port"
    LOGIN = "a computer's console"
    SHUT_DOWN = "it was shut down"
    ECHO = "echo only"
    WRONG_RATE = "wrong baud rate"
    BAD_LINE = "checksum errors"
    TOO_SLOW = "answers too late"
    DEAF = "sends and does not answer"
    FELL_SILENT = "fell silent"
    NOTHING = "no bytes at all"
    SLOW_ADAPTER = "slow adapter"


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
    terminal_command: str = ""
    """A command of this program, for the command line."""
    step: NextStep = NextStep.CONNECT_AGAIN
    cause: Cause | None = None
    """None for what no row of `CAUSES` is about."""
    command: str | None = None
    """The shell command that is the next step."""

    @property
    def terminal_sentence(self) -> str:
        sentence = join_sentences((self.what, self.next_step))
        if not self.terminal_command:
            return sentence
        return sentence[:-1] + in_brackets(self.terminal_command) + sentence[-1]  # before the full stop


class CauseRow(NamedTuple):
    """A row of `CAUSES`. `what` and `next_step` are English, marked, with the placeholders of `_values`.
    `step`: where no command is the next step. `is_at_module`: the next step brings a hand near the module."""

    cause: Cause
    fits: Callable[[PortEvidence], bool]
    what: str
    next_step: str
    command: Callable[[PortEvidence], str | None] = lambda _evidence: None
    terminal_command: str = ""
    is_at_module: bool = False
    step: NextStep = NextStep.CONNECT_AGAIN


def diagnose(evidence: PortEvidence) -> Diagnosis | None:
    """The cause and what to do; None where nothing is wrong or nothing was asked yet."""
    for row in CAUSES:
        if row.fits(evidence):
            values = _values(evidence)
            command = row.command(evidence)
            next_step = tr(row.next_step, **values, command="" if command is None else command)
            if evidence.was_active and not evidence.is_answering:
                next_step = keep_away("" if row.is_at_module else next_step)
            what = tr(row.what, **values)
            step = row.step if command is None else NextStep.COPY_COMMAND
            return Diagnosis(what, next_step, row.terminal_command, step, row.cause, command)
    return None


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


_AGAIN = marked("Do it again.")
_AFTER_END: Mapping[EndReason, str] = {
    EndReason.RESTARTED: _AGAIN,
    EndReason.SILENT: marked("Check its power and cable, then do it again."),
    EndReason.CONTRADICTED: marked("Leave only one module on this line, then do it again."),
    EndReason.PORT_LOST: marked("Plug the adapter in, then do it again."),
    EndReason.CLOSED: _AGAIN,
    EndReason.SLEPT: _AGAIN,
    EndReason.ANOTHER: _AGAIN,
    EndReason.RATE_CHANGED: _AGAIN,
}
"""What to do when the conversation ended before what was asked for was done."""


# Shell commands

_JOIN_GROUP = "sudo usermod -aG dialout $USER"
"""The group of serial ports on Debian and Ubuntu."""


def _permission_command(evidence: PortEvidence) -> str | None:
    if not evidence.platform.startswith("linux"):
        return None
    access = evidence.facts.access
    if access is not None and access.group is not None:
        return f"sudo usermod -aG {access.group} $USER"
    return _install_rule(evidence) if access is not None and evidence.facts.rule_source else _JOIN_GROUP


def _install_rule(evidence: PortEvidence) -> str:
    source = shlex.quote(evidence.facts.rule_source)
    return f"sudo cp {source} /etc/udev/rules.d/ && sudo udevadm control --reload && sudo udevadm trigger"


def _rule_command(evidence: PortEvidence) -> str | None:
    """Makes ModemManager ignore the adapter: restart it where the udev rule is installed, else install the rule."""
    if evidence.facts.has_rule:
        return "sudo systemctl restart ModemManager"
    return _install_rule(evidence) if evidence.facts.rule_source else "sudo systemctl stop ModemManager"


def _latency_command(evidence: PortEvidence) -> str | None:
    path = evidence.facts.latency_path
    return None if path is None else f"echo 1 | sudo tee {path}"


def _values(evidence: PortEvidence) -> Mapping[str, object]:
    holder = evidence.trouble.holder if evidence.trouble is not None else None
    trip_s = evidence.round_trip_median_s
    counters = evidence.counters
    return {
        "port": evidence.port or (evidence.trouble.port if evidence.trouble is not None else ""),
        "rate": evidence.baud_rate,
        "program": "" if holder is None else holder.name,
        "pid": "" if holder is None else holder.pid,
        "visits": evidence.short_visits,
        "bytes": evidence.counters.bytes_received,
        "rejected": counters.rejected,
        "ms": "" if trip_s is None else round(trip_s * 1000),
    }


def _is_unreached_address(seen: PortEvidence) -> bool:
    is_unopened = seen.trouble_kind() in (PortTrouble.MISSING, PortTrouble.UNUSABLE)
    return is_unopened and is_network_address(seen.port)


def _is_no_rfc2217(seen: PortEvidence) -> bool:
    """pyserial says it by its text only."""
    return _is_unreached_address(seen) and "RFC2217" in str(seen.trouble)


def _is_lost_address(seen: PortEvidence) -> bool:
    return seen.trouble_kind() is PortTrouble.LOST and is_network_address(seen.port)


def _is_stuck_address(seen: PortEvidence) -> bool:
    return seen.trouble_kind() is PortTrouble.STUCK and is_network_address(seen.port)


def _is_garbage_of_a_socket(seen: PortEvidence) -> bool:
    """Over a plain socket this program sets no baud rate; over RFC 2217 it does."""
    return seen.port.startswith("socket://") and seen.came() is Silence.GARBAGE


def _is_mute_socket(seen: PortEvidence) -> bool:
    return seen.port.startswith("socket://") and seen.came() is Silence.NOTHING and not seen.was_online


CAUSES: tuple[CauseRow, ...] = (
    # The port cannot be opened
    CauseRow(Cause.BRAILLE, PortEvidence.is_claimed_by_brltty,
             marked("{port} vanishes: brltty, for Braille displays, takes the adapter."),
             marked("Type: {command} — then plug the adapter in again."), lambda _seen: "sudo apt remove brltty"),
    CauseRow(Cause.MODEM_PROBER, PortEvidence.is_prober, marked("ModemManager sends AT commands on {port}."),
             marked("Type: {command} — then plug the adapter in again."), _rule_command),
    CauseRow(Cause.FLAPPING, lambda seen: seen.is_gone() and seen.short_visits >= 2,
             marked("The adapter at {port} disconnected {visits} times."),
             marked("Use another USB cable and socket, without a hub.")),
    CauseRow(Cause.HELD, lambda seen: seen.is_busy() and bool(seen.holder_name()),
             marked("{port} is in use by {program} (process {pid})."), marked("Close it and connect again.")),
    CauseRow(Cause.HELD, PortEvidence.is_busy,
             marked("{port} is in use by another program."), marked("Close it and connect again.")),
    CauseRow(Cause.LOG_IN_AGAIN, lambda seen: seen.is_refused() and seen.may_soon(),
             marked("No permission for {port}."), marked("Log out and in again.")),
    CauseRow(Cause.NO_PERMISSION, lambda seen: seen.is_refused() and _permission_command(seen) is not None,
             marked("No permission for {port}."), marked("Type: {command} — then log out and in again."),
             _permission_command),
    CauseRow(Cause.NO_PERMISSION, PortEvidence.is_refused,
             marked("No permission for {port}."), marked("Ask the administrator for access to serial ports.")),
    CauseRow(Cause.REFUSED, lambda seen: _is_unreached_address(seen) and "refused" in str(seen.trouble).lower(),
             marked("{port}: connection refused."),
             marked("Start the program that offers the port, or correct the address.")),
    CauseRow(Cause.OTHER_SERVER, _is_no_rfc2217, marked("{port}: no RFC 2217 server answers."),
             marked("Correct the address, or try socket://HOST:PORT.")),
    CauseRow(Cause.UNREACHABLE, _is_unreached_address, marked("{port} cannot be reached."),
             marked("Start the program that offers the port, or correct the address.")),
    CauseRow(Cause.CUT_OFF, _is_lost_address, marked("{port}: the connection was closed."),
             marked("Check the network and the program that offers the port, then connect again.")),
    CauseRow(Cause.STUCK, _is_stuck_address, marked("Write to {port} timed out."),
             marked("Check the network and the program that offers the port, then connect again.")),
    CauseRow(Cause.MISSING, lambda seen: seen.trouble_kind() is PortTrouble.MISSING, marked("There is no port {port}."),
             marked("Plug the adapter in. If no port appears, install its driver."), terminal_command="dps-s ports",
             step=NextStep.CHOOSE_PORT),
    CauseRow(Cause.UNPLUGGED, lambda seen: seen.trouble_kind() is PortTrouble.LOST,
             marked("{port} was unplugged, or its driver failed."), marked("Unplug the adapter and plug it in again.")),
    CauseRow(Cause.STUCK, lambda seen: seen.trouble_kind() is PortTrouble.STUCK,
             marked("Write to {port} timed out."), marked("Unplug the adapter and plug it in again.")),
    CauseRow(Cause.UNUSABLE, lambda seen: seen.trouble_kind() is PortTrouble.UNUSABLE,
             marked("{port} is no serial port."), marked("Choose a port."), terminal_command="dps-s ports",
             step=NextStep.CHOOSE_PORT),
    CauseRow(Cause.UNUSABLE, lambda seen: seen.trouble_kind() is PortTrouble.UNSUPPORTED,
             marked("{port} is no serial port."),
             marked("Use a device name, socket://HOST:PORT or rfc2217://HOST:PORT; dps-s FILE opens a file."),
             step=NextStep.CHOOSE_PORT),
    # The port is open
    CauseRow(Cause.LOGIN, PortEvidence.has_login,
             marked("{port} leads to a computer, not a module."), marked("Choose a port."),
             step=NextStep.CHOOSE_PORT),
    CauseRow(Cause.SHUT_DOWN, lambda seen: seen.is_open and seen.was_shut_down and not seen.is_answering,
             marked("The module was switched off."), marked("Hold its switch for 2 s, or connect external power."),
             is_at_module=True),
    CauseRow(Cause.ECHO, lambda seen: seen.came() is Silence.ECHO, marked("Only an echo on {port}."),
             marked("Check the wiring: TX and RX touch, or no module is connected."), is_at_module=True,
             step=NextStep.CHOOSE_PORT),
    CauseRow(Cause.BAD_LINE, PortEvidence.is_bad_line,
             marked("Damaged frames: {rejected} of {bytes} bytes are invalid."),
             marked("Use a shorter cable, connect ground, avoid motors and antennas."), is_at_module=True),
    CauseRow(Cause.WRONG_RATE, _is_garbage_of_a_socket, marked("No readable frames on {port}."),
             marked("Check the address, and the baud rate in the program that offers the port.")),
    CauseRow(Cause.WRONG_RATE, lambda seen: seen.came() is Silence.GARBAGE,
             marked("No readable frames on {port} at {rate} baud."), marked("Find the baud rate."),
             terminal_command="dps-s find, or --baud auto", step=NextStep.FIND_RATE),
    CauseRow(Cause.TOO_SLOW, lambda seen: seen.came() is Silence.OTHER_FRAMES and seen.counters.by_role[Role.LATE] > 0,
             marked("The module on {port} answers later than a second."),
             marked("Use the cable, or a quicker line. LOCK works."), is_at_module=True),
    CauseRow(Cause.DEAF, lambda seen: seen.came() is Silence.OTHER_FRAMES and not seen.was_online,
             marked("The module on {port} sends, but does not answer."), marked("Check the wire to the module's RX."),
             is_at_module=True, step=NextStep.CHOOSE_PORT),
    CauseRow(Cause.FELL_SILENT, lambda seen: seen.came() is not None and seen.was_online,
             marked("The module does not answer."), marked("Check its power and cable; hold its switch for 2 s."),
             is_at_module=True),
    CauseRow(Cause.NOTHING, _is_mute_socket, marked("No module answers on {port}."),
             marked("Check the address, the baud rate at the other end, and the module's power and wires."),
             is_at_module=True),
    CauseRow(Cause.NOTHING, lambda seen: seen.came() is Silence.NOTHING,
             marked("No module answers on {port} at {rate} baud."),
             marked("Check power, ground and crossed TX and RX, or find the baud rate."),
             terminal_command="dps-s find", is_at_module=True, step=NextStep.FIND_RATE),
    CauseRow(Cause.SLOW_ADAPTER, lambda seen: seen.is_slow() and _latency_command(seen) is not None,
             marked("The adapter delays every answer by {ms} ms (latency timer)."), marked("Type: {command}"),
             _latency_command),
    CauseRow(Cause.SLOW_ADAPTER, PortEvidence.is_slow,
             marked("The adapter delays every answer by {ms} ms (latency timer)."),
             marked("Set the driver's latency timer to 1 ms.")),
)  # fmt: skip
