"""Explains a port error or a silent module in one sentence with one next step.

The window and the command line say the same. Each text names the port; `details` of the driver go to the log, not here.
"""

import platform
from dataclasses import dataclass

from app.engine.procedure import Slept
from app.engine.transport import PortError, PortTrouble
from app.procedures.greet import Silence
from app.text.i18n import tr


@dataclass(frozen=True, slots=True)
class Explanation:
    """In the language in use now: make it when it is shown, not before."""

    what: str
    next_step: str
    command: str = ""
    """What to type for the next step, for whoever sits at a terminal."""

    @property
    def sentence(self) -> str:
        return f"{self.what} {self.next_step}".strip()

    @property
    def terminal_sentence(self) -> str:
        if not self.command:
            return self.sentence
        return f"{self.sentence[:-1]} ({self.command}){self.sentence[-1]}"  # before the full stop


class NoAnswer(Exception):
    """The port is open, and no module answers on it."""

    def __init__(self, port: str, baud_rate: int, silence: Silence) -> None:
        super().__init__(f"{port}: no answer at {baud_rate} baud: {silence.value}")
        self.port = port
        self.baud_rate = baud_rate
        self.silence = silence


def explain(error: Exception) -> Explanation:
    """The explanation of a `PortError`, `NoAnswer` or `Slept`; anything else is a bug and is said as such."""
    if isinstance(error, PortError):
        return _explain_port(error)
    if isinstance(error, NoAnswer):
        return _explain_silence(error)
    if isinstance(error, Slept):
        return Explanation(tr("The computer slept; what was under way has ended."), tr("Start it again."))
    return Explanation(
        tr("The program met an error that it did not expect: {error}.", error=error),
        tr("Connect again; if it comes back, send us the log."),
    )


def _explain_port(error: PortError) -> Explanation:
    port = error.port
    match error.trouble:
        case PortTrouble.MISSING:
            return Explanation(
                tr("There is no port {port}.", port=port),
                tr("Plug the adapter in and choose it from the list."),
                "dps-s ports",
            )
        case PortTrouble.BUSY:
            return _explain_busy(error)
        case PortTrouble.NOT_ALLOWED:
            return Explanation(tr("You may not open {port}.", port=port), _permission_step())
        case PortTrouble.UNUSABLE:
            return Explanation(
                tr("{port} cannot be used as a serial port.", port=port),
                tr("Choose another port from the list."),
                "dps-s ports",
            )
        case PortTrouble.UNSUPPORTED:
            return Explanation(
                tr("{port} is no address that this program opens.", port=port),
                tr("Use a device name, socket://HOST:PORT or rfc2217://HOST:PORT."),
            )
        case PortTrouble.LOST:
            return Explanation(
                tr("{port} was unplugged or its driver failed.", port=port),
                tr("Check the cable, plug the adapter in again and connect."),
            )
        case PortTrouble.STUCK:
            return Explanation(
                tr("{port} takes no bytes.", port=port),
                tr("Unplug the adapter, plug it in again and connect."),
            )


def _explain_busy(error: PortError) -> Explanation:
    if error.holder is None:
        return Explanation(
            tr("{port} is in use by another program.", port=error.port), tr("Close that program and connect again.")
        )
    return Explanation(
        tr(
            "{port} is in use by {program} (process {pid}).",
            port=error.port,
            program=error.holder.name,
            pid=error.holder.pid,
        ),
        tr("Close {program} and connect again.", program=error.holder.name),
    )


def _permission_step() -> str:
    if platform.system() == "Linux":
        return tr("Type: sudo usermod -aG dialout $USER — then log out and in again.")
    return tr("Ask the administrator of this computer for access to serial ports.")


def _explain_silence(error: NoAnswer) -> Explanation:
    port, rate = error.port, error.baud_rate
    match error.silence:
        case Silence.NOTHING:
            return Explanation(
                tr("No module answers on {port} at {rate} baud.", port=port, rate=rate),
                tr("Check that it is switched on and that TX and RX are crossed; if so, find the rate."),
                "dps-s find",
            )
        case Silence.GARBAGE:
            return Explanation(
                tr("Something sends on {port}, but no frame can be read at {rate} baud.", port=port, rate=rate),
                tr("Most likely the module has another baud rate: find it."),
                "dps-s find, or --baud auto",
            )
        case Silence.ECHO:
            return Explanation(
                tr("Only our own bytes come back on {port}.", port=port),
                tr("Check the wiring: TX and RX touch each other, or the module is not connected."),
            )
        case Silence.OTHER_FRAMES:
            return Explanation(
                tr("The module on {port} sends, but does not answer.", port=port),
                tr("Check the wire from the adapter's TX to the module's RX."),
            )
