"""How long procedures wait for answers that do not come, and how often they ask; the clock is the simulator's."""

from collections import Counter
from collections.abc import Callable

import pytest

from app.engine.procedure import Procedure
from app.preflight.evidence import Evidence
from app.preflight.run import run_preflight
from app.procedures.act import perform
from app.procedures.ask_status import ask_status
from app.procedures.baud import look_for
from app.procedures.find import find_rate
from app.procedures.handshake import handshake
from app.procedures.history import read_history
from app.procedures.light_calibration import measure_light
from app.procedures.read import read_everything
from app.procedures.settings_reading import read_settings
from app.procedures.stream import StreamSwitch
from app.procedures.write import write_verified
from app.procedures.write_all import SettingChange, WriteContext, write_all
from app.safety.acts import REQUESTS, Act
from app.safety.journal import Outcome
from app.safety.permit import Origin, Permit
from protocol.catalogue import BY_NAME, HEARTBEAT, STATUS
from tests.support.journals import FakeJournal
from tests.support.line.sim_line import settled_rig, watched

SILENT: dict[str, object] = {"mute": True}
NO_PROOF: dict[str, object] = {"mute-codes": "23,33,30,31"}
NO_SETTINGS: dict[str, object] = {"mute-codes": "20,21,22,14,34,35,32"}
FREEFALL_TIME = BY_NAME["freefall_time"]


@pytest.mark.parametrize(
    ("procedure", "options", "took_s", "frames"),
    [
        (handshake, SILENT, 1.53, 2),
        (ask_status, SILENT, 4.0, 4),
        (ask_status, NO_SETTINGS, 6.99, 15),
        (read_everything, SILENT, 4.06, 4),
        (read_settings, SILENT, 4.59, 5),
        (read_settings, NO_SETTINGS, 5.89, 18),
        (read_settings, NO_PROOF, 4.58, 16),
        (read_history, SILENT, 4.06, 4),
        (read_history, NO_SETTINGS, 3.0, 6),
        (read_history, {}, 1.05, 23),
        (find_rate, SILENT, 7.86, 12),
        (find_rate, NO_PROOF, 10.2, 17),
        (lambda: look_for(57600, 38400), SILENT, 12.6, 20),
        (lambda: look_for(57600, 38400), NO_PROOF, 14.94, 25),
        (measure_light, SILENT, 40.6, 40),
        (lambda: write_verified(FREEFALL_TIME, 1.2), SILENT, 6.06, 6),
        (lambda: write_verified(FREEFALL_TIME, 1.2), NO_SETTINGS, 6.07, 9),
        (lambda: write_all([SettingChange(FREEFALL_TIME, 1.2)], WriteContext(journal=FakeJournal())), {}, 0.65, 30),
        (lambda: run_preflight(Evidence(port="sim")), SILENT, 11.06, 11),
        (lambda: run_preflight(Evidence(port="sim")), NO_SETTINGS, 26.3, 104),
    ],
)
def test_what_is_not_answered_costs_its_time_and_no_more(
    procedure: Callable[[], Procedure[object]], options: dict[str, object], took_s: float, frames: int
) -> None:
    rig = settled_rig(**options)
    began = rig.clock()
    rig.run(procedure())
    assert rig.clock() - began == pytest.approx(took_s, abs=0.05)
    assert len(rig.line.requests) == frames


@pytest.mark.parametrize(
    ("act", "took_s", "frames"),
    [
        (Act.ACTIVATE, 4.56, 6),
        (Act.ZERO, 4.56, 6),
        (Act.FORBID_DEPLOY, 4.56, 6),
        (Act.SHUTDOWN, 2.66, 3),
        (Act.DEPLOY, 7.32, 10),
    ],
)
def test_after_an_act_a_silent_module_is_asked_only_so_often(act: Act, took_s: float, frames: int) -> None:
    rig = settled_rig(active=act is Act.DEPLOY)
    write, sent = rig.line.write, list[tuple[float, int]]()

    def falls_silent(data: bytes) -> None:
        write(data)
        if data == REQUESTS[act].encode():
            rig.bench.change(mute=True)
            sent.append((rig.clock(), len(rig.line.requests)))

    rig.line.write = falls_silent  # type: ignore[method-assign]
    permit = Permit(act, Origin.RITUAL if act is Act.DEPLOY else Origin.CONFIRMATION, rig.clock())
    assert rig.run(perform(act, FakeJournal(), permit=permit)).outcome is Outcome.UNKNOWN
    ((at, count),) = sent
    assert rig.clock() - at == pytest.approx(took_s, abs=0.05)
    assert len(rig.line.requests) - count == frames


@pytest.mark.parametrize(("is_wanted", "count"), [(True, 198), (False, 40)])
def test_without_a_stream_each_value_is_asked_for_in_its_time(is_wanted: bool, count: int) -> None:
    rig = settled_rig(stream="silent")
    watched(rig, StreamSwitch(is_wanted=is_wanted))
    rig.step_for(5)
    before = len(rig.line.requests)
    rig.step_for(20)
    asked = Counter(request.command.name for request in rig.line.requests[before:])
    assert asked.pop("status") == pytest.approx(count, abs=2)
    settings = ("light_threshold", "attitude_threshold", "freefall_acceleration", "freefall_time")
    slow, rare = ("cell_voltage", "charging", "light"), ("boot_count", *settings)
    assert asked == dict.fromkeys(slow, 20) | dict.fromkeys(rare, 2)


def test_a_silent_module_is_not_asked_again() -> None:
    rig = settled_rig(mute=True)
    assert not rig.run(ask_status())
    assert STATUS.query() not in rig.line.requests
    assert rig.line.requests.count(HEARTBEAT.query()) == 1


def test_a_module_that_answers_is_asked_once() -> None:
    rig = settled_rig()
    assert rig.run(ask_status())
    assert rig.line.requests.count(STATUS.query()) == 1
