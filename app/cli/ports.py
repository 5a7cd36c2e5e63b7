"""`dps-s ports`: lists the serial ports. Opens none of them."""

import argparse
from typing import Annotated

from msgspec import Meta

from app.engine.ports import is_flight_controller, list_ports
from app.terminal import console
from app.terminal.results import Result
from app.text.i18n import tr
from app.text.messages import in_brackets

UsbNumber = Annotated[int, Meta(ge=0, le=65535)]


class PortJson(Result):
    device: str
    description: str
    maker: str
    serial_number: str
    vid: UsbNumber | None
    pid: UsbNumber | None
    location: str


class PortsJson(Result):
    ports: list[PortJson]


def run(args: argparse.Namespace) -> int:
    ports = [PortJson.of(port) for port in list_ports()]
    if not ports:
        console.note(tr("No serial port. Plug the adapter in; try another cable or its driver."))
    rows = [(tr("Port"), tr("Name"), tr("Manufacturer"), tr("Serial number"), "USB")]
    for port in ports:
        usb = "" if port.vid is None or port.pid is None else f"{port.vid:04x}:{port.pid:04x}"
        kind = in_brackets(tr("flight controller")) if is_flight_controller(usb) else ""
        rows.append((port.device, port.description + kind, port.maker, port.serial_number, usb))
    return console.emit(args, PortsJson(ports), console.columns(rows) if ports else [])
