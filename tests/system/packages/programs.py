"""Installed `dps-s`, started without this checkout in its environment."""

import json
import os
import subprocess
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[3]
LONGEST_S = 120.0
_SYSTEMS_OWN = ("SYSTEMROOT", "TEMP", "TMP", "COMSPEC", "PATHEXT")
"""Required by every program on Windows."""
PNG = b"\x89PNG\r\n\x1a\n"
WINDOW_S = 10
"""How long the window runs. It connects after one second; the first start of a fresh Python takes longer."""


@dataclass(frozen=True, slots=True)
class Program:
    """`words`: the command; `home`: empty at first."""

    words: Sequence[str]
    home: Path

    def environment(self) -> dict[str, str]:
        self.home.mkdir(exist_ok=True)
        own = {name: os.environ[name] for name in _SYSTEMS_OWN if name in os.environ}
        return own | {
            "PATH": os.defpath,
            "HOME": str(self.home),
            "USERPROFILE": str(self.home),
            "APPDATA": str(self.home),
            "LOCALAPPDATA": str(self.home),
            "LC_ALL": "C.UTF-8",
            "QT_QPA_PLATFORM": "offscreen",
        }

    def run(self, *words: str, **variables: str | None) -> "subprocess.CompletedProcess[str]":
        """Run to the end in an empty folder; variables that are None are removed."""
        wanted = {**self.environment(), **variables}
        return subprocess.run(
            [*self.words, *words],
            cwd=self.home,
            env={name: value for name, value in wanted.items() if value is not None},
            stdin=subprocess.DEVNULL,
            capture_output=True,
            encoding="utf-8",
            timeout=LONGEST_S,
            check=False,
        )

    def json(self, *words: str) -> dict[str, Any]:
        """Its output; asserts exit code 0."""
        done = self.run(*words)
        assert done.returncode == 0, done.stderr
        said: dict[str, Any] = json.loads(done.stdout)
        return said


@contextmanager
def simulated(program: Program, *options: str) -> Iterator[str]:
    """The port of a simulated module in another process."""
    words = [*program.words, "simulate", "--tcp", "127.0.0.1:0", *options]
    with subprocess.Popen(
        words, cwd=ROOT, env=program.environment(), text=True, stdin=subprocess.PIPE, stdout=subprocess.PIPE
    ) as process:
        try:
            assert process.stdout is not None
            port = process.stdout.readline().strip()
            assert port.startswith("socket://"), "the simulated module did not start"
            yield port
        finally:
            process.kill()


def check_window(program: Program, evidence: Path) -> None:
    """The window opens, connects to the simulated module and shows values: its exit code says that they are fresh."""
    done = program.run("gui", "--demo", "--offscreen-seconds", str(WINDOW_S), "--evidence", str(evidence))
    assert done.returncode == 0, done.stderr
    picture = (evidence / "live.png").read_bytes()
    assert picture.startswith(PNG)
    assert len(picture) > 20_000, "an empty window is smaller"


def check_reading(program: Program) -> None:
    """One process reads the module simulated by another."""
    with simulated(program, "--history", "2") as port:
        said = program.json("read", "--port", port, "--json")
        records = program.json("history", "--port", port, "--json")
    assert said["errors"] == {}
    assert said["link"]["port"] == port
    assert said["settings"]["attitude_threshold_deg"] == 60
    assert said["status"]["triggered"] is False
    assert len(records["records"]) == 2


def leave_a_record(program: Program, module: str) -> None:
    """A pre-flight check under the module's name, which the store keeps."""
    done = program.run("preflight", "--port", "sim://", "--module", module)
    assert done.returncode in (0, 1), done.stderr


def has_record(program: Program, module: str) -> bool:
    """Whether the store still knows the check."""
    said = program.json("archive", "report", "--json")
    return any(one["module"] == module and one["checks"] == 1 for one in said["modules"])
