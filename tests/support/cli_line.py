"""Helpers for tests of the command line: printed output, the module behind a port, and faults at a given frame."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager

import pytest

import app.__main__ as program
from app.port_urls.protocol_sim import open_bench
from app.simulator import bench as benches
from protocol.messages import decode_request
from tests.support.line.frames import at_frame


def bench_of(port: str) -> benches.SimulatedBench:
    return open_bench(port)


class Printed:
    def __init__(self, capsys: pytest.CaptureFixture[str]) -> None:
        self.out, self.err = capsys.readouterr()


def run_here(capsys: pytest.CaptureFixture[str], words: Sequence[str], code: int = 0) -> Printed:
    """Run `dps-s` in this process, and check its exit code."""
    found, printed = program.main(words), Printed(capsys)
    assert found == code, printed.err
    return printed


def faults(name: str, value: object) -> list[str]:
    """Where JSON is not as the published schema of this name says."""
    from jsonschema import Draft202012Validator  # 4 MB, only where it is used

    from app.cli.schema import schema_of

    if isinstance(value, dict) and value.keys() == {"error"}:
        name = "error"
    validator = Draft202012Validator(schema_of(name), format_checker=Draft202012Validator.FORMAT_CHECKER)
    return [f"{error.json_path}: {error.message}" for error in validator.iter_errors(value)]


def sets(wire: Sequence[bytes]) -> list[str]:
    """What was sent besides questions, in order."""
    return [request.command.name for request in map(decode_request, wire) if not request.is_repeatable]


Program = Callable[..., Printed]
"""`run_here`, as a fixture gives it: called with the words and the exit code."""


@contextmanager
def falls_after(bench: benches.SimulatedBench, number: int, act: Callable[[], object]) -> Iterator[None]:
    """Call `act` in place of delivering the `number`-th frame that the host sends."""
    end = at_frame(bench, number, act, is_lost=True)
    try:
        yield
    finally:
        end()


GAP_S = 0.5
"""While the cable is in nobody's hands; a query is repeated for a second."""


def exchange(bench: benches.SimulatedBench, **memory: int) -> None:
    """Another module takes its place."""
    bench.change(mute=True)
    for name, value in {"boot_count": 90, "attitude_threshold": 85, **memory}.items():
        setattr(bench.module.memory, name, value)
    read, ends_s = bench.wire.read, bench.clock() + GAP_S

    def heard(now_s: float) -> bytes:
        if now_s >= ends_s:
            bench.change(mute=False)
            bench.wire.read = read  # type: ignore[method-assign]
        return read(now_s)

    bench.wire.read = heard  # type: ignore[method-assign]
