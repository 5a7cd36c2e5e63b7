"""Entry point of `dps-s`: dispatches sub-commands and opens the window.

The module of a sub-command is imported only when it is called.
"""

import argparse
import atexit
import gc
import io
import logging
import os
import sys
import threading
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from app.cli.commands import BY_NAME, WINDOW, is_file_name, whole_parser
from app.terminal import console
from app.text.i18n import set_language, system_language, tr
from app.text.messages import ErrorCode, UserError, join_names
from protocol.translatable import marked

if TYPE_CHECKING:
    from app.modules.labels import Paper

_log = logging.getLogger(__name__)
# The port if --port is missing.
PORT = "DPS_S_PORT"
# Threshold of the garbage collector (Python's is 700): collecting during the imports takes a tenth of the start.
_OBJECTS_PER_COLLECTION = 10_000
# Options that may also stand before the command.
_ANYWHERE = ("-v", "-vv", "--verbose", "--quiet")


def main(argv: Sequence[str] | None = None) -> int:
    """Run `dps-s` with these arguments, by default those of the process; returns the exit code."""
    words = list(sys.argv[1:] if argv is None else argv)
    if argv is None and words and words[0] in BY_NAME and words[0] != WINDOW:
        gc.set_threshold(_OBJECTS_PER_COLLECTION)
        atexit.register(gc.freeze)  # looking through all objects at the end takes another tenth
    _prepare_output()
    set_language(system_language())
    console.start(argparse.Namespace())
    try:
        code = _run(words)
    except SystemExit:  # from argparse, which printed the help
        code = console.SUCCESS
    except KeyboardInterrupt as interrupted:
        # As a shell reports it: 130 for Ctrl-C, 143 for SIGTERM.
        code = 128 + (interrupted.args[0] if interrupted.args else 2)
        if "--json" in words and not console.state.has_result:  # else nothing is said: who pressed Ctrl-C knows
            console.fail(console.Refused(tr("Interrupted."), ErrorCode.CANCELLED), is_json=True)
    except console.OutputLost as error:
        if str(error):
            console.notify(tr("{file} cannot be written: {why}.", file="stdout", why=error))
        code = console.PARTIAL
    except Exception as error:  # noqa: BLE001  the top level: people get a sentence, no traceback
        _log.debug("ended by", exc_info=error)
        code = console.fail(error, is_json="--json" in words and not console.state.has_result)
    _log.debug("exit code %d", code)
    return code


def _run(words: list[str]) -> int:
    if words[:1] in (["-h"], ["--help"]):
        console.write(whole_parser(is_complete=False).format_help())
        return console.SUCCESS
    if words[:1] == ["--version"]:
        from app import version

        console.write_lines([f"DPS-S Configurator {version()}"])
        return console.SUCCESS
    command = next((word for word in words if word not in _ANYWHERE), "")
    if command in BY_NAME:  # dps-s -v read
        words.remove(command)
        words.insert(0, command)
    if not words or words[0].startswith("-") or is_file_name(words[0]):
        words = [WINDOW, *words]
    entry = BY_NAME.get(words[0])
    if entry is None:
        named = tr("There is no command {name}.", name=words[0] + console.did_you_mean(words[0], BY_NAME))
        raise console.Refused("\n".join((named, tr("Help: {command}", command="dps-s -h"))))
    args = entry.parse_words(words[1:])
    console.start(args)
    if console.state.verbosity > (0 if entry.name == WINDOW else 1):
        logging.basicConfig(level=logging.DEBUG)
    elif entry.name != WINDOW:  # which configures its own log
        logging.getLogger().addHandler(logging.NullHandler())  # else Python prints warnings and tracebacks
    _log.debug("%s", entry.name)
    run: Callable[[argparse.Namespace], int] = entry.load().run
    args.open_window, args.printer = _open_window, _print_pages
    if entry.name == WINDOW:
        if args.port is not None:
            _refuse_address(args.port)
        return run(args)
    if not hasattr(args, "port"):
        return run(args)
    with console.signals_noted():  # so that a signal keeps no result from being printed, once nothing is sent any more
        _choose_ports(args)
        if entry.name == "read":
            # It changes nothing, and says it while it waits for answers.
            saying = threading.Thread(target=_say_left_active, args=(args,), daemon=True)
            saying.start()
            try:
                return run(args)
            finally:
                saying.join()
        if entry.name != "lock":  # which waits for no file
            _say_left_active(args)
        return run(args)


def _choose_ports(args: argparse.Namespace) -> None:
    """Set `port`, and `ports` where the command takes several. Raises `UserError`, `PortError`."""
    ports = list(dict.fromkeys(args.port or ()))
    if len(args.port or ()) > 1 and args.command != "preflight":
        # Who locks two ports with one command would find only the last one locked.
        raise console.Refused("--port is given twice")
    # Without --yes the command is refused, whatever the port; `diff FILE FILE` has none.
    is_done = getattr(args, "yes", True) or getattr(args, "activate", None) is False
    if not ports and is_done and getattr(args, "other", None) is None:
        ports = [_usual_port()]
    for port in ports:
        _refuse_address(port)
    args.ports, args.port = ports, ports[0] if ports else None


def _refuse_address(port: str) -> None:
    # Raises `PortError` for a kind of address that is not opened, and `UserError` for a wrong option of `sim://`.
    from app.engine.target import is_simulated
    from app.engine.transport import refuse_unsupported

    refuse_unsupported(port)
    if is_simulated(port):
        from app.port_urls.protocol_sim import options_of

        options_of(port)


def _usual_port() -> str:
    """Choose and print the port. Raises `Refused`."""
    from app.engine.ports import list_ports

    # What is said of each port.
    named = os.environ.get(PORT, "").strip()
    found = {named: PORT}
    if not named:
        found = {port.device: port.description or port.identity for port in list_ports() if port.vid is not None}
    if not found:
        raise console.Refused(tr("There is no USB adapter. Plug it in, or give --port."), ErrorCode.NO_PORT)
    if len(found) > 1:
        raise console.Refused(tr("There are several adapters: {names}. Give --port.", names=join_names(found)))
    ((port, name),) = found.items()
    console.note(tr("Port {port} ({name})", port=port, name=name))
    return port


def _say_left_active(args: argparse.Namespace) -> None:
    from app.engine.target import is_simulated
    from app.system.files import data_folder

    real = [port for port in args.ports if not is_simulated(port)]
    if real and os.access(data_folder(), os.F_OK):  # else nothing of the store is loaded
        from app.terminal.records import say_left_active

        say_left_active(real, getattr(args, "module", None))


# Passed to the commands, which do not import Qt


def _open_window(args: argparse.Namespace) -> int:
    gc.disable()  # until the window frees its garbage itself: collecting during the imports takes a tenth of the start
    from ui.main import WindowOptions, run

    return run(WindowOptions(**{name: getattr(args, name) for name in WindowOptions._fields}))


def _print_pages(bodies: Sequence[str], paper: "Paper", attachment: bytes | None) -> bytes:
    # Raises `UserError`. Signals are noted meanwhile: an exception in the middle of Qt would abort the process.
    try:
        from ui.files.report_printer import print_pages

        return print_pages(bodies, paper, attachment)
    except (ImportError, RuntimeError) as error:
        raise UserError(marked("It cannot be printed: {why}."), why=error) from error


def _prepare_output() -> None:
    for name, mode in (("stdin", "r"), ("stdout", "w"), ("stderr", "w")):
        if getattr(sys, name) is None and sys.platform != "win32":  # there windowed programs have none
            # It was closed: the port or a file would get its number, and what is printed.
            setattr(sys, name, Path(os.devnull).open(mode, encoding="utf-8"))  # noqa: SIM115
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            # "?" for what a console lacks. Where it is redirected it is UTF-8, as the contract says.
            is_console = stream.isatty() or "PYTHONIOENCODING" in os.environ
            stream.reconfigure(encoding=None if is_console else "utf-8", errors="replace")


if __name__ == "__main__":
    sys.exit(main())
