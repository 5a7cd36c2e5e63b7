"""`dps-s activate | lock | zero | shutdown | set`: what leaves and is recorded, and what an earlier run left ACTIVE."""

import argparse
import json
import sqlite3
import sys
from collections.abc import Iterator
from contextlib import closing
from datetime import timedelta
from pathlib import Path

import pytest

from app.cli.act import print_outcome
from app.engine import transport
from app.engine.conversation import StatusSample
from app.engine.ports import PortInfo
from app.port_urls.protocol_sim import open_bench
from app.procedures.act import Performed
from app.safety.journal import REQUESTS, Act, Outcome
from app.safety.last_known import keep_away
from app.safety.left_active import all_left
from app.simulator.bench import SimulatedBench
from app.simulator.endpoints import TcpEndpoint
from app.store.fact_store import FILE_NAME, open_file, utc_now
from app.system.files import data_folder
from protocol.catalogue import BY_NAME
from tests.support.cli_line import Program, sets
from tests.support.line.frames import lose
from tests.support.patience import in_time
from tests.support.processes import PROGRAM, ran, ran_code, run_module
from tests.support.records.stored import audit, begin, kept_settings, open_store, settle
from tests.unit.simulator.test_simulator_servers import posix_only, pty, serving

pytest_plugins = ["tests.support.cli_fixtures"]
pytestmark = pytest.mark.usefixtures("speaks_english")
in_virtual_time = pytest.mark.usefixtures("no_waiting")


@in_virtual_time
@pytest.mark.parametrize("name", ["activate", "lock", "zero", "shutdown"])
def test_with_yes_it_is_done_once_and_recorded(name: str, port: str, dps_s: Program, wire: list[bytes]) -> None:
    options = {"lock": "?active=yes", "zero": "?tilt=4"}.get(name, "")
    assert dps_s([name, "--port", port + options, "--yes"]).out.startswith(("The module ", "Acknowledged"))
    assert sets(wire) == [REQUESTS[Act(name)].command.name]
    assert REQUESTS[Act(name)].encode() in wire
    with closing(open_store()) as store:
        assert [(entry.act, entry.outcome) for entry in audit(store)] == [(Act(name), Outcome.CONFIRMED)]
    module = open_bench(port).module
    assert module.state.is_active is (name == "activate")
    assert module.is_on is (name != "shutdown")
    assert module.memory.zero_tilt_deg == (4 if name == "zero" else 0)


def test_zeroing_that_leaves_a_tilt_is_no_success(capsys: pytest.CaptureFixture[str]) -> None:
    done = Performed(act=Act.ZERO, outcome=Outcome.CONFIRMED, status=StatusSample(0.0, 3, 1.0, False, False))
    assert print_outcome(argparse.Namespace(json=False), Act.ZERO, done) == 1
    assert "Tilt now 3°, not 0°" in capsys.readouterr().err


@in_virtual_time
@pytest.mark.parametrize(
    ("words", "code", "said", "sent"),
    [
        ("activate --yes", 1, ["Nothing was sent. The audit log cannot be written."], []),
        ("lock", 0, ["The module reports LOCKED."], ["activation"]),
        ("set freefall_time_s=1.2", 0, ["1.2: verified", "The audit log is incomplete."], ["freefall_time"]),
        (
            "set freefall_time_s=1.2 baud_rate=9600",
            1,
            ["1.2: verified", "9600: NOT verified (not sent: The audit log cannot be written"],
            ["freefall_time"],
        ),
        (
            "preflight --activate --yes --module M-07",
            1,
            ["READY: activate", "Nothing was sent", "Not kept so far."],
            ["freefall_trigger", "attitude_trigger"],
        ),
    ],
)
def test_without_a_store_no_dangerous_frame_leaves_but_lock(
    words: str, code: int, said: list[str], sent: list[str], port: str, dps_s: Program, wire: list[bytes]
) -> None:
    data_folder().parent.mkdir(parents=True)
    data_folder().write_text("in the way", encoding="utf-8")
    printed = dps_s([*words.split(), "--port", port], code)
    assert [part for part in said if part not in printed.out + printed.err] == []
    assert "dps-s.sqlite cannot be used: File exists." in printed.err
    assert sets(wire) == sent


@in_virtual_time
@pytest.mark.parametrize(("module", "code"), [("?mute=yes", 3), ("?active=yes", 1)])
def test_lock_is_sent_before_anything_is_answered(
    module: str, code: int, port: str, dps_s: Program, wire: list[bytes]
) -> None:
    lose(open_bench(port + module), BY_NAME["activation"].code)
    said = dps_s(["lock", "--port", port + module, "--yes"], code).err
    assert REQUESTS[Act.LOCK].encode() in wire[:2], "the link itself asks for the boot count when a port is opened"
    assert "not confirmed: treat the module as ACTIVE." in said


@in_virtual_time
def test_lock_leaves_before_any_file_is_opened(
    port: str, dps_s: Program, wire: list[bytes], monkeypatch: pytest.MonkeyPatch
) -> None:
    sent: list[list[bytes]] = []

    def noted(path: Path) -> object:
        sent.append(wire.copy())
        return open_file(path)

    monkeypatch.setattr("app.store.fact_store.open_file", noted)
    dps_s(["lock", "--port", port])
    assert REQUESTS[Act.LOCK].encode() in sent[0]


BLOCKED = """
import sqlite3, sys, threading
sqlite3.connect = lambda *words, **options: threading.Event().wait()
from app.__main__ import main
sys.exit(main(sys.argv[1:]))
"""


@pytest.mark.skipif(sys.platform == "win32", reason="there are no pseudo-terminals on Windows")
@pytest.mark.usefixtures("user_files")
def test_lock_waits_neither_for_a_held_store_nor_for_a_disk_that_never_answers() -> None:
    """The contract says 5 s after the confirmation; the start of the program and a busy machine come on top."""
    with run_module("--active", "yes") as module:
        ran(*PROGRAM, "lock", "--port", module.port)
        with closing(sqlite3.connect(data_folder() / FILE_NAME, isolation_level=None)) as other:
            other.execute("PRAGMA locking_mode = EXCLUSIVE")
            other.execute("BEGIN EXCLUSIVE")
            with in_time(8.0):
                held = ran(*PROGRAM, "lock", "--port", module.port)
        with in_time(8.0):
            blocked = ran_code(BLOCKED, "lock", "--port", module.port)
    for printed in (held, blocked):
        assert (printed.returncode, printed.stdout) == (0, "The module reports LOCKED.\n")
        assert "The audit log is incomplete." in printed.stderr


# `dps-s set`


@pytest.mark.parametrize("text", ["[settings]\nfreefall_acceleration_g = 0.55\n", 'name = "empty"\n'])
def test_where_a_profile_is_wrong_nothing_is_sent(
    text: str, tmp_path: Path, port: str, dps_s: Program, wire: list[bytes]
) -> None:
    (tmp_path / "H6.toml").write_text(text, encoding="utf-8")
    dps_s(["set", "--profile", str(tmp_path / "H6.toml"), "--port", port], 2)
    assert wire == []


def test_it_is_recorded_and_the_old_values_are_kept(port: str, dps_s: Program) -> None:
    dps_s(["set", "freefall_time_s=1.2", "--port", port])
    with closing(open_store()) as store:
        (entry,) = audit(store)
        assert (entry.act, entry.outcome, entry.port) == (Act.WRITE, Outcome.CONFIRMED, port)
        assert entry.origin == "command line"
        assert entry.frame == BY_NAME["freefall_time"].set(1.2).encode()
        assert entry.result["read_back"] == 1.2
        (kept,) = kept_settings(store)
        assert kept["freefall_time_s"] == 1.6


@pytest.mark.promise("f")
def test_a_setting_that_nobody_wrote_and_that_changed_is_named(
    port: str, dps_s: Program, monkeypatch: pytest.MonkeyPatch
) -> None:
    memory, write = open_bench(port).module.memory, transport.SerialLine.write

    def written(line: transport.SerialLine, data: bytes) -> None:
        write(line, data)
        if data[2:4] == b"\x22\x02":
            memory.freefall_acceleration = 20

    monkeypatch.setattr(transport.SerialLine, "write", written)
    printed = dps_s(["set", "freefall_time_s=1.2", "--port", port, "--json"], 1)
    result = json.loads(printed.out)["results"]["freefall_time_s"]
    assert (result["verified"], result["error"]) == (False, "verified then, before the interruption")
    assert "Free-fall acceleration threshold: 0.5 g, then 2.0 g. Two modules on this line?" in printed.err


@in_virtual_time
@pytest.mark.parametrize(
    ("words", "frames", "sent"),
    [
        ("set attitude_threshold_deg=65 freefall_time_s=1.2 light_threshold_v=2", 0, 2),
        ("preflight --enable-triggers", 0, 1),
        ("preflight", 12, 0),
    ],
)
@pytest.mark.parametrize("is_json", [False, True])
def test_interrupted_it_says_what_may_have_been_carried_out(
    words: str,
    frames: int,
    sent: int,
    is_json: bool,
    port: str,
    dps_s: Program,
    wire: list[bytes],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Ctrl-C comes after so many frames, and so many sets."""

    def check() -> None:
        if len(wire) > frames and len(sets(wire)) == sent:
            raise KeyboardInterrupt(2)

    monkeypatch.setattr("app.terminal.connection.check_signals", check)
    printed = dps_s([*words.split(), "--port", port, *(["--json"] if is_json else [])], 130)
    assert printed.out == "" if not is_json else json.loads(printed.out)["error"]["code"] == "cancelled"
    assert printed.err.startswith("Interrupted; may have been carried out.\n") == (sent > 0)
    assert len(sets(wire)) == sent


# What an earlier run left ACTIVE


@pytest.fixture
def line() -> Iterator[str]:
    """The address of a module that the program takes for a real one."""
    with serving(SimulatedBench(), TcpEndpoint("127.0.0.1", 0)) as address:
        yield address


def leave(port: str, module: str = "", act: Act = Act.ACTIVATE, outcome: Outcome = Outcome.CONFIRMED) -> None:
    """As another process logged it, whose clock was an hour ahead."""
    with closing(open_store(clock=lambda: utc_now() + timedelta(hours=1))) as store:
        entry = begin(store, act, REQUESTS[act].encode(), {}, port=port, name=module, run=f"before {module}")
        settle(store, entry, outcome)


def left() -> list[str]:
    with closing(open_store()) as store:
        return sorted(one.module for one in store.read(all_left))


@pytest.mark.parametrize(
    "words",
    [
        "find", "read", "history --module M-07", "set freefall_time_s=1.4", "save NEW", "diff FILE", "activate --yes",
        "preflight --module M-07", "record - --seconds 0.1",
    ],
)  # fmt: skip
@pytest.mark.promise("l")
def test_each_command_says_it_once(words: str, line: str, tmp_path: Path, dps_s: Program) -> None:
    (tmp_path / "wanted.toml").write_text("[settings]\nfreefall_time_s = 1.6\n", encoding="utf-8")
    leave(line)
    files = {"FILE": str(tmp_path / "wanted.toml"), "NEW": str(tmp_path / "new.toml")}
    command = [files.get(word, word) for word in words.split()]
    # Behind a plain socket no baud rate is searched for, and this check is NO-GO.
    code = {"find": 2, "preflight": 1}.get(command[0], 0)
    said = dps_s([*command, "--port", line], code).err
    assert said.count(" was left ACTIVE on ") == 1
    assert said.startswith(f"The module at {line} was left ACTIVE on ")
    assert keep_away() in said.splitlines()[0]


@pytest.mark.promise("l")
def test_it_is_said_also_where_nobody_answers(dps_s: Program) -> None:
    leave("/dev/no-such-port")
    for command in ("read", "history"):
        said = dps_s([command, "--port", "/dev/no-such-port"], 3).err
        assert said.startswith("The module at /dev/no-such-port was left ACTIVE on ")
        assert said.count(" was left ACTIVE on ") == 1


@pytest.mark.parametrize(
    ("left_as", "port", "words", "is_said"),
    [
        ("M-07", "LINE", "read", True),
        ("M-07", "elsewhere", "read", False),
        ("M-07", "elsewhere", "history --module M-07", True),
        ("M-07", "LINE", "history --module M-08", False),
        ("", "LINE", "history --module M-08", True),
    ],
)
def test_it_is_that_of_the_module_in_question(
    left_as: str, port: str, words: str, is_said: bool, line: str, dps_s: Program
) -> None:
    leave(line if port == "LINE" else port, left_as)
    assert (" was left ACTIVE on " in dps_s([*words.split(), "--port", line]).err) is is_said


@posix_only
def test_an_act_is_logged_with_its_adapter_which_may_have_another_port_by_then(
    monkeypatch: pytest.MonkeyPatch, dps_s: Program
) -> None:
    with serving(SimulatedBench(), pty()) as port, serving(SimulatedBench(), pty()) as other_port:

        def plug(*devices: str) -> None:
            ports = [PortInfo(device, serial_number=f"A{at}", vid=1, pid=2) for at, device in enumerate(devices)]
            monkeypatch.setattr("app.engine.ports.list_ports", lambda: ports)

        plug(port, other_port)
        for act in ("lock", "activate"):
            dps_s([act, "--yes", "--port", port])
        with closing(open_store()) as store:
            assert [entry.adapter for entry in audit(store)] == ["0001:0002:A0"] * 2
        for listed, device, is_said in (((other_port, port), port, False), ((other_port, port), other_port, True)):
            plug(*listed)
            said = dps_s(["read", "--port", device]).err
            assert (f"The module at {port} was left ACTIVE on " in said) is is_said


@pytest.mark.parametrize(
    ("words", "still", "said"),
    [
        ("lock", ["", "M-07"], 2),
        ("lock --module M-08", ["", "M-07"], 1),
        ("lock --module M-07", [""], 1),
        ("lock --same-module", ["M-07"], 1),
        ("lock --module M-07 --same-module", [], 0),
        ("lock --module M-08 --same-module", ["M-07"], 0),
    ],
)
@pytest.mark.promise("l")
def test_a_confirmed_lock_ends_it_for_the_module_that_a_person_names(
    words: str, still: list[str], said: int, line: str, dps_s: Program
) -> None:
    for name in ("", "M-07"):
        leave(line, name)
    printed = dps_s([*words.split(), "--port", line])
    assert printed.out == "The module reports LOCKED.\n"
    assert left() == still
    assert printed.err.count(" was left ACTIVE on ") == said


@pytest.mark.promise("l")
def test_a_lock_that_is_not_confirmed_or_of_another_module_ends_nothing(dps_s: Program) -> None:
    leave("/dev/no-such-port", "M-07", Act.LOCK, Outcome.UNKNOWN)
    said = dps_s(["lock", "--same-module", "--port", "/dev/no-such-port"], 3).err
    assert said.count("M-07: LOCK not confirmed on ") == 1
    assert left() == ["M-07"]
    bench = SimulatedBench()
    with serving(bench, TcpEndpoint("127.0.0.1", 0)) as line:
        dps_s(["history", "--module", "M-07", "--port", line])
        leave(line, "M-07")
        bench.module.memory.boot_count = 30  # it was 37
        said = dps_s(["lock", "--module", "M-07", "--port", line]).err
    assert "This may be another module: boot count 30, was 37." in said
    assert left() == ["M-07"]
