"""`dps-s activate | lock | zero | shutdown`: nothing without --yes, refused while a condition is open, recorded."""

import pytest

import app.__main__ as program
from app.safety.acts import EFFECTS, REQUESTS, Act
from app.safety.journal import Outcome
from app.store.store import data_folder, open_store
from tests.support.cli_line import Printed, bench_of, run_here

pytest_plugins = ["tests.support.cli_fixtures"]
pytestmark = pytest.mark.usefixtures("speaks_english")
ACTS = {0x10, 0x11, 0x12, 0x24, 0x25}


def acts(wire: list[bytes]) -> list[bytes]:
    return [frame for frame in wire if frame[2] in ACTS]


def recorded() -> list[tuple[Act, Outcome]]:
    store = open_store()
    try:
        return [(entry.act, entry.outcome) for entry in store.audit()]
    finally:
        store.close()


@pytest.mark.parametrize("name", ["activate", "lock", "zero", "shutdown"])
def test_without_yes_it_says_what_would_happen(
    name: str, port: str, capsys: pytest.CaptureFixture[str], wire: list[bytes]
) -> None:
    printed = run_here(capsys, [name, "--port", port], 2)
    assert printed.out == f"{EFFECTS[Act(name)]}\n"
    assert printed.err == "Nothing was done. Add --yes to do it.\n"
    assert wire == []
    assert recorded() == []


@pytest.mark.parametrize("name", ["activate", "lock", "zero", "shutdown"])
def test_with_yes_it_is_done_once_and_recorded(
    name: str, port: str, capsys: pytest.CaptureFixture[str], wire: list[bytes]
) -> None:
    options = {"lock": "?active=yes", "zero": "?tilt=4"}.get(name, "")
    assert run_here(capsys, [name, "--port", port + options, "--yes"]).out.startswith(("The module ", "Acknowledged"))
    assert acts(wire) == [REQUESTS[Act(name)].encode()]
    assert recorded() == [(Act(name), Outcome.CONFIRMED)]
    module = bench_of(port).module
    assert module.state.is_active is (name == "activate")
    assert module.is_on is (name != "shutdown")
    assert module.memory.zero_tilt_deg == (4 if name == "zero" else 0)


@pytest.mark.parametrize(
    ("name", "options", "why"),
    [
        ("activate", "tilt=70", "Tilt 70° (threshold 60°): it would fire at once."),
        ("activate", "active=yes", "The module is ACTIVE: lock it first."),
        ("zero", "active=yes", "The module is ACTIVE: lock it first."),
        ("zero", "tilt=12", "Tilt 12°: lay it level (≤ 10°)."),
        ("shutdown", "active=yes", "The module is ACTIVE: lock it first."),
    ],
)
def test_an_open_condition_is_named(
    name: str, options: str, why: str, port: str, capsys: pytest.CaptureFixture[str], wire: list[bytes]
) -> None:
    printed = run_here(capsys, [name, "--port", f"{port}?{options}", "--yes"], 1)
    assert printed.out == ""
    assert printed.err == f"Nothing was sent. {why}\n"
    assert acts(wire) == []


def test_what_is_not_confirmed_is_not_done(port: str, hasty: None, capsys: pytest.CaptureFixture[str]) -> None:
    assert program.main(["zero", "--port", f"{port}?mute_codes=25", "--yes"]) == 1
    assert Printed(capsys).err == "Sent, not confirmed. Tilt now 0°.\n"
    assert recorded() == [(Act.ZERO, Outcome.UNKNOWN)]


def test_without_a_store_only_locking_is_done(port: str, capsys: pytest.CaptureFixture[str], wire: list[bytes]) -> None:
    data_folder().parent.mkdir(parents=True)
    data_folder().write_text("in the way", encoding="utf-8")
    assert "The audit log cannot be written." in run_here(capsys, ["activate", "--port", port, "--yes"], 1).err
    assert acts(wire) == []
    assert program.main(["lock", "--port", port, "--yes"]) == 0
    assert acts(wire) == [REQUESTS[Act.LOCK].encode()]


@pytest.mark.parametrize("name", ["activate", "lock", "zero", "shutdown"])
def test_no_link(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    printed = run_here(capsys, [name, "--port", "/dev/no-such-port", "--yes"], 3)
    assert printed.err.startswith("There is no port")
    assert recorded() == []


def test_there_is_no_deploy(port: str, capsys: pytest.CaptureFixture[str], wire: list[bytes]) -> None:
    assert program.main(["deploy", "--port", port, "--yes"]) == 2
    assert wire == []
