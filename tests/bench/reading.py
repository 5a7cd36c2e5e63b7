"""Reading everything through the worker, compared with the same queries by bare pyserial on the same port; and
`dps-s read` as a process, compared with a script of seven lines with bare pyserial."""

import statistics
import sys
import time
from threading import Event
from typing import Final

import serial

from app.engine.procedure import Job
from app.engine.worker import Worker
from app.procedures.read import READABLE, read_everything
from tests.bench.kit import Figure
from tests.support.processes import PROGRAM, ran, run_module

AIM: Final = 1.3
PROCESS_AIM: Final = 3.0
BAUD_RATE: Final = 115200
_LIMIT_S: Final = 5.0
_SCRIPT: Final = """\
import sys, serial
with serial.Serial(sys.argv[1], 115200, timeout=1) as line:
    for words in sys.argv[2:]:
        query, length = words.split(":")
        line.write(bytes.fromhex(query))
        if len(line.read(int(length))) != int(length):
            sys.exit("no answer")
"""


def _bare_s(port: str, rounds: int) -> list[float]:
    """Seconds of the bare exchanges, all queries in turn."""
    took = []
    with serial.Serial(port, BAUD_RATE, timeout=1) as line:
        for _ in range(rounds):
            began = time.perf_counter()
            for command in READABLE:
                line.write(command.query().encode())
                assert len(line.read(command.layout.value)) == command.layout.value, command.name
            took.append(time.perf_counter() - began)
    return took


def _worker_s(port: str, rounds: int) -> list[float]:
    """Seconds from the call to the result."""
    took = []
    has_begun = Event()
    worker = Worker(lambda batch: has_begun.set() if batch.conversation.is_going else None)
    worker.start()
    try:
        worker.open(port, BAUD_RATE)
        assert has_begun.wait(_LIMIT_S), "no module answers"
        for _ in range(rounds + 1):
            began = time.perf_counter()
            job = worker.submit(Job(read_everything(), conversation=1))
            assert job.wait(_LIMIT_S), "not everything was answered"
            assert not job.outcome().errors
            took.append(time.perf_counter() - began)
    finally:
        worker.stop()
    return took[1:]  # the first one includes opening the port


def _process_s(*words: str) -> float:
    """Seconds of a process from start to end."""
    began = time.perf_counter()
    ran(*words).check_returncode()
    return time.perf_counter() - began


def reading(rounds: int = 8, turns: int = 4, processes: int = 12) -> list[Figure]:
    """By turns, so that other load affects both alike."""
    took: dict[str, list[float]] = {"ours": [], "bare": [], "script": [], "program": []}
    with run_module() as module:
        for _ in range(turns):
            took["bare"] += _bare_s(module.port, rounds)
            took["ours"] += _worker_s(module.port, rounds)
        questions = [f"{one.query().encode().hex()}:{one.layout.value}" for one in READABLE]
        for _ in range(processes):
            took["script"].append(_process_s(sys.executable, "-c", _SCRIPT, module.port, *questions))
            took["program"].append(_process_s(*PROGRAM, "read", "--port", module.port))
    ours, bare, script, program = (statistics.median(one) * 1000 for one in took.values())
    return [
        Figure(
            f"reading everything ({len(READABLE)} questions) against bare exchanges",
            f"{ours / bare:.2f} x ({ours:.1f} ms, bare {bare:.1f} ms)",
            f"<= {AIM} x",
            ours <= AIM * bare,
        ),
        Figure(
            "dps-s read as a whole process against the script",
            f"{program / script:.2f} x ({program:.0f} ms, script {script:.0f} ms)",
            f"<= {PROCESS_AIM:g} x",
            program <= PROCESS_AIM * script,
        ),
    ]
