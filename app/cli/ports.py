"""`dps-s ports`: lists the serial ports. Opens none of them."""

import argparse

from app.cli.results import PortJson, PortsJson
from app.engine.ports import list_ports, scan
from app.terminal import console
from app.terminal.arguments import add_json
from app.text.i18n import tr
from app.text.user_error import ErrorCode, UserError


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_json(parser)
    # `app.engine.ports` starts this very command, with a limit of time, where listing can hang.
    parser.add_argument("--list-here", action="store_true", help=argparse.SUPPRESS)


def run(args: argparse.Namespace) -> int:
    try:
        ports = scan() if args.list_here else list_ports()
    except UserError as error:
        raise console.Refused(error.message, ErrorCode.NO_PORT) from error
    if not ports and not args.json:
        console.note(tr("No serial port. Plug the adapter in; try another cable or its driver."))
        return console.SUCCESS
    head = (tr("Port"), tr("Name"), tr("Manufacturer"), tr("Serial number"), "USB")
    rows = [
        (
            port.device,
            port.description,
            port.maker,
            port.serial_number,
            f"{port.vid:04x}:{port.pid:04x}" if port.vid is not None and port.pid is not None else "",
        )
        for port in ports
    ]
    answer = PortsJson(ports=[PortJson(**port._asdict()) for port in ports])
    console.emit(args, answer, console.columns([head, *rows]))
    return console.SUCCESS
