"""`dps-s` in this process, at independent modules and in virtual time: nobody waits, and no busy machine interferes."""

import io
import os
import sys
import time
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from concurrent.futures import wait as wait_for
from contextlib import ExitStack, contextmanager
from typing import Any, Final
from unittest.mock import patch

import app.__main__ as program
from app.cli.commands import ENTRIES
from app.engine import transport
from app.engine.transport import Line
from app.port_urls.protocol_sim import open_bench
from app.simulator.bench import SimulatedBench
from app.store.fact_store import Facts, Store
from app.system import clock
from app.terminal import connection
from app.terminal.connection import OpenPort
from tests.hardware.conftest import Ran
from tests.module.module import Module
from tests.module.options import Options
from tests.support.line.module_line import ModuleLine
from tests.support.line.sim_line import FakeClock, SimulatedLine, ThreadlessWorker
from tests.support.patience import PATIENCE_S

PORT: Final = "/dev/ttyUSB9"
WAIT_S: Final = 0.1  # as the command line waits for a batch
IDLE_S: Final = 0.001  # while nothing is done on the line: something else is waited for
BETWEEN_S: Final = 0.5  # from one command to the next


class VirtualCli:
    """One command after the other, at the modules on one line; `line` is that of the last one."""

    line: ModuleLine
    _err: "io.TextIOWrapper[io.BytesIO]"

    def __init__(self, *options: Options) -> None:
        self.clock = FakeClock()
        self._simulated: dict[str, SimulatedBench] = {}
        self.served: dict[str, SimulatedBench] = {}  # by port
        self.modules = [
            Module(each, name=f"{number}", seed=number, now=self.clock.now_s)
            for number, each in enumerate(options or (Options(),), 1)
        ]

    @property
    def module(self) -> Module:
        return self.modules[0]

    @contextmanager
    def in_time(self, meanwhile: Callable[[], object] | None = None) -> Iterator[None]:
        """Whatever opens `PORT` in here is at the modules, and this clock is its clock."""
        planned = [] if meanwhile is None else [meanwhile]

        def open_line(name: str, baud_rate: int) -> Line:
            if name in self.served or name.startswith("sim:"):
                return SimulatedLine(self.clock, self.served.get(name) or open_bench(name), baud_rate, port=name)
            if name != PORT:
                return really_open(name, baud_rate)
            self.line = ModuleLine(self.clock, *self.modules, baud_rate=baud_rate)
            while planned:
                self.line.plan(0.0, planned.pop())
            return self.line

        def wait(opened: OpenPort) -> None:
            vars(connection)["check_signals"]()  # a test may have put another one there
            worker = opened.worker
            assert isinstance(worker, ThreadlessWorker)
            session = worker._session
            is_idle = session is not None and not session.is_busy
            if is_idle:
                time.sleep(IDLE_S)
            ends_s = self.clock.now_s + (IDLE_S if is_idle else WAIT_S)
            while opened._batches.empty() and self.clock.now_s < ends_s:
                if not worker.turn():
                    self.clock.now_s = ends_s
            if not opened._batches.empty():
                opened._receive(opened._batches.get_nowait())
            vars(connection)["check_signals"]()  # a test may have put another one there

        def write(store: Store, work: Callable[[Facts], Any]) -> "Future[Any]":
            """While the disk is at work no time passes."""
            writing = written(store, work)
            wait_for([writing], PATIENCE_S)
            return writing

        def make_worker(callback: Any, make_lock: Any = None) -> ThreadlessWorker:
            return ThreadlessWorker(callback, self.clock, make_lock)

        written, really_open = Store.write, transport.open_line
        for entry in ENTRIES:
            entry.load()  # so that none of them keeps this clock
        steady = clock.steady_time
        with ExitStack() as stack:
            for module in list(sys.modules.values()):
                # Not where it is defined: what is imported in here would keep this clock.
                if module is not clock and getattr(module, "steady_time", None) is steady:
                    stack.enter_context(patch.object(module, "steady_time", self.clock))
            for what in (
                patch.object(OpenPort, "wait", wait),
                patch("app.simulator.bench._benches", self._simulated),
                patch.dict(SimulatedBench.__init__.__kwdefaults__ or {}, clock=self.clock),
                patch("app.engine.worker.open_line", open_line),
                patch.object(Store, "write", write),
                patch("app.terminal.connection.Worker", make_worker),
            ):
                stack.enter_context(what)
            yield

    @property
    def told(self) -> str:
        """What was said on standard error until now."""
        return self._err.buffer.getvalue().decode()

    def run(
        self,
        *words: str,
        port: str = PORT,
        meanwhile: Callable[[], object] | None = None,
        **own: str,
    ) -> Ran:
        """`port`: "" for what has none, or has it among its words; at `sim://` is the simulated module. `meanwhile`
        happens once the port is open. `own`: variables of the environment."""
        out, self._err = (io.TextIOWrapper(io.BytesIO(), encoding="utf-8", write_through=True) for _ in range(2))
        with (
            self.in_time(meanwhile),
            patch.dict(os.environ, {"LC_ALL": "C.UTF-8", **own}),
            patch.object(sys, "stdout", out),
            patch.object(sys, "stderr", self._err),
        ):
            code = program.main([words[0], *(("--port", port) if port else ()), *words[1:]])
        self.clock.now_s += BETWEEN_S
        said = out.buffer.getvalue().decode()
        return Ran(code, said, self.told)
