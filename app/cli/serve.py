"""`dps-s serve`: shares a port with readers over TCP, read-only, until Ctrl-C.

The first line is the address that they open, such as `dps-s read -p shared://127.0.0.1:7001`, or the window. They may
ask, and send LOCK; all else is refused here, with the reason on standard error, and never reaches the module. The
serial output is left as it is. Only this computer reaches the address, unless --tcp names another one: TCP has no
authentication, so whoever reaches it reads, and may LOCK. Exit code 0 after Ctrl-C; 3 if the port was lost.
"""

import argparse
from collections.abc import Callable
from contextlib import suppress
from typing import Literal

from app.engine.procedure import Job
from app.engine.target import host_and_port
from app.engine.worker import PortState
from app.procedures.lock import Locked, lock
from app.sharing import Event, Sharing, listen_at
from app.terminal import console
from app.terminal.connection import connected
from app.terminal.records import CommandStore
from app.terminal.results import Result
from app.text.messages import ErrorCode, error_text, labelled

# How long what the module says may wait.
LOOK_EVERY_S = 0.01


class ServeJson(Result):
    """`address`: what readers open, else the reader; empty where it is about the module."""

    event: Literal["listening"] | Event
    address: str


def add_arguments(parser: argparse.ArgumentParser) -> None:
    where = "where readers connect (default: a free port of this computer)"
    parser.add_argument("--tcp", type=host_and_port, default=("127.0.0.1", 0), metavar="HOST:PORT", help=where)


def run(args: argparse.Namespace) -> int:
    host, number = args.tcp
    try:
        listener, address, warning = listen_at(host, number)
    except OSError as error:
        raise console.Refused(labelled(f"{host}:{number}", error_text(error)), ErrorCode.NO_PORT) from error
    locking: Job[Locked] | None = None

    def tell(event: Event, reader: str, sentence: str) -> None:
        if sentence:
            console.notify(labelled(reader, sentence) if reader else sentence)
        if args.json:
            console.emit(args, ServeJson(event, reader), [])

    with listener, CommandStore(args.port) as store, connected(args.port, args.baud) as opened:
        console.emit(args, ServeJson("listening", address), [address])
        if warning:
            console.notify(warning)

        def send_lock(then: Callable[[Locked], None]) -> None:
            nonlocal locking
            if locking is None or locking.is_done:
                locking = Job(lock(store.journal), conversation=None)
                opened.submit(locking, lambda job: then(job.outcome()), is_urgent=True)

        sharing = Sharing(listener, opened.submit, send_lock, tell)
        opened.listeners.append(sharing.take_in)
        # A reader waits for its answer; a window or a person would not notice.
        opened.worker.publish_every_s = LOOK_EVERY_S
        with suppress(KeyboardInterrupt):
            try:
                while opened.connection.state is PortState.OPEN:
                    sharing.turn(LOOK_EVERY_S)
                    console.check_signals()
                    opened.drain()
            finally:
                sharing.close()
            raise opened.connection.trouble or RuntimeError("the port was closed without a reason")
    return console.SUCCESS
