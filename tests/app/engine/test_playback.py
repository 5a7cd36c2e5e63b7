"""A played capture answers questions only: the session refuses the rest, and so does whatever changes or judges."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import app.__main__ as program
from app.captures.player import url_of
from app.captures.writer import entries_of
from app.engine.playback import OnlyPlayedBack, is_playback
from app.engine.procedure import Ask, Procedure
from app.engine.session import Session
from app.preflight.evidence import Evidence
from app.preflight.run import run_preflight
from app.procedures.act import perform
from app.procedures.baud import change_baud
from app.procedures.light_calibration import measure_light
from app.procedures.lock import lock
from app.procedures.power_cycle import survives_power_cycle
from app.procedures.read import read_everything
from app.procedures.stream import StreamSwitch, watch
from app.procedures.write_all import SettingChange, WriteContext, write_all
from app.safety.acts import Act
from app.safety.journal import NoJournal
from app.safety.permit import Origin, Permit
from app.store.database import FILE_NAME, open_database
from app.store.store import data_folder
from protocol.catalogue import BY_NAME, SETTINGS, Hazard
from protocol.events import Unanswered
from tests.support.cli_line import Printed
from tests.support.journals import FakeJournal
from tests.support.line.sim_line import INSTANT_S, Rig
from tests.support.records.captures import written

pytest_plugins = ["tests.support.cli_fixtures"]


class PlayedRig(Rig):
    """As if the simulated module's answers came out of a file: it must never be asked to do anything."""

    def __init__(self) -> None:
        super().__init__({"uptime": 60, "noise": 0})
        self.session = Session(self.line, self.clock, is_playback=True)
        self.clock.now_s += INSTANT_S

    @property
    def acts(self) -> list[object]:
        return [request for request in self.line.requests if request.hazard is not Hazard.NONE]


def _permit(act: Act, rig: Rig) -> Permit:
    return Permit(act, Origin.CONFIRMATION, rig.clock())


CHANGES: dict[str, Callable[[Rig], Procedure[Any]]] = {
    "preflight": lambda rig: run_preflight(Evidence(port="capture://x")),
    "preflight, enabling": lambda rig: run_preflight(Evidence(port="capture://x"), is_enabling=True),
    "write": lambda rig: write_all([SettingChange(BY_NAME["freefall_time"], 1.2)], WriteContext(journal=NoJournal())),
    "light": lambda rig: measure_light(),
    "power cycle": lambda rig: survives_power_cycle({"freefall_time_s": 1.6}, longest_wait_s=1.0),
    "baud": lambda rig: change_baud(9600, NoJournal(), permit=_permit(Act.CHANGE_BAUD, rig)),
    "lock": lambda rig: lock(),
}
ACTS = (Act.ACTIVATE, Act.ZERO, Act.SHUTDOWN, Act.FORBID_DEPLOY, Act.DEPLOY)


@pytest.mark.parametrize("name", CHANGES)
def test_whatever_changes_or_judges_refuses_a_playback(name: str) -> None:
    rig = PlayedRig()
    with pytest.raises(OnlyPlayedBack):
        rig.run(CHANGES[name](rig))
    assert rig.acts == []


def test_a_lock_of_a_playback_is_not_even_an_intent() -> None:
    rig, journal = PlayedRig(), FakeJournal()
    with pytest.raises(OnlyPlayedBack):
        rig.run(lock(journal))
    assert journal.intents == []


@pytest.mark.parametrize("act", ACTS)
def test_no_act_leaves_on_a_playback(act: Act) -> None:
    rig = PlayedRig()
    with pytest.raises(OnlyPlayedBack):
        rig.run(perform(act, NoJournal(), permit=_permit(act, rig)))
    assert rig.line.requests == []


@pytest.mark.parametrize("command", [one for one in SETTINGS if one.key != "serial_output"], ids=lambda one: one.name)
def test_the_session_refuses_a_set_that_nobody_guarded(command: Any) -> None:
    def careless() -> Procedure[None]:
        yield Ask(command.set(command.write.decode(next(iter(command.write.allowed)))), is_deliberate=True)

    rig = PlayedRig()
    with pytest.raises(OnlyPlayedBack):
        rig.run(careless())
    assert rig.line.requests == []


def test_reading_and_watching_go_on_without_the_stream() -> None:
    rig = PlayedRig()

    def wants_stream() -> Procedure[object]:
        return (yield Ask(BY_NAME["serial_output"].set(True)))

    assert isinstance(rig.run(wants_stream()), Unanswered)
    rig.run(read_everything())
    rig.session.run_in_background(watch(StreamSwitch()))
    rig.step_for(20)
    assert rig.session.background is not None
    assert rig.session.device.view(rig.clock()).fresh("tilt_deg", rig.clock()) is not None
    assert rig.acts == []


def test_what_plays_a_capture() -> None:
    for port in ("capture:///tmp/x.dpscap?speed=1", "CAPTURE:///tmp/x.dpscap", "Capture://x"):
        assert is_playback(port)
    for port in ("/dev/ttyUSB0", "sim://capture", "COM3"):
        assert not is_playback(port)


# The command line


@pytest.fixture
def capture(tmp_path: Path) -> str:
    """Of a check that ended with READY."""
    rig, target = Rig({"uptime": 60, "noise": 0}), tmp_path / "sound.dpscap"
    rig.run(run_preflight(Evidence(port="sim"), is_enabling=True))
    written(target, tuple(entries_of(rig.session.take_events(), rig.session.opened_at)))
    return url_of(str(target), speed=1)


def _has_stored_anything() -> bool:
    database = open_database(data_folder()).database
    tables = ("preflight_checks", "visits", "modules", "audit")
    rows = [row for table in tables for row in database.read(f"SELECT * FROM {table}")]
    database.close()
    return bool(rows)


@pytest.mark.usefixtures("speaks_english", "hasty")
@pytest.mark.parametrize("words", [
    ["preflight", "--module", "M-07"], ["preflight", "--json", "--enable-triggers"], ["set", "freefall_time_s=1.2"],
    ["activate", "--yes"], ["lock", "--yes"], ["zero", "--yes"], ["shutdown", "--yes"],
])  # fmt: skip
def test_the_command_line_ends_with_2_and_keeps_nothing(
    words: list[str], capture: str, capsys: pytest.CaptureFixture[str]
) -> None:
    capsys.readouterr()
    assert program.main([words[0], "--port", capture, *words[1:]]) == 2
    assert not (data_folder() / FILE_NAME).exists() or not _has_stored_anything()
    printed = Printed(capsys)
    assert "A capture is played here" in printed.err
    assert printed.out == ""


@pytest.mark.usefixtures("speaks_english", "hasty")
def test_what_only_asks_goes_on(capture: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert program.main(["history", "--port", capture, "--module", "M-07"]) in (0, 4)
    assert "A recording is played" in Printed(capsys).err
    assert program.main(["monitor", "--port", capture, "--seconds", "1"]) == 0
    assert not (data_folder() / FILE_NAME).exists() or not _has_stored_anything()
