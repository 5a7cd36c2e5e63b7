"""The conversation ends in the middle of a command: it says so, and sends nothing to whoever answers next."""

import json
import signal
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest

from app.engine.conversation import Interrupted
from app.modules.names import modules
from app.port_urls.protocol_sim import open_bench
from app.procedures.history import read_history
from app.records.filing import Filed, file_check
from app.safety.journal import Act, Outcome
from app.simulator.bench import SimulatedBench
from app.simulator.setup import Setup
from app.terminal.connection import connected
from protocol.catalogue import BY_NAME, STATUS
from tests.support.cli_line import Program, faults, sets
from tests.support.line.frames import at_frame, lose
from tests.support.records.stored import audit, open_store

pytest_plugins = ["tests.support.cli_fixtures"]
pytestmark = pytest.mark.usefixtures("speaks_english", "user_files", "no_waiting")

End = Callable[[SimulatedBench], object]


def exchange(bench: SimulatedBench) -> None:
    """Another module takes its place; meanwhile the cable is in nobody's hands. A query is repeated for longer."""
    bench.change(mute=True)
    bench.module.memory.boot_count, bench.module.memory.attitude_threshold = 90, 85
    bench.module.plan(bench.clock() + 0.5, lambda _at_s: bench.change(mute=False))


ENDS: dict[str, tuple[End, str]] = {
    "silent": (exchange, "The module was silent for a moment."),
    "restarted": (lambda bench: bench.restart(), "The module restarted."),
    "unplugged": (lambda bench: bench.unplug(), "The port was lost."),
}
"""What happens, and how the reason is said. After the silence another module answers."""


def at(bench: SimulatedBench, name: str, act: End, *, number: int = 1) -> None:
    """`act` happens in place of delivering the `number`-th frame of this command."""
    at_frame(bench, number, lambda: act(bench), code=BY_NAME[name].code, is_lost=True)


@pytest.mark.parametrize("end", ENDS)
@pytest.mark.parametrize(
    ("words", "name", "code"),
    [
        ("read", "light", 3),
        ("history", "trigger_records", 3),
        ("save FILE", "freefall_time", 3),
        ("set freefall_time_s=1.4 --dry-run", "freefall_time", 3),
        ("set freefall_time_s=1.4", "active", 3),
        ("set baud_rate=57600", "active", 1),
        ("activate --yes", "active", 3),
        ("zero --yes", "active", 3),
        ("shutdown --yes", "active", 3),
        ("preflight --enable-triggers", "cell_voltage", 1),
    ],
)
@pytest.mark.promise("a")
def test_each_command_says_why_and_sends_nothing_more(
    words: str, name: str, code: int, end: str, port: str, dps_s: Program, wire: list[bytes], tmp_path: Path
) -> None:
    act, reason = ENDS[end]
    at(open_bench(port), name, act)
    typed = [str(tmp_path / "a.toml") if word == "FILE" else word for word in words.split()]
    # The change of the rate is a job of the port, and ends with that only; nothing was sent by then.
    printed = dps_s([*typed, "--port", port], 3 if (name, end) == ("active", "unplugged") else code)
    # A port that was lost is named where nothing else is to be told; the next rate is looked for on the old line, too.
    reasons = (reason, f"{port} was unplugged") if end == "unplugged" else (reason, "57600: NOT verified")
    assert any(one in printed.out + printed.err for one in reasons)
    assert set(sets(wire)) <= {"freefall_trigger", "attitude_trigger"}, "the check sets them before"
    assert not (tmp_path / "a.toml").exists()


@pytest.mark.parametrize("end", ENDS)
def test_what_was_read_before_the_end_is_printed_with_the_reason(end: str, port: str, dps_s: Program) -> None:
    act, reason = ENDS[end]
    at(open_bench(port), "light", act)
    printed = dps_s(["read", "--port", port, "--json"], 3)
    shown = json.loads(printed.out)
    assert faults("read", shown) == []
    assert (shown["status"]["acceleration_g"], shown["boot_count"], shown["light_v"]) == (1.0, None, None)
    assert shown["errors"]["light_v"] == shown["errors"]["link"] == reason
    assert printed.err == f"{reason}\n"


def test_what_30_and_31_say_is_unknown_where_the_status_does_not_confirm_it(port: str, dps_s: Program) -> None:
    at(open_bench(port), "status", lambda bench: bench.restart())
    shown = json.loads(dps_s(["read", "--port", f"{port}?active=yes", "--json"], 3).out)
    assert set(shown["status"].values()) == {None}


@pytest.mark.parametrize("end", ENDS)
@pytest.mark.promise("f")
def test_the_set_in_flight_is_unknown_and_what_was_verified_was_verified_then(
    end: str, port: str, dps_s: Program
) -> None:
    act, reason = ENDS[end]
    at(open_bench(port), "light_threshold", act, number=2)  # after the reading of all: the set itself
    words = ["set", "freefall_time_s=1.2", "light_threshold_v=2", "attitude_threshold_deg=65", "baud_rate=57600"]
    told = json.loads(dps_s([*words, "--port", port, "--json"], 1).out)
    assert faults("set", told) == []
    errors = {name: result["error"] for name, result in told["results"].items()}
    assert errors["freefall_time_s"] == "verified then, before the interruption"
    assert errors["light_threshold_v"] == f"unknown: {reason}"
    assert errors["attitude_threshold_deg"] == errors["baud_rate"] == f"not sent: {reason}"
    assert not any(result["verified"] for result in told["results"].values())


@pytest.mark.parametrize("words", ["activate", "preflight --activate --records-reviewed"])
@pytest.mark.parametrize("end", ["silent", "restarted"])
@pytest.mark.promise("l")
def test_an_activation_that_was_interrupted_is_followed_by_lock(
    end: str, words: str, port: str, dps_s: Program, wire: list[bytes]
) -> None:
    act, reason = ENDS[end]
    bench = open_bench(port)
    # At the first report after the activation.
    at_frame(bench, 1, lambda: at(bench, "active", act), code=BY_NAME["activation"].code)
    printed = dps_s([*words.split(), "--port", port, "--yes"], 1)
    assert [name for name in sets(wire) if "trigger" not in name] == ["activation", "activation"]
    assert wire[-1][2] != BY_NAME["activation"].code, "LOCK is confirmed by reports"
    assert not bench.module.state.is_active
    assert "LOCK was sent after the interruption. The module that answers now reports LOCKED." in printed.err
    assert f"Sent, not confirmed: treat the module as ACTIVE. {reason}" in printed.err


@pytest.mark.promise("l")
def test_an_owed_lock_does_not_wait_until_the_check_is_kept(
    port: str, dps_s: Program, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where the port was lost it is opened again for LOCK; the disk may take seconds."""
    told: list[str] = []

    def keep(*check: Any, **more: Any) -> Filed:
        told.append("kept")
        return file_check(*check, **more)

    monkeypatch.setattr("app.cli.preflight.file_check", keep)
    monkeypatch.setattr("app.terminal.connection.notify", told.append)
    bench = open_bench(port)
    at_frame(bench, 1, lambda: at(bench, "active", exchange), code=BY_NAME["activation"].code)
    dps_s(["preflight", "--activate", "--records-reviewed", "--port", port, "--yes"], 1)
    locked = "LOCK was sent after the interruption. The module that answers now reports LOCKED."
    assert told == ["kept", locked, "kept"], "READY, then what came of it"


def ignore_lock(bench: SimulatedBench) -> None:
    """Another boot count ends the conversation; it stays active."""
    bench.module.memory.boot_count = 90
    lose(bench, BY_NAME["activation"].code)


@pytest.mark.parametrize("end", [lambda bench: bench.change(mute=True), ignore_lock])
def test_where_nobody_confirms_lock_it_is_said_that_nothing_is_locked(end: End, port: str, dps_s: Program) -> None:
    at(open_bench(port), "active", end, number=2)
    printed = dps_s(["activate", "--port", port, "--yes"], 1)
    assert "ACTIVE, not locked." in printed.err
    assert "LOCK was sent after the interruption." not in printed.err


@pytest.mark.parametrize("words", ["activate", "preflight --activate --records-reviewed"])
@pytest.mark.promise("l")
def test_ctrl_c_after_an_activation_has_left_locks(words: str, port: str, dps_s: Program, wire: list[bytes]) -> None:
    bench = open_bench(port)
    at_frame(bench, 1, lambda: signal.raise_signal(signal.SIGINT), code=BY_NAME["activation"].code)
    printed = dps_s([*words.split(), "--port", port, "--yes"], 130)
    assert sets(wire)[-2:] == ["activation", "activation"]
    assert not bench.module.state.is_active
    assert "LOCK was sent after the interruption. The module reports LOCKED." in printed.err


def test_after_an_end_lock_is_said_of_the_module_that_answers_now(port: str, dps_s: Program) -> None:
    at(open_bench(port), "active", exchange)
    said = {"The module that answers now reports LOCKED.\n": Outcome.UNKNOWN,  # of the first one nothing is known
            "The module reports LOCKED.\n": Outcome.CONFIRMED}  # fmt: skip  # it was gone before it had begun to answer
    printed = dps_s(["lock", "--port", port])
    with closing(open_store()) as store:
        (entry,) = audit(store)
    assert (entry.act, entry.outcome) == (Act.LOCK, said[printed.out])


@pytest.mark.promise("a")
def test_of_records_that_came_before_the_end_nothing_is_kept(port: str, dps_s: Program) -> None:
    open_bench(port).module.memory.records = SimulatedBench(Setup(history=3, seed=5)).module.memory.records
    at(open_bench(port), "trigger_records", exchange, number=2)
    printed = dps_s(["history", "--port", port, "--json", "--module", "M-07"], 3)
    assert json.loads(printed.out)["error"]["code"] == "interrupted"
    with closing(open_store()) as store:
        assert not store.read(modules)


@pytest.mark.parametrize("words", ["history --json", "preflight --enable-triggers", "preflight --activate --yes"])
@pytest.mark.promise("a")
def test_a_name_is_refused_where_something_speaks_against_it(
    words: str, port: str, dps_s: Program, wire: list[bytes]
) -> None:
    named = [*words.split(), "--port", port, "--module", "M-07"]
    dps_s(["history", "--port", port, "--module", "M-07"])
    open_bench(port).module.memory.boot_count = 30  # it was 37: another one
    wire.clear()
    printed = dps_s(named, 1)
    assert "This may be another module: boot count 30, was 37." in printed.err
    assert "Add --same-module to do it." in printed.err
    assert sets(wire) == []
    dps_s(["history", "--port", port, "--module", "M-07", "--same-module"])


@pytest.mark.parametrize("words", ["monitor --json", "record FILE"])
@pytest.mark.usefixtures("hasty")
def test_watching_goes_on_in_the_next_conversation(
    words: str, port: str, dps_s: Program, wire: list[bytes], tmp_path: Path
) -> None:
    path = tmp_path / "a.csv"

    def exchange_for_a_quiet_one(bench: SimulatedBench) -> None:
        exchange(bench)
        bench.module.stop_stream()

    at(open_bench(port), "charging", exchange_for_a_quiet_one, number=4)
    typed = [str(path) if word == "FILE" else word for word in words.split()]
    printed = dps_s([*typed, "--port", port, "--seconds", "8"])
    assert "The module was silent for a moment. Another module may answer from now on." in printed.err
    assert sets(wire) == ["serial_output"], "the next module is polled"
    if path.exists():
        events = [row.rpartition(",")[2] for row in path.read_text("utf-8").splitlines()]
        assert "silent" in events
    else:
        assert json.loads(printed.out.splitlines()[-1])["t_s"] > 7


def test_ctrl_c_before_a_status_came_is_what_ended_it(port: str, dps_s: Program) -> None:
    at_frame(open_bench(port), 1, lambda: signal.raise_signal(signal.SIGINT), code=STATUS.code)
    dps_s(["monitor", "--port", port], 130)


@pytest.mark.parametrize("words", ["monitor --json", "record FILE"])
def test_watching_ends_where_nobody_answers(words: str, port: str, dps_s: Program, tmp_path: Path) -> None:
    at(open_bench(port), "charging", lambda bench: bench.change(mute=True), number=3)
    typed = [str(tmp_path / "a.mcap") if word == "FILE" else word for word in words.split()]
    assert "The module does not answer." in dps_s([*typed, "--port", port], 3).err
    assert len(list(tmp_path.glob("a*.mcap"))) == words.count("FILE")


@pytest.mark.promise("a")
def test_what_is_asked_after_a_break_goes_to_nobody(port: str, wire: list[bytes]) -> None:
    """The next conversation begins between two jobs of one command."""
    with connected(port, 115200) as opened:
        open_bench(port).restart()
        while opened.conversation.number == opened.number:
            opened.wait()
        wire.clear()
        with pytest.raises(Interrupted):
            opened.run(read_history())
    assert BY_NAME["trigger_records"].query().encode() not in wire
