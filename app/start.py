"""Starts `dps-s` where it was installed by pip, after checking that its packages are its own.

They are called `app`, `protocol` and `ui`. In a shared environment another program may have overwritten or removed
them: that is reported in one sentence instead of an ImportError.

Nothing is imported outside of a function, so that Ctrl-C during the imports ends the program without a traceback.
"""

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable

OURS = {"app": "__main__.py", "protocol": "translatable.py", "ui": "main.py"}
"""The packages, each with a file that it must contain."""
FOREIGN = 3
INTERRUPTED = 130


def main() -> int:
    """Run the program; returns the exit code."""
    return interruptible(_run)


def interruptible(run: "Callable[[], int]") -> int:
    """Run the program so that Ctrl-C prints no traceback, however early or late; returns the exit code."""
    try:
        return run()
    except KeyboardInterrupt:  # before the program handles it, or again while it does
        return INTERRUPTED
    finally:
        _interrupt_quietly()


def _run() -> int:
    import sys

    sentence = foreign_package()
    if sentence is not None:
        print(sentence, file=sys.stderr)
        return FOREIGN
    from app.__main__ import main as run

    return run()


def _interrupt_quietly() -> None:
    """Ctrl-C while the interpreter ends, which would print a traceback, ends it as it does any program."""
    import signal

    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, signal.SIG_DFL)


def foreign_package() -> str | None:
    """A sentence about a package that is not this program's, or None."""
    from importlib.util import find_spec
    from pathlib import Path

    import app

    top = Path(__file__).resolve().parents[1]
    for name, file in OURS.items():
        spec = find_spec(name)
        places = [] if spec is None else [Path(place) for place in spec.submodule_search_locations or ()]
        is_overwritten = name == "app" and not hasattr(app, "version")
        is_here = any(place.resolve() == top / name for place in places) and (top / name / file).is_file()
        if is_overwritten or not is_here:
            from app.text.i18n import set_language, system_language, tr

            set_language(system_language())
            place = places[0] if places else top / name
            return tr(
                "“{name}” in {place} is not this program's: install it with pipx or uv tool.", name=name, place=place
            )
    return None
