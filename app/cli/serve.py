"""`dps-s serve`: shares a port with readers over TCP, read-only, until Ctrl-C.

The first line is the address that they open, such as `dps-s read -p shared://127.0.0.1:7001`, or the window. They may
ask, and send LOCK; all else is refused here, with the reason on standard error, and never reaches the module. The
serial output is left as it is. Only this computer reaches the address, unless --tcp names another one: TCP has no
authentication, so whoever reaches it reads, and may LOCK. Exit code 0 after Ctrl-C; 3 if the port was lost.
"""

import argparse
import socket
from collections.abc import Callable
from contextlib import suppress
from typing import Any, Literal

from app.engine.procedure import Job
from app.engine.worker import Batch, PortState
from app.procedures.lock import Locked, lock
from app.safety.journal import Journal
from app.sharing import Event, Sharing, Tell, address_of, listen_at, warning_of
from app.terminal import console
from app.terminal.arguments import add, add_port, tcp_address
from app.terminal.connection import OpenPort, connected
from app.terminal.interruption import Signalled, check_signals, signals_noted
from app.terminal.records import opened_store, records_on
from app.terminal.results import Result
from app.text.messages import ErrorCode, error_text, labelled

# How long what the module says may wait.
LOOK_EVERY_S = 0.01


class ServeJson(Result):
    """`address`: what readers open, else the reader; empty where it is about the module."""

    event: Literal["listening", "joined", "left", "dropped", "refused", "lock", "locked", "not_locked", "ended"]
    address: str


def add_arguments(parser: argparse.ArgumentParser) -> None:
    text = "where readers connect (default: a free port of this computer)"
    parser.add_argument("--tcp", type=tcp_address, default=("127.0.0.1", 0), metavar="HOST:PORT", help=text)
    add_port(parser)
    add(parser, "--json")


def run(args: argparse.Namespace) -> int:
    host, number = args.tcp
    try:
        listener = listen_at(host, number)
    except OSError as error:
        raise console.Refused(labelled(f"{host}:{number}", error_text(error)), ErrorCode.NO_PORT) from error

    def tell(event: Event, reader: str, sentence: str) -> None:
        if sentence:
            console.notify(labelled(reader, sentence) if reader else sentence)
        if args.json:
            console.write_lines([console.as_json(ServeJson(event.value, reader))])

    with listener, signals_noted(), opened_store() as (store, troubles), connected(args.port, args.baud) as opened:
        address = address_of(listener)
        console.emit(args, ServeJson("listening", address), [address])
        if warning := warning_of(listener):
            console.notify(warning)
        journal = records_on(store, troubles, args.port, origin="serve").journal
        with suppress(Signalled):
            _serve(opened, listener, journal, tell)
    return console.SUCCESS


def _serve(opened: OpenPort, listener: socket.socket, journal: Journal, tell: Tell) -> None:
    """Until the port is lost, which raises `PortError`, or a signal comes, which raises `Signalled`."""
    endings: dict[Job[Any], Callable[[Job[Any]], None]] = {}

    def submit(job: Job[Any], then: Callable[[Job[Any]], None], *, is_urgent: bool = False) -> None:
        endings[job] = then
        opened.submit(job, is_urgent=is_urgent)

    locking: Job[Locked] | None = None

    def send_lock(then: Callable[[Locked], None]) -> None:
        nonlocal locking
        if locking is None or locking.is_done:
            locking = Job(lock(journal), outlives=True)
            submit(locking, lambda job: then(job.outcome()), is_urgent=True)

    def on_batch(batch: Batch) -> None:
        sharing.take_in(batch)
        for job in batch.finished:
            if job in endings:
                endings.pop(job)(job)

    sharing = Sharing(listener, submit, send_lock, tell)
    opened.listen(on_batch, LOOK_EVERY_S)
    try:
        while opened.connection.state is PortState.OPEN:
            sharing.turn(LOOK_EVERY_S)
            check_signals()
            opened.drain()
    finally:
        sharing.close()
    raise opened.connection.trouble or RuntimeError("the port was closed without a reason")
