"""Lists the serial ports.

Listing can take ten seconds where Bluetooth ports are queried one by one. So it runs in a thread with a deadline:
pyserial reads files on Linux and asks Windows and macOS through ctypes, both of which let the other threads run.
"""

import os
import threading
from collections.abc import Iterable
from concurrent.futures import Future
from typing import NamedTuple

from app.text.messages import ErrorCode, UserError, visible
from protocol.translatable import marked


class PortInfo(NamedTuple):
    """A serial port as the system describes it; "" or None where something is unknown."""

    device: str
    description: str = ""
    maker: str = ""
    serial_number: str = ""
    vid: int | None = None  # USB vendor
    pid: int | None = None  # USB product
    location: str = ""  # USB bus and socket

    @property
    def identity(self) -> str:
        """Identifies the adapter, whatever its device name: the serial number, else vendor, product and socket; "" for
        ports that are not on USB."""
        if self.vid is None or self.pid is None:
            return ""
        product = f"{self.vid:04x}:{self.pid:04x}"
        if self.serial_number:
            return f"{product}:{self.serial_number}"
        return f"{product}@{self.location}" if self.location else ""


def port_named(device: str, ports: Iterable[PortInfo]) -> PortInfo | None:
    """The port that has this name, or to which this symbolic link leads."""
    names = (device, os.path.realpath(device))
    return next((port for port in ports if port.device in names), None)


# As the udev rule has them: STM32 and AT32 as Betaflight, iNav and ArduPilot name them; 3D Robotics and PX4, CubePilot,
# Holybro, CUAV, Auterion and ARK with all their products.
_FLIGHT_CONTROLLERS = ("0483:5740", "1209:5740", "1209:5741", "2e3c:5740", "26ac:", "2dae:", "3162:", "3163:", "3185:")


def is_flight_controller(identity: str) -> bool:
    """Whether a port of this identity is a flight controller's, behind which a module may be."""
    return identity.startswith(_FLIGHT_CONTROLLERS)


NOT_LISTED = marked("The system lists no serial ports. Switch Bluetooth off and try again.")


def _scan() -> list[PortInfo]:
    # Its import fails where a library of the system is missing.
    from serial.tools import list_ports as pyserial_ports

    ports = [
        PortInfo(
            device=str(port.device),
            description=_text(port.product) or _text(port.description),
            maker=_text(port.manufacturer),
            serial_number=_text(port.serial_number),
            vid=port.vid,
            pid=port.pid,
            location=_text(port.location),
        )
        for port in pyserial_ports.comports()
    ]
    return sorted(ports, key=lambda port: (port.vid is None, port.device))


def _text(value: str | None) -> str:
    # An adapter may describe itself with any characters.
    return "" if value is None or value == "n/a" else visible(value)


# Held by the thread that scans, so that only one runs.
_scanning = threading.Lock()


class NotListed(UserError):
    code = ErrorCode.NO_PORT


def list_ports(deadline_s: float = 3.0) -> list[PortInfo]:
    """List the ports, USB first. Raises `NotListed` after `deadline_s`, and for any failure of the system."""
    listed: Future[list[PortInfo]] = Future()

    def scan_and_release() -> None:
        try:
            listed.set_result(_scan())
        except Exception as error:  # noqa: BLE001  whatever the system's libraries raise
            listed.set_exception(error)
        finally:
            _scanning.release()

    if not _scanning.acquire(timeout=deadline_s):
        raise NotListed(NOT_LISTED)
    threading.Thread(target=scan_and_release, name="dps-s ports", daemon=True).start()
    try:
        return listed.result(deadline_s)
    except Exception as error:
        raise NotListed(NOT_LISTED) from error
