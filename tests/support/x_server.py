"""A private X server for the tests that need real keys and a real mouse."""

import shutil
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager

NEED_AN_X_SERVER = {"tests/ui/lock": ("test_lock_under_x.py",)}
_PROGRAMS = ("Xvfb", "xdotool")


def has_x_server() -> bool:
    return all(map(shutil.which, _PROGRAMS))


def what_was_not_run() -> str | None:
    """Return the warning for the summary of a run, or None where the programs are installed."""
    if has_x_server():
        return None
    names = ", ".join(name for names in NEED_AN_X_SERVER.values() for name in names)
    missing = f"Xvfb or xdotool is not installed, so the tests with real keys WERE NOT RUN: {names}."
    return f"{missing} Type: sudo apt-get install xvfb xdotool"


def left_out(folder: str) -> list[str]:
    """Return the files to ignore in a folder of tests without these programs."""
    return [] if has_x_server() else list(NEED_AN_X_SERVER[folder])


@contextmanager
def x_server() -> Iterator[str]:
    """Run a server of its own; yields its DISPLAY."""
    command = ["Xvfb", "-displayfd", "1", "-screen", "0", "1366x768x24", "-nolisten", "tcp"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True) as server:
        try:
            assert server.stdout is not None
            yield f":{server.stdout.readline().strip()}"
        finally:
            server.terminate()
