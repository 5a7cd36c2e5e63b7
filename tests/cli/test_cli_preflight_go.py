"""`dps-s preflight`: READY and GO only in the connection in which the triggers were enabled."""

from collections.abc import Callable
from contextlib import closing

import pytest

from app.safety.journal import Act, Outcome
from app.simulator.bench import SimulatedBench
from app.store.fact_store import Store
from app.system.files import data_folder
from protocol.catalogue import ACTIVATION, Request
from protocol.messages import decode_request
from tests.support.cli_line import Program, bench_of
from tests.support.line.frames import at_each_frame
from tests.support.records.stored import audit, checks_of, open_store

pytest_plugins = ["tests.support.cli_fixtures"]
pytestmark = pytest.mark.usefixtures("speaks_english", "no_waiting")


ACTIVATE = ("preflight", "--activate", "--yes", "--module", "M-07")


def _sets(wire: list[bytes]) -> list[str]:
    """What was sent besides questions, in order."""
    requests = [decode_request(raw) for raw in wire]
    return [request.command.name for request in requests if not request.is_repeatable]


@pytest.mark.promise("f")
def test_activate_leads_in_one_connection_to_go(port: str, dps_s: Program, wire: list[bytes]) -> None:
    printed = dps_s([*ACTIVATE, "--port", port])
    assert printed.out.startswith("GO: fit to fly\n")
    assert "ACTIVE" in printed.err
    assert _sets(wire) == ["freefall_trigger", "attitude_trigger", "activation"]
    assert bench_of(port).module.state.is_active
    with closing(open_store()) as store:
        kept = [check.verdict for check in checks_of(store, "M-07")]
        last = audit(store)[0]
    assert kept == ["GO", "READY"]
    assert (last.act, last.outcome) == (Act.ACTIVATE, Outcome.CONFIRMED)


def _disable_light(port: str) -> None:
    bench_of(port).set_world(bay_is_open=True)


def _activate(port: str) -> None:
    bench_of(port).module.activate(is_active=True)


@pytest.mark.parametrize("arrange", [_disable_light, _activate])
@pytest.mark.promise("f")
def test_what_is_not_ready_is_not_activated(
    port: str, dps_s: Program, wire: list[bytes], arrange: Callable[[str], None]
) -> None:
    arrange(port)
    assert dps_s([*ACTIVATE, "--port", port], 1).out.startswith("NO-GO")
    assert "activation" not in _sets(wire)


def _restart(bench: SimulatedBench) -> None:
    bench.module.memory.boot_count -= 1
    bench.restart()
    bench.module.activate(is_active=True)


def _move(bench: SimulatedBench) -> None:
    bench.module.memory.attitude_threshold = 70


def _lose(bench: SimulatedBench) -> None:
    bench.module.activate(is_active=False)


@pytest.mark.parametrize("act", [_restart, _move, _lose])
@pytest.mark.promise("f")
def test_what_happens_at_the_activation_is_no_go_and_it_is_sent_once(
    port: str, dps_s: Program, wire: list[bytes], act: Callable[[SimulatedBench], None]
) -> None:
    bench, due_s = bench_of(port), list[float]()

    def happen(request: Request) -> None:
        if due_s and bench.clock() >= due_s[0]:
            due_s.clear()
            act(bench)
        if request.command is ACTIVATION:
            due_s.append(bench.clock() + 0.1)

    at_each_frame(bench, happen)
    assert dps_s([*ACTIVATE, "--port", port], 1).out.startswith("NO-GO")
    assert wire.count(ACTIVATION.set(True).encode()) == 1


def test_without_an_audit_log_it_is_ready_and_not_activated(port: str, dps_s: Program, wire: list[bytes]) -> None:
    data_folder().parent.mkdir(parents=True)
    data_folder().write_bytes(b"")  # a file where the folder should be
    printed = dps_s([*ACTIVATE, "--port", port], 1)
    assert printed.out.startswith("READY")
    assert "Nothing was sent" in printed.err
    assert "activation" not in _sets(wire)


def test_an_audit_log_that_is_not_written_in_time_is_said(
    port: str, dps_s: Program, monkeypatch: pytest.MonkeyPatch
) -> None:
    close = Store.close
    monkeypatch.setattr(Store, "close", lambda store, *limit: not close(store, *limit))
    assert "The audit log is incomplete." in dps_s([*ACTIVATE, "--port", port]).err
