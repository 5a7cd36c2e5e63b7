"""`dps-s ports`: lists the serial ports. Opens none of them."""

import argparse

from app.engine.ports import list_ports, scan, to_json
from app.terminal import console
from app.text.i18n import tr
from app.text.user_error import UserError


def run(args: argparse.Namespace) -> int:
    try:
        ports = scan() if args.list_here else list_ports()
    except UserError as error:
        console.notify(error.sentence)
        return console.NO_LINK
    if args.json:
        console.write_lines([to_json(ports)])
        return console.SUCCESS
    if not ports:
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
    console.write_lines(console.columns([head, *rows]))
    return console.SUCCESS
