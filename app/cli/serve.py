"""`dps-s serve`: shares a port with readers over TCP, read-only, until Ctrl-C.

The first line is the address that they open, such as `dps-s read -p shared://127.0.0.1:7001`, or the window. They may
ask, and send LOCK; all else is refused here, with the reason on standard error, and never reaches the module. The
serial output is left as it is. Only this computer reaches the address, unless --tcp names another one: TCP has no
authentication, so whoever reaches it reads, and may LOCK. Exit code 0 after Ctrl-C; 3 if the port was lost.
"""

import argparse
import socket
from contextlib import suppress
from ipaddress import ip_address
from typing import Literal

from app.terminal import console
from app.terminal.arguments import add_json, add_port, tcp_address
from app.terminal.connection import connected
from app.terminal.interruption import Signalled, signals_noted
from app.terminal.records import opened_store, records_on
from app.terminal.results import Result
from app.terminal.sharing import Event, Sharing
from app.text.i18n import tr
from app.text.sentences import error_text, labelled
from app.text.user_error import ErrorCode


class ServeJson(Result):
    """`address`: what readers open, else the reader; empty where it is about the module."""

    event: Literal["listening", "joined", "left", "dropped", "refused", "lock", "locked", "not_locked", "ended"]
    address: str


def add_arguments(parser: argparse.ArgumentParser) -> None:
    text = "where readers connect (default: a free port of this computer)"
    parser.add_argument("--tcp", type=tcp_address, default=("127.0.0.1", 0), metavar="HOST:PORT", help=text)
    add_port(parser)
    add_json(parser)


def run(args: argparse.Namespace) -> int:
    host, number = args.tcp
    try:
        family = socket.AF_INET6 if ":" in host else socket.AF_INET
        listener = socket.create_server((host, number), family=family)
    except OSError as error:
        raise console.Refused(labelled(f"{host}:{number}", error_text(error)), ErrorCode.NO_PORT) from error

    def tell(event: Event, reader: str, sentence: str) -> None:
        if sentence:
            console.notify(labelled(reader, sentence) if reader else sentence)
        if args.json:
            console.write_lines([console.as_json(ServeJson(event.value, reader))])

    with listener, signals_noted(), opened_store() as (store, troubles), connected(args.port, args.baud) as opened:
        at, number = listener.getsockname()[:2]
        address = f"shared://[{at}]:{number}" if family is socket.AF_INET6 else f"shared://{at}:{number}"
        console.write_lines([console.as_json(ServeJson("listening", address)) if args.json else address])
        if not ip_address(at).is_loopback:
            console.notify(
                tr("TCP has no authentication: whoever reaches {address} reads, and may LOCK.", address=address)
            )
        with suppress(Signalled):
            Sharing(opened, records_on(store, troubles, args.port, origin="serve").journal, tell).run(listener)
    return console.SUCCESS
