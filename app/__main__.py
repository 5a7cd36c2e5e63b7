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
from collections.abc import Sequence
from itertools import takewhile
from pathlib import Path
from typing import TYPE_CHECKING

from app.cli.commands import BY_NAME, WINDOW, grouped_summaries, is_file_name
from app.terminal import console
from app.terminal.arguments import Parser
from app.terminal.left_active import say_left_active
from app.text.i18n import set_language, system_language, tr
from app.text.sentences import join_names
from app.text.user_error import ErrorCode, UserError

if TYPE_CHECKING:
    from app.engine.transport import PortError
    from app.modules.labels import Paper

DEBUG = "DPS_S_DEBUG"
"""Environment variable: with 1, errors show their traceback and the log goes to standard error."""
PORT = "DPS_S_PORT"
"""Environment variable: the port if --port is missing."""
_OBJECTS_PER_COLLECTION = 10_000
"""Threshold of the garbage collector (Python's is 700): collecting during the imports takes a tenth of the start."""


_JUDGING = {
    "set", "diff", "activate", "lock", "zero", "shutdown", "preflight", "provision", "verify", "fired",
}  # fmt: skip
"""Exit code 0 is their answer, so it is not given where nobody read what they print."""
_ANYWHERE = ("-v", "-vv", "--verbose", "--quiet")
"""Options that may also stand before the command."""


def main(argv: Sequence[str] | None = None) -> int:
    """Run `dps-s` with these arguments, by default those of the process; returns the exit code."""
    words = list(sys.argv[1:] if argv is None else argv)
    if argv is None and words and words[0] in BY_NAME and words[0] != WINDOW:
        gc.set_threshold(_OBJECTS_PER_COLLECTION)
        atexit.register(gc.freeze)  # looking through all objects at the end takes another tenth
    _prepare_output()
    set_language(system_language())
    if not _has_home():
        os.environ["HOME"] = os.devnull  # nothing can be made below it, and says so in its own words
        console.notify(tr("This user has no home folder (HOME), so nothing can be kept there."))
    try:
        code = _run_or_refuse(words)
        console.write("")  # flushes what argparse printed
    except KeyboardInterrupt as interrupted:
        # As a shell reports it: 130 for Ctrl-C, 143 for SIGTERM.
        code = 128 + getattr(interrupted, "number", 2)
        _say_interrupted(words)
    except BrokenPipeError:
        console.discard_output()  # the reader has ended
        command = next((word for word in words if word in BY_NAME), WINDOW)
        code = console.PARTIAL if command in _JUDGING else console.SUCCESS
    except console.OutputLost as error:
        console.discard_output()
        console.notify(tr("{file} cannot be written: {why}.", file="stdout", why=error))
        code = console.PARTIAL
    except Exception as error:  # noqa: BLE001  the top level: people get a sentence, no traceback
        code = _explain(words, error)
    return code


def _has_home() -> bool:
    """A container's user may have neither HOME nor an entry among the system's users; LOCK and all else go on."""
    try:
        return Path.home().is_absolute()
    except RuntimeError:
        return False


def _run_or_refuse(words: list[str]) -> int:
    console.set_verbosity(argparse.Namespace())
    console.expect_result()
    try:
        return _run(words)
    except SystemExit as end:  # from argparse, which printed the help
        return end.code if isinstance(end.code, int) else console.USAGE_ERROR
    except UserError as error:
        if error.code is ErrorCode.INTERRUPTED:
            return _explain(words, error)  # with what to do next
        return _fail(words, error.code, error.sentence, what=error.what, hint=error.hint)


def _fail(words: Sequence[str], code: ErrorCode, sentence: str, *, what: str = "", hint: str = "") -> int:
    """Say why there is no result, with --json also as an object; returns the exit code. `what`: the sentence without
    its hint, where it has one."""
    console.notify(sentence)
    if "--json" in words and not console.has_result():
        from app.cli.results import ErrorJson, FailureJson

        failure = FailureJson(code=code, message=what or sentence, hint=hint)
        console.write_lines([console.as_json(ErrorJson(error=failure))])
    return code.exit_code


def _run(words: list[str]) -> int:
    if words[:1] in (["-h"], ["--help"]):
        _whole_parser().print_help()
        return console.SUCCESS
    if words[:1] == ["--version"]:
        from app import version

        console.write_lines([f"DPS-S Configurator {version()}"])
        return console.SUCCESS
    leading = list(takewhile(lambda word: word in _ANYWHERE, words))
    if words[len(leading) : len(leading) + 1] and words[len(leading)] in BY_NAME:  # dps-s -v read
        words = [words[len(leading)], *leading, *words[len(leading) + 1 :]]
    if not words or words[0].startswith("-") or is_file_name(words[0]):
        words = [WINDOW, *words]
    entry = BY_NAME.get(words[0])
    if entry is None:
        raise console.Refused(_why_no_command(words[0]))
    args = entry.parse_words(words[1:])
    console.set_verbosity(args)
    is_window = entry.name == WINDOW
    _prepare_log(is_wanted=is_window and console.verbosity() > 0, is_window=is_window)
    is_open = getattr(args, "port", "") is None and getattr(args, "other", None) is None
    is_done = getattr(args, "yes", True) or getattr(args, "activate", None) is False  # else refused, whatever the port
    if not is_window and is_open and is_done:
        args.port = _choose_port()
    port = getattr(args, "port", None) or ()
    ports = (port,) if isinstance(port, str) else port
    for address in ports:
        _refuse_unknown_address(address)
    if is_window:
        args.open_window = _open_window
        return entry.run(args)
    if getattr(args, "json", False):
        _write_utf8()
    args.printer = _print_pages
    if entry.name != "lock":  # which waits for no file
        say_left_active(ports, getattr(args, "module", None) or "")
    return entry.run(args)


def _choose_port() -> str:
    """Choose and print the port. Raises `Refused`."""
    from app.engine.ports import list_ports

    named = os.environ.get(PORT, "").strip()
    if named:
        console.note(tr("Port {port} ({name})", port=named, name=PORT))
        return named
    try:
        adapters = [port for port in list_ports() if port.vid is not None]
    except UserError as error:
        raise console.Refused(error.message, ErrorCode.NO_PORT) from error
    if not adapters:
        raise console.Refused(tr("There is no USB adapter. Plug it in, or give --port."), ErrorCode.NO_PORT)
    if len(adapters) > 1:
        names = join_names(port.device for port in adapters)
        raise console.Refused(tr("There are several adapters: {names}. Give --port.", names=names))
    adapter = adapters[0]
    console.note(tr("Port {port} ({name})", port=adapter.device, name=adapter.description or adapter.identity))
    return adapter.device


def _refuse_unknown_address(port: str) -> None:
    """Raises `Refused` for a URL that no port is opened by, such as that of a file."""
    if "://" not in port:
        return
    from app.diagnosis.causes import explain
    from app.engine.transport import PortError, refuse_unsupported

    try:
        refuse_unsupported(port)
    except PortError as error:
        raise console.Refused(explain(error).terminal_sentence) from error


def _why_no_command(word: str) -> str:
    if word == "deploy":
        return tr("Deploying is possible in the window only.")
    named = tr("There is no command {name}.", name=word + console.did_you_mean(word, BY_NAME))
    return "\n".join((named, tr("Help: {command}", command="dps-s -h")))


def _whole_parser() -> Parser:
    """A parser whose help lists all commands in their groups, without importing them."""
    about = "Configures, tests and watches a DPS-S parachute module."
    parser = Parser(prog="dps-s", formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.description = f"{about}\n\n{grouped_summaries()}"
    parser.usage = "dps-s [COMMAND] … | dps-s FILE"  # without a command the window opens
    parser.epilog = (
        "Help on a command: dps-s COMMAND -h\n"
        "Exit code: 0 done; 1 the answer is no; 2 usage error; 3 no link; 4 done in part; 130, 143 interrupted."
    )
    parser.add_argument("--version", action="store_true")
    return parser


def _open_window(args: argparse.Namespace) -> int:
    """Passed to the command, which does not import Qt."""
    from ui.main import WindowOptions, run

    return run(
        WindowOptions(
            port=args.port,
            baud_rate=args.baud,
            demo=args.demo,
            language=args.lang,
            offscreen_seconds=args.offscreen_seconds,
            evidence=args.evidence,
            file=args.file,
        )
    )


def _print_pages(bodies: Sequence[str], paper: "Paper", attachment: bytes | None) -> bytes:
    """Passed to the command, which does not import Qt."""
    from app.terminal.interruption import Interruption

    with Interruption() as interruption:
        interruption.ignore_from_now()  # an exception in the middle of Qt, or of its import, aborts the process
        from ui.files.report_printer import print_pages

        return print_pages(bodies, paper, attachment)


def _prepare_output() -> None:
    _replace_closed_streams()
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")  # "?" for characters that the console lacks
            if sys.platform == "win32" and not stream.isatty() and "PYTHONIOENCODING" not in os.environ:
                stream.reconfigure(encoding="utf-8")  # the ANSI code page lacks "…" in one country and "°" in another


def _replace_closed_streams() -> None:
    """Else the port or a file would get the number of the closed stream, and what is written there. Python replaces a
    closed standard error by standard output."""
    # The null device opened for reading cannot be written, as a closed output.
    for name, mode, flags in (
        ("stdin", "r", os.O_RDONLY), ("stdout", "w", os.O_RDONLY), ("stderr", "w", os.O_WRONLY),
    ):  # fmt: skip
        if getattr(sys, name) is None and sys.platform != "win32":  # there windowed programs have none
            number = os.open(os.devnull, flags)  # the lowest free one, which is the stream's
            os.set_inheritable(number, True)
            setattr(sys, name, open(number, mode, encoding="utf-8", closefd=False))  # noqa: SIM115


def _write_utf8() -> None:
    """JSON is always UTF-8; bytes of a file name that are not are written as JSON escapes."""
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(encoding="utf-8", errors="backslashreplace")


def _prepare_log(*, is_wanted: bool, is_window: bool) -> None:
    """Commands log on request only; the window configures its own log."""
    if is_wanted or os.environ.get(DEBUG) == "1":
        logging.basicConfig(level=logging.DEBUG)
    elif not is_window:
        logging.getLogger().addHandler(logging.NullHandler())  # else Python prints warnings and tracebacks


def _say_interrupted(words: Sequence[str]) -> None:
    """Only where an object is expected: who pressed Ctrl-C knows."""
    if "--json" not in words or console.has_result():
        return
    from app.terminal.interruption import print_after_signal

    with print_after_signal():
        _fail(words, ErrorCode.CANCELLED, tr("Interrupted."))


def _code_of(error: "PortError") -> ErrorCode:
    from app.engine.transport import PortTrouble

    match error.trouble:
        case PortTrouble.MISSING | PortTrouble.UNUSABLE:
            return ErrorCode.NO_PORT
        case PortTrouble.BUSY:
            return ErrorCode.BUSY
        case PortTrouble.NOT_ALLOWED:
            return ErrorCode.NO_PERMISSION
        case PortTrouble.UNSUPPORTED:
            return ErrorCode.USAGE
        case _:
            return ErrorCode.NO_LINK


def _explain(words: Sequence[str], error: Exception) -> int:
    if os.environ.get(DEBUG) == "1":
        import traceback

        traceback.print_exception(error)
    if isinstance(error, ImportError):
        sentence = _why_not_loaded(error)
        if sentence is not None:
            return _fail(words, ErrorCode.INTERNAL, sentence)
    from app.diagnosis.causes import explain
    from app.engine.transport import PortError

    explanation = explain(error)
    code = error.code if isinstance(error, UserError) else ErrorCode.INTERNAL
    if isinstance(error, PortError):
        code = _code_of(error)
    return _fail(words, code, explanation.terminal_sentence, what=explanation.what, hint=explanation.next_step)


def _why_not_loaded(error: ImportError) -> str | None:
    """A sentence on the system's libraries or the package that is missing; None where a part of the program is."""
    from app.system.screen import missing_libraries

    package = (error.name or "").partition(".")[0]
    if isinstance(error, ModuleNotFoundError) and package not in ("", "app", "protocol", "ui"):
        return tr("The Python package {package} is missing. Install the program again.", package=package)
    return missing_libraries()


if __name__ == "__main__":
    sys.exit(main())
