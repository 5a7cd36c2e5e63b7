"""Starts DPS-S Configurator where it was installed.

The program's packages are called `app`, `protocol` and `ui`, and other programs have packages of these names, too. The
name of this one is unique: it puts the folder with the three first, so that none on PYTHONPATH is taken for one of
them, and says in one sentence where another program has overwritten one.

Nothing is imported outside of a function, so that Ctrl-C during the imports ends the program without a traceback.
"""

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable

OURS = {"app": "__main__.py", "protocol": "catalogue.py", "ui": "main.py"}
"""The program's packages, each with a file that it must contain."""
INCOMPLETE = 1
INTERRUPTED = 130


def main() -> int:
    """Run `dps-s`; returns the exit code."""
    return _interruptible(_run)


def open_window() -> int:
    """Run `dps-s-window`, which Windows gives no console: what was printed is shown in a box if the program fails."""
    import sys

    if sys.stdout is not None:
        return main()
    import io

    output = io.StringIO()
    sys.stdout = sys.stderr = output
    code = main()
    if code and output.getvalue().strip():
        _show_error(output.getvalue().strip())
    return code


def _interruptible(run: "Callable[[], int]") -> int:
    """Run the program so that Ctrl-C prints no traceback, however early or late; returns the exit code."""
    try:
        return run()
    except KeyboardInterrupt:  # before the program handles it, or again while it does
        return INTERRUPTED
    finally:
        _interrupt_quietly()


def _interrupt_quietly() -> None:
    """Ctrl-C while the interpreter ends, which would print a traceback, ends it as it does any program."""
    import signal

    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, signal.SIG_DFL)


def _run() -> int:
    import sys

    trouble = _find_packages()
    if trouble is not None:
        print(trouble, file=sys.stderr)
        return INCOMPLETE
    from app.__main__ import main as run

    return run()


def _find_packages() -> str | None:
    """Put the folder of the program's packages first; returns a sentence where one of them is not this program's.

    It is English, as the translations lie in a package that may be another program's.
    """
    import sys
    from pathlib import Path

    if getattr(sys, "frozen", False):  # a bundle has no other packages
        return None
    here = Path(__file__).resolve()
    # In an installation they lie beside this package, in a checkout three folders above it.
    top = next((folder for folder in here.parents if (folder / "app" / OURS["app"]).is_file()), here.parents[1])
    sys.path.insert(0, str(top))
    taken = [name for name, file in OURS.items() if not (top / name / file).is_file()]
    if not taken:
        import app

        # Where another program was installed over this one, its `__init__.py` has replaced ours.
        taken = [] if hasattr(app, "version") else ["app"]
    if not taken:
        return None
    return f"“{taken[0]}” in {top / taken[0]} is not DPS-S Configurator's: install it with pipx or uv tool."


def _show_error(text: str) -> None:
    import sys

    if sys.platform == "win32":
        import ctypes

        icon_of_an_error = 0x10
        ctypes.windll.user32.MessageBoxW(None, text, "DPS-S Configurator", icon_of_an_error)
