"""Many simulated modules in one process, each on a pseudo-terminal.

    python -m tests.benchmarks.window.fleet_modules FOLDER COUNT RATE_HZ

Prints "ready", then executes lines from standard input with one answer each: "counts"
(streamed frames of each, as JSON),
"locked" (which are locked), "NUMBER LINE" (a control line of `dps-s simulate` for one). Ends with its input.
"""

import json
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from app.simulator.bench import SimulatedBench
from app.simulator.control_lines import execute
from app.simulator.options import parse_options, setup_from
from app.simulator.servers.endpoint import Loop
from app.simulator.servers.pty_server import PtyEndpoint
from app.text.user_error import UserError
from tests.support.processes import ENVIRONMENT, ROOT

FIRST_TILT = 5
"""Module number N has this tilt plus N, so that its tilt identifies it."""


def port_of(folder: Path, number: int) -> str:
    return str(folder / f"module{number:02}")


class ManyModules:
    """Controls such a process."""

    def __init__(self, process: "subprocess.Popen[str]", folder: Path, count: int) -> None:
        self._process = process
        self.ports = [port_of(folder, number) for number in range(count)]
        if self._read() != "ready":
            raise RuntimeError("the simulated modules did not start")

    def tell(self, line: str) -> str:
        if self._process.stdin is None:
            raise RuntimeError("no input to write")
        self._process.stdin.write(line + "\n")
        self._process.stdin.flush()
        return self._read()

    @property
    def counts(self) -> list[int]:
        """Streamed status frames of each."""
        found: list[int] = json.loads(self.tell("counts"))
        return found

    @property
    def locked(self) -> list[bool]:
        found: list[bool] = json.loads(self.tell("locked"))
        return found

    def _read(self) -> str:
        if self._process.stdout is None:
            raise RuntimeError("no output to read")
        return self._process.stdout.readline().strip()


@contextmanager
def many_modules(folder: Path, count: int, rate_hz: int) -> Iterator[ManyModules]:
    """They end with the block."""
    with subprocess.Popen(
        [sys.executable, "-m", "tests.benchmarks.window.fleet_modules", str(folder), str(count), str(rate_hz)],
        cwd=ROOT, env=ENVIRONMENT, text=True, stdin=subprocess.PIPE, stdout=subprocess.PIPE,
    ) as process:  # fmt: skip
        try:
            yield ManyModules(process, folder, count)
        finally:
            process.communicate(timeout=20)


class _Module:
    def __init__(self, folder: Path, number: int, rate_hz: int) -> None:
        options = (("rate", str(rate_hz)), ("tilt", str(FIRST_TILT + number)), ("boots", str(number + 1)))
        self.bench = SimulatedBench(setup_from(parse_options(options)))
        ready = threading.Event()
        endpoint = PtyEndpoint(Path(port_of(folder, number)), baud_rate=self.bench.module.baud_rate)
        self.loop = Loop(self.bench, endpoint, announce=lambda _: ready.set())
        self._thread = threading.Thread(target=self.loop.run, name=f"simulated module {number}")
        self._thread.start()
        ready.wait(10)

    def obey(self, line: str) -> str:
        try:
            return execute(self.bench, line).replace("\n", " ")
        except UserError as error:
            return f"refused: {error}"
        finally:
            self.loop.wake()

    def stop(self) -> None:
        self.loop.stop()
        self._thread.join(5)


def _answer(modules: list[_Module], line: str) -> str:
    if line == "counts":
        return json.dumps([one.bench.module.stream_frames_sent for one in modules])
    if line == "locked":
        return json.dumps([not one.bench.module.state.is_active for one in modules])
    number, _, rest = line.partition(" ")
    return modules[int(number)].obey(rest) or "done"


def main(words: list[str]) -> int:
    """Serve until the input ends."""
    folder, count, rate_hz = Path(words[0]), int(words[1]), int(words[2])
    modules = [_Module(folder, number, rate_hz) for number in range(count)]
    print("ready", flush=True)
    for line in sys.stdin:
        print(_answer(modules, line.strip()), flush=True)
    for one in modules:
        one.stop()
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
