"""`dps-s simulate`: runs a simulated module behind a pseudo-terminal or a TCP socket, until Ctrl-C.

The first line is its port. More examples:

  dps-s simulate --link /tmp/dps-s --rate 1440
  dps-s simulate --history 9 --cell 3.6
  dps-s simulate --active --fall-after 20
  sim://NAME?drop=0.2&corrupt=0.01&seed=7
"""

import argparse
import signal
import sys
from contextlib import closing, suppress
from threading import Event
from typing import Any, get_args

import msgspec

from app.engine.target import host_and_port
from app.simulator.bench import SimulatedBench
from app.simulator.endpoints import PtyEndpoint, TcpEndpoint, serve
from app.simulator.setup import Setup, parse_options
from app.terminal import console
from app.text.i18n import tr
from app.text.messages import ErrorCode, error_text, labelled


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.usage = "%(prog)s [--link PATH | --tcp HOST:PORT] [--OPTION VALUE …]"
    way = parser.add_mutually_exclusive_group()
    console.add_file(way, "--link", metavar="PATH", help="symbolic link to the pseudo-terminal")
    way.add_argument("--tcp", type=host_and_port, metavar="HOST:PORT")
    module = parser.add_argument_group("module, line and world")
    for option in msgspec.structs.fields(Setup):
        # The last of its annotations describes it. A switch needs no value.
        kind, *notes = get_args(option.type)
        value: dict[str, Any] = {"nargs": "?", "const": "yes", "metavar": "yes|no"} if kind is bool else {}
        text = f"{notes[-1].description} [{option.default}]"
        module.add_argument("--" + option.name.replace("_", "-"), default=argparse.SUPPRESS, help=text, **value)


def run(args: argparse.Namespace) -> int:
    """Serve until SIGINT or SIGTERM. Exit code 0; 2 for wrong usage; 3 if the port cannot be made."""
    texts = {name: getattr(args, name) for name in Setup.__struct_fields__ if hasattr(args, name)}
    bench = SimulatedBench(parse_options(texts))
    if args.tcp is None and sys.platform == "win32":
        raise console.Refused(tr("Windows has no pseudo-terminals: use {option}.", option="--tcp 127.0.0.1:0"))
    try:
        with closing(TcpEndpoint(*args.tcp) if args.tcp else PtyEndpoint(args.link)) as endpoint:
            is_stopped = Event()
            for name in ("SIGINT", "SIGTERM", "SIGHUP"):
                if hasattr(signal, name):
                    signal.signal(getattr(signal, name), lambda *_signal: is_stopped.set())
            with suppress(console.OutputLost):  # nobody reads it, and the link leads there
                console.write_lines([endpoint.address])
            serve(bench, endpoint, is_stopped)
    except OSError as error:
        where = args.link or (":".join(map(str, args.tcp)) if args.tcp else "pty")
        raise console.Refused(labelled(where, error_text(error)), ErrorCode.NO_PORT) from error
    return console.SUCCESS
