"""Finding the rate, reading all settings, calibrating the light: questions only."""

from collections import Counter
from collections.abc import Callable

import pytest

from app.engine.procedure import Ask, Effect, EngineView, Pause, Procedure, Report, TwoModules, UseRate
from app.engine.setting_changes import changed_settings
from app.procedures.find import ROUNDS, SETTLE_S, find_rate, look_for
from app.procedures.handshake import Silence, what_came
from app.procedures.light_calibration import (
    ENOUGH_SAMPLES,
    Band,
    CalibrationFault,
    LightDirection,
    Proposal,
    measure_light,
    propose,
)
from app.procedures.read import READABLE, read_everything
from app.procedures.settings_reading import ReadFault, SettingsReading, read_settings
from app.procedures.write_all import SettingChange, WriteContext, write_all
from protocol.catalogue import BAUD_RATES, BY_NAME, Hazard
from protocol.events import Counters, Role, Unanswered
from protocol.frame import Reason
from tests.support.journals import FakeJournal
from tests.support.line.frames import at_frame
from tests.support.line.sim_line import Rig, engine_view


@pytest.mark.parametrize("delay_ms", [0.0, 400.0, 760.0, 900.0, 980.0])
@pytest.mark.parametrize("rate", [115200, 9600])
@pytest.mark.promise("k")
def test_a_module_that_uses_the_vendors_second_is_found(rate: int, delay_ms: float) -> None:
    rig = Rig({"baud": rate, "delay_ms": delay_ms})
    assert rig.run(find_rate()).baud_rate == rate
    rig = Rig({"baud": rate, "delay_ms": delay_ms})
    assert rig.run(look_for(57600, 38400)) == rate


def test_a_slow_module_that_does_not_know_a_question_is_not_called_dead() -> None:
    rig = Rig({"delay_ms": 900.0, "mute_codes": "14"})
    everything = rig.run(read_everything())
    assert not everything.is_silent
    assert set(everything.errors) == {"light_v"}


def seen(frames: int = 0, echoes: int = 0, rejected: int = 0) -> EngineView:
    counters = Counters(
        frames=frames,
        by_role=Counter({Role.ECHO: echoes}),
        rejected_bytes=Counter({Reason.NO_HEADER: rejected}),
    )
    return engine_view(counters=counters)


@pytest.mark.parametrize(
    ("after", "silence"),
    [
        (seen(5, 5, 5), Silence.NOTHING),
        (seen(7, 7, 5), Silence.ECHO),
        (seen(7, 6, 5), Silence.OTHER_FRAMES),
        (seen(7, 7, 6), Silence.GARBAGE),
        (seen(6, 5, 6), Silence.OTHER_FRAMES),
        (seen(6, 5, 105), Silence.GARBAGE),
        (seen(5, 5, 6), Silence.GARBAGE),
    ],
)
def test_a_silence_is_told_by_what_came_since(after: EngineView, silence: Silence) -> None:
    assert what_came(after.link.counters - seen(5, 5, 5).link.counters) is silence


TWO_CHANGES = [SettingChange(BY_NAME["freefall_time"], 1.2), SettingChange(BY_NAME["attitude_threshold"], 70)]


@pytest.mark.parametrize(
    ("procedure", "doing", "total"),
    [
        (read_settings, "Reading: {what}", 6),
        (read_everything, "Reading: {what}", len(READABLE)),
        (lambda: look_for(57600, 38400), "Trying {rate} baud", 2 * ROUNDS + 4),
        (find_rate, "Trying {rate} baud", 6),
        (measure_light, "Measuring the light", 20),
        (lambda: write_all(TWO_CHANGES, WriteContext(journal=FakeJournal())), "Writing: {what}", 2),
    ],
)
def test_progress_is_counted_step_by_step(procedure: Callable[[], Procedure[object]], doing: str, total: int) -> None:
    rig, reports = Rig({"baud": 4800}, baud_rate=115200 if "rate" in doing else 4800), list[Report]()
    rig.run(procedure(), reports.append)
    steps = [(report.done, report.total) for report in reports if report.doing == doing]
    assert steps[:total] == [(done, total) for done in range(total)]


@pytest.mark.parametrize("look", [lambda: look_for(57600, 38400), find_rate], ids=["look_for", "find_rate"])
def test_after_each_change_of_the_rate_the_line_settles(look: Callable[[], Procedure[object]]) -> None:
    search = look()
    effects: list[Effect] = []
    answer: object = None
    try:
        while True:
            effects.append(search.send(answer))
            answer = Unanswered(effects[-1].request, 1, 1.0, 0.0) if isinstance(effects[-1], Ask) else seen()
    except StopIteration:
        pass
    changes = [number for number, effect in enumerate(effects[:-1]) if isinstance(effect, UseRate)]
    assert len(changes) >= len(BAUD_RATES)
    assert {effects[number + 1] for number in changes} == {Pause(SETTLE_S)}
    assert isinstance(effects[-1], UseRate)


# All settings in one reading, on one start of the module, and what differs between two readings


ALL = {"light_threshold_v": 1.8, "attitude_threshold_deg": 60, "freefall_acceleration_g": 0.5, "freefall_time_s": 1.6}


def read(rig: Rig) -> SettingsReading:
    return rig.run(read_settings())


def test_all_settings_and_the_boot_count_are_read_by_questions_only() -> None:
    rig = Rig()
    reading = read(rig)
    assert reading.values == ALL
    assert reading.boot_count == rig.bench.module.memory.boot_count
    assert reading.is_complete
    assert {request.hazard for request in rig.line.requests} == {Hazard.NONE}
    codes = [request.command.code for request in rig.line.requests]
    assert codes[:2] == codes[-2:] == [0x23, 0x23]
    assert all(codes.count(BY_NAME[key].code) == 2 for key in ("freefall_time", "attitude_threshold"))


def test_a_restart_in_the_middle_leaves_no_boot_count() -> None:
    rig = Rig()
    at_frame(rig.bench, 1, rig.bench.restart, code=0x20)
    reading = read(rig)
    assert (reading.is_restarted, reading.boot_count, reading.is_complete) == (True, None, False)


def test_a_restart_that_nobody_heard_is_seen_in_the_boot_count() -> None:
    rig = Rig()

    def restart_unheard() -> None:
        rig.bench.module.memory.boot_count += 1

    at_frame(rig.bench, 1, restart_unheard, code=0x21)
    reading = read(rig)
    assert (reading.is_restarted, reading.boot_count) == (True, None)


def test_an_unanswered_setting_is_named_and_the_others_are_read() -> None:
    reading = read(Rig({"mute_codes": frozenset((0x22,))}))
    assert reading.faults == {"freefall_time_s": ReadFault.NO_REPLY}
    assert reading.values == {key: value for key, value in ALL.items() if key != "freefall_time_s"}
    assert not reading.is_complete
    assert not reading.is_silent


def test_a_module_that_falls_silent_is_asked_no_further() -> None:
    rig = Rig()
    at_frame(rig.bench, 1, lambda: rig.bench.change(mute=True), code=0x20)
    reading = read(rig)
    assert reading.is_silent
    assert not reading.is_complete
    assert [request.command.code for request in rig.line.requests].count(0x21) == 0


def test_what_changed_between_two_readings_is_named() -> None:
    rig = Rig()
    first = read(rig)
    assert changed_settings(first.values, read(rig).values) == ()
    rig.bench.module.memory.attitude_threshold = 200
    rig.bench.module.memory.freefall_time = 20
    with pytest.raises(TwoModules, match="Attitude threshold: 60°, then 200°"):
        read(rig)  # nobody set it
    changed = changed_settings(first.values, read(rig).values)
    assert [(one.command.key, one.before, one.after) for one in changed] == [
        ("attitude_threshold_deg", 60, 200),
        ("freefall_time_s", 1.6, 0.2),
    ]
    assert changed_settings({}, first.values) == ()


# A light threshold by measurement, whichever way light moves the reading


def band(low: int, high: int, count: int = ENOUGH_SAMPLES) -> Band:
    return Band(tuple(low if number % 2 else high for number in range(count)))


@pytest.mark.parametrize(("inverted", "direction"), [(False, LightDirection.RISES), (True, LightDirection.FALLS)])
def test_the_direction_is_found_and_the_threshold_lies_between(inverted: bool, direction: LightDirection) -> None:
    rig = Rig({"light_inverted": inverted, "noise": 1.0})
    closed = rig.run(measure_light())
    rig.bench.set_world(bay_is_open=True)
    opened = rig.run(measure_light())
    proposal = propose(closed, opened)
    assert isinstance(proposal, Proposal)
    assert proposal.direction is direction
    assert len(closed.raws) == len(opened.raws) == 20
    low, high = sorted((closed, opened), key=lambda one: one.low_v)
    assert low.high_v < proposal.threshold_v < high.low_v
    assert proposal.margin_closed_v == pytest.approx(proposal.margin_open_v, abs=0.11)
    assert proposal.is_steady
    assert proposal.vendors_v == pytest.approx(0.3 if inverted else 2.5, abs=0.1)


@pytest.mark.parametrize(
    ("closed", "opened", "found"),
    [
        (band(3, 5), band(5, 9), CalibrationFault.TOO_CLOSE),
        (band(5, 9), band(3, 5), CalibrationFault.TOO_CLOSE),
        (band(3, 9), band(5, 6), CalibrationFault.TOO_CLOSE),
        (band(3, 5), band(6, 9), CalibrationFault.TOO_CLOSE),
        (band(6, 9), band(3, 5), CalibrationFault.TOO_CLOSE),
        (band(3, 5, 9), band(20, 21), CalibrationFault.TOO_FEW),
        (band(3, 5), band(20, 21, 9), CalibrationFault.TOO_FEW),
        (Band(band(3, 5).raws, is_broken=True), band(20, 21), CalibrationFault.TOO_FEW),
        (Band(()), Band(()), CalibrationFault.TOO_FEW),
    ],
)
def test_no_threshold_where_there_is_no_gap(closed: Band, opened: Band, found: CalibrationFault) -> None:
    assert propose(closed, opened) is found


@pytest.mark.parametrize(("closed", "opened"), [((3, 5), (7, 9)), ((7, 9), (3, 5)), ((0, 0), (255, 255))])
def test_the_smallest_gap_and_the_widest(closed: tuple[int, int], opened: tuple[int, int]) -> None:
    proposal = propose(band(*closed), band(*opened))
    assert isinstance(proposal, Proposal)
    assert min(proposal.margin_closed_v, proposal.margin_open_v) >= 0.1
    assert f"{proposal.threshold_v:.1f} V" in proposal.sentence


def test_light_that_is_not_steady_is_said() -> None:
    proposal = propose(band(0, 9), band(20, 21))
    assert isinstance(proposal, Proposal)
    assert not proposal.is_steady


def test_a_measurement_ends_where_nothing_answers() -> None:
    found = Rig({"mute_codes": frozenset((0x14,))}).run(measure_light())
    assert (found.raws, found.lost, found.is_enough) == ((), 10, False)


def test_a_restart_spoils_the_measurement() -> None:
    rig = Rig()
    at_frame(rig.bench, 5, rig.bench.restart)
    found = rig.run(measure_light())
    assert found.is_broken
    assert not found.is_enough


def test_a_band_of_light_at_its_limits() -> None:
    assert Band((5, 8)).is_steady
    assert not Band((5, 9)).is_steady
    assert not Band(()).is_steady
    assert Band((5,) * 10).is_enough
    assert not Band((5,) * 9).is_enough
    band = Band((5, 8, 6))
    assert (band.low_v, band.median_v, band.high_v) == (0.5, 0.6, 0.8)
