"""What an earlier run left ACTIVE is said by every command that opens a port, until that module is locked."""

from collections.abc import Iterator
from contextlib import closing
from datetime import timedelta
from pathlib import Path

import pytest

from app.engine.ports import PortInfo
from app.safety.journal import REQUESTS, Act, Outcome
from app.safety.last_known import keep_away
from app.safety.left_active import KnownAs
from app.simulator.bench import SimulatedBench
from app.simulator.endpoints import TcpEndpoint
from app.store.fact_store import utc_now
from tests.support.cli_line import Program
from tests.support.records.stored import audit, begin, left_in, open_store, settle
from tests.unit.simulator.test_simulator_servers import posix_only, pty, serving

pytest_plugins = ["tests.support.cli_fixtures"]
pytestmark = pytest.mark.usefixtures("speaks_english")


@pytest.fixture
def line() -> Iterator[str]:
    """The address of a module that the program takes for a real one."""
    with serving(SimulatedBench(), TcpEndpoint("127.0.0.1", 0)) as address:
        yield address


def leave(port: str, module: str = "", act: Act = Act.ACTIVATE, outcome: Outcome = Outcome.CONFIRMED) -> None:
    """As another process logged it, whose clock was an hour ahead."""
    with closing(open_store(clock=lambda: utc_now() + timedelta(hours=1))) as store:
        known_as = KnownAs(module, f"before {module}")
        entry = begin(store, act, REQUESTS[act].encode(), {}, port=port, known_as=known_as)
        settle(store, entry, act, outcome, {}, port=port, known_as=known_as)


def left() -> list[str]:
    with closing(open_store()) as store:
        return sorted(one.module for one in left_in(store))


@pytest.mark.parametrize(
    "words",
    [
        "find", "read", "history --module M-07", "set freefall_time_s=1.4", "save NEW", "diff FILE", "activate --yes",
        "preflight --module M-07", "record - --seconds 0.1",
    ],
)  # fmt: skip
@pytest.mark.promise("l")
def test_each_command_says_it_once(words: str, line: str, tmp_path: Path, dps_s: Program) -> None:
    (tmp_path / "wanted.toml").write_text('name = "x"\n[settings]\nfreefall_time_s = 1.6\n', encoding="utf-8")
    leave(line)
    files = {"FILE": str(tmp_path / "wanted.toml"), "NEW": str(tmp_path / "new.toml")}
    command = [files.get(word, word) for word in words.split()]
    # Behind a plain socket no baud rate is searched for, and this check is NO-GO.
    code = {"find": 2, "preflight": 1}.get(command[0], 0)
    said = dps_s([*command, "--port", line], code).err
    assert said.count(" was left ACTIVE on ") == 1
    assert said.startswith(f"The module at {line} was left ACTIVE on ")
    assert keep_away() in said.splitlines()[0]


def test_it_is_said_where_nothing_answers(dps_s: Program) -> None:
    leave("/dev/no-such-port", act=Act.LOCK, outcome=Outcome.UNKNOWN)
    said = dps_s(["read", "--port", "/dev/no-such-port"], 3).err
    assert said.startswith("The module at /dev/no-such-port: LOCK not confirmed on ")
    assert len(said.splitlines()) == 2


@pytest.mark.parametrize(
    ("left_as", "port", "words", "is_said"),
    [
        ("M-07", "LINE", "read", True),
        ("M-07", "elsewhere", "read", False),
        ("M-07", "elsewhere", "history --module M-07", True),
        ("M-07", "LINE", "history --module M-08", False),
        ("", "LINE", "history --module M-08", True),
        ("", "elsewhere", "history --module M-08", False),
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
    with (
        serving(SimulatedBench(), pty()) as port,
        serving(SimulatedBench(), pty()) as other_port,
    ):

        def plug(*devices: str) -> None:
            ports = [PortInfo(device, serial_number=f"A{at}", vid=1, pid=2) for at, device in enumerate(devices)]
            monkeypatch.setattr("app.engine.ports.list_ports", lambda: ports)

        plug(port, other_port)
        for act in ("lock", "activate"):
            dps_s([act, "--yes", "--port", port])
        with closing(open_store()) as store:
            assert [entry.adapter for entry in audit(store)] == ["0001:0002:A0"] * 2
        for listed, device, is_said in (
            ((other_port, port), port, False), ((other_port, port), other_port, True), ((), port, True),
        ):  # fmt: skip
            plug(*listed)
            said = dps_s(["read", "--port", device]).err
            assert (f"The module at {port} was left ACTIVE on " in said) is is_said


@pytest.mark.parametrize(
    ("words", "still", "said"),
    [
        ("lock --yes", ["", "M-07"], 2),
        ("lock --yes --module M-08", ["", "M-07"], 1),
        ("lock --yes --module M-07", [""], 1),
        ("lock --yes --same-module", ["M-07"], 1),
        ("lock --yes --module M-07 --same-module", [], 0),
        ("lock --yes --module M-08 --same-module", ["M-07"], 0),
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


def test_a_lock_that_is_not_confirmed_ends_nothing(dps_s: Program) -> None:
    leave("/dev/no-such-port", "M-07")
    said = dps_s(["lock", "--yes", "--same-module", "--port", "/dev/no-such-port"], 3).err
    assert said.count("M-07 was left ACTIVE on ") == 1
    assert left() == ["M-07"]


@pytest.mark.promise("l")
def test_a_lock_of_what_may_be_another_module_ends_nothing(dps_s: Program) -> None:
    bench = SimulatedBench()
    with serving(bench, TcpEndpoint("127.0.0.1", 0)) as line:
        dps_s(["history", "--module", "M-07", "--port", line])
        leave(line, "M-07")
        bench.module.memory.boot_count = 30  # it was 37
        said = dps_s(["lock", "--module", "M-07", "--port", line]).err
    assert "This may be another module: boot count 30, was 37." in said
    assert left() == ["M-07"]
