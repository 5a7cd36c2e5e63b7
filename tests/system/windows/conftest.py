"""Uses the Windows prepared by packaging/windows/wine.py; without it nothing is collected."""

import contextlib
import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import pytest

from tests.support.processes import Running, run_module
from tests.support.setup_files import PACKAGING

WANTED = "DPS_S_UNDER_WINE"
collect_ignore_glob = [] if WANTED in os.environ else ["test_*.py"]
sys.path[1:1] = [str(PACKAGING), str(PACKAGING / "windows")]
PORT = "COM5"


@dataclass(frozen=True, slots=True)
class WindowsProgram:
    """A program run by Wine in a Windows folder."""

    words: tuple[str, ...]
    folder: Path = Path("/")
    prefix: Path | None = None
    variables: dict[str, str] = field(default_factory=dict)
    screen: tuple[str, ...] = ()
    """The command that gives it one."""

    def run(self, *words: str, limit_s: float = 120, **variables: str) -> "subprocess.CompletedProcess[str]":
        from wine import inside

        command = [*self.screen, "wine", *self.words, *words]
        own = {**self.variables, **variables}
        return inside(command, folder=self.folder, prefix=self.prefix, limit_s=limit_s, **own)

    def on_a_console(self, *words: str, code_page: int, limit_s: float = 120, **variables: str) -> str:
        """What a person sees: a terminal of Linux' is a console of this code page to Wine."""
        from wine import entered, environment

        command = f"chcp {code_page} & {' '.join((*self.words, *words))}"
        own = {**self.variables, **variables, "LC_CTYPE": "C.UTF-8", "TERM": "xterm"}
        ours, theirs = os.openpty()
        process = subprocess.Popen(
            entered(["timeout", f"{limit_s:.0f}", "wine", "cmd", "/c", command]),
            env=environment(self.prefix) | {"FOLDER": str(self.folder)} | own,
            stdin=theirs, stdout=theirs, stderr=theirs, start_new_session=True,
        )  # fmt: skip
        os.close(theirs)
        said = b""
        with contextlib.suppress(OSError), os.fdopen(ours, "rb", buffering=0) as terminal:  # an error is its end
            while part := terminal.read(65536):
                said += part
        process.wait(timeout=60)
        return said.decode()

    @contextmanager
    def running(self, *words: str, **variables: str) -> Iterator["subprocess.Popen[bytes]"]:
        """Start it; end it with all its processes when the block ends."""
        from wine import entered, environment, shut_down

        process = subprocess.Popen(
            entered([*self.screen, "wine", *self.words, *words]),
            env=environment(self.prefix) | {"FOLDER": str(self.folder)} | self.variables | variables,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
        )
        try:
            yield process
        finally:
            shut_down(self.prefix)
            process.communicate(timeout=60)


@pytest.fixture(scope="session")
def dps_s() -> Iterator[WindowsProgram]:
    """`dps-s` from the copy of the checkout, by the Python of Windows."""
    from wine import PYTHON, SOURCE, shut_down

    yield WindowsProgram((PYTHON, "-m", "app"), SOURCE)
    shut_down()


@pytest.fixture(scope="module")
def module() -> Iterator[Running]:
    """A simulated module, a Linux process, on COM5."""
    from wine import connect_com_port

    with run_module("--history", "3", "--cell", "4.1") as running:
        connect_com_port(5, Path(running.port))
        yield running
