"""Logs of every kind with known contents; implausible sensors, clocks, pauses and numbers are said and not judged."""

import errno
import os
from pathlib import Path

import numpy as np
import pytest

from app.engine.conversation import StatusSample
from app.flights.flight_log import Channel, FlightLog, RawLog, assembled, tilt_of_quaternion
from app.flights.judge import TriggerLimits
from app.flights.judging import Answer, FlightSummary
from app.flights.read_log import find_logs, read_flight_log
from app.recordings.library import entry_of
from app.recordings.recording import export
from app.text.messages import UserError
from protocol.messages import Source
from tests.support.flights import log_bytes as made
from tests.support.flights.made_flights import plainly_judged, recorded_reports
from tests.support.records.recordings_made import PORT, write_session

STARTS_S = 73.0
"""Of the flight controller's clock."""
FAST = np.arange(1000) / 100
TIPS_S, FALLS_S, LANDS_S = 4.0, 6.0, 7.75
TILT = np.where(FAST >= TIPS_S, 61.0, 12.0)
FORCE = np.where((FAST >= FALLS_S) & (FAST < LANDS_S), 0.3, 1.0)
EXPECTED = [(TIPS_S, Source.ATTITUDE), (FALLS_S + 1.6, Source.FREEFALL)]


def read(path: Path, data: bytes) -> FlightLog:
    path.write_bytes(data)
    return read_flight_log(path)


def fires(log: FlightLog) -> list[tuple[float, Source]]:
    return [(round(at_s, 6), sources) for at_s, sources in plainly_judged(log, TriggerLimits())]


def problems(log: FlightLog) -> list[str]:
    return [problem.in_english() for problem in log.problems]


def whole_ulog() -> bytes:
    rows = made.ulog("vehicle_local_position", STARTS_S + FAST[::10], 0, 0, FAST[::10] - 50)
    rows += made.ulog("vehicle_status", (STARTS_S, STARTS_S + 3), 2, (2, 5))
    return made.ulog_bytes(STARTS_S + FAST, TILT, FORCE, *rows)


def whole_dataflash() -> bytes:
    times = STARTS_S + FAST
    rows = made.dataflash("BARO", times[::10], 50 - FAST[::10]) + made.dataflash("MODE", times[100], 5, 5)
    rows += made.dataflash_message(times[0], "ArduCopter V4.5.1")
    return made.dataflash_bytes(times, TILT, FORCE, *rows)


@pytest.mark.parametrize("data", [whole_ulog(), whole_dataflash()])
def test_a_whole_log_is_judged(tmp_path: Path, data: bytes) -> None:
    log = read(tmp_path / "00000012.BIN", data)
    assert fires(log) == EXPECTED
    assert log.duration_s == pytest.approx(9.99)
    assert log.not_judged_s == pytest.approx(0.0, abs=0.02)
    assert log.altitude_m[log.time_s == 4.0] == pytest.approx(46.0, abs=0.05)
    assert log.problems == ()


def test_no_row_of_a_long_text_is_lost(tmp_path: Path) -> None:
    """It is read some thousand rows at a time."""
    tilt = np.arange(12_000) % 90 / 2
    log = read(tmp_path / "long.log", made.dataflash_text(np.arange(12_000) / 50, tilt, np.ones(12_000)))
    assert np.allclose(log.tilt_deg, tilt, atol=0.01)
    assert np.allclose(log.specific_force_g, 1, atol=0.01)


def test_a_slow_log_is_judged_at_its_own_samples(tmp_path: Path) -> None:
    """Attitude at 10 Hz, acceleration at 25 Hz: a row holds the newest sample of each."""
    slow = np.arange(100) / 10
    rows = made.dataflash("ATT", slow, 0, np.where(slow >= 4.05, 7500, 0), 9000, 0, 0, 0)
    rows += made.dataflash_force(FAST[::4], FORCE[::4])
    log = read(tmp_path / "a.bin", made.dataflash_bytes([], [], [], *rows))
    assert fires(log) == [(4.1, Source.ATTITUDE), (7.6, Source.FREEFALL)]


@pytest.mark.parametrize("kind", ["named", "restarted", "another module"])
def test_a_recording_and_its_export_are_judged_alike_and_a_restart_ends_a_recorded_fall(
    tmp_path: Path, kind: str
) -> None:
    path, table, restarted_s = tmp_path / "restarted.mcap", tmp_path / "out.csv", FALLS_S + 1.0
    samples = [
        StatusSample(at_s, int(tilt), force, triggered=False, active=True)
        for at_s, tilt, force in zip(FAST.tolist(), TILT, FORCE.tolist(), strict=True)
    ]
    notes = [(0.0, {"event": "connected", "port": PORT}), (restarted_s, {"event": kind})]
    write_session(path, samples, notes, start_s=0.0)
    export(entry_of(path), table)
    log = read_flight_log(path)
    assert len(log.time_s) == len(FAST)
    assert log.problems == ()
    if kind == "named":
        assert fires(log) == fires(read_flight_log(table)) == EXPECTED
    else:
        assert [source for _, source in fires(log)] == [Source.ATTITUDE] * 2
        assert log.resets_s == pytest.approx([0.0, restarted_s])
    export(entry_of(path), table, appends=True)
    with pytest.raises(UserError, match="begin again"):
        read_flight_log(table)


def test_of_several_reports_of_one_time_none_is_lost(tmp_path: Path) -> None:
    samples = [
        StatusSample(row / 50, tilt, 1.0, triggered=False, active=True) for row in range(100) for tilt in (5, 70, 5)
    ]
    path = tmp_path / "session.mcap"
    write_session(path, samples, [(0.0, {"event": "connected", "port": PORT})], start_s=0.0)
    assert len(fires(read_flight_log(path))) == 100


def test_a_folder_gives_its_logs_and_recordings(tmp_path: Path) -> None:
    folder = recorded_reports(tmp_path / "rec", [(0.0, 0.0, 1.0)])
    (tmp_path / "b").mkdir()
    for name in ("b/2.BIN", "a.ulg", "readme.txt", "picture.jpg", ".hidden", "b/x.csv", "b/strange.bbl"):
        (tmp_path / name).write_bytes(b"")
    found = [log.relative_to(tmp_path).as_posix() for log in find_logs([tmp_path])]
    assert found == ["a.ulg", "b/2.BIN", "b/strange.bbl", "b/x.csv", folder.relative_to(tmp_path).as_posix()]
    assert list(find_logs([tmp_path / "readme.txt"])) == [tmp_path / "readme.txt"]


def test_what_cannot_be_opened_keeps_no_other_log_from_being_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    good, locked, too_long = tmp_path / "a.csv", tmp_path / "locked", tmp_path / ("n" * 300 + ".csv")
    good.write_bytes(b"")
    locked.mkdir()
    scandir = os.scandir

    def refuse(path: str) -> object:
        if Path(path) == locked:
            raise PermissionError(errno.EACCES, "Permission denied", path)
        return scandir(path)

    monkeypatch.setattr(os, "scandir", refuse)  # root may list every folder
    monkeypatch.setattr(os, "listdir", refuse)
    found = list(find_logs([too_long, tmp_path]))
    assert found == [too_long, good, locked]
    for path, why in ((too_long, "name too long"), (locked, "denied")):
        with pytest.raises(UserError, match=why):
            read_flight_log(path)


# What is not believed

TIMES = np.arange(0, 200, 0.02)
LEVEL = np.full(len(TIMES), 5.0)
REST = np.ones(len(TIMES))
WHOLE, EVEN = Channel(TIMES, REST), Channel(TIMES, LEVEL)


def falls(begin_s: float, end_s: float, force_g: float = 0.1) -> Channel:
    return Channel(TIMES, np.where((begin_s <= TIMES) & (end_s > TIMES), force_g, 1.0))


def where(is_logged: np.ndarray, channel: Channel = WHOLE) -> Channel:
    return Channel(channel.time_s[is_logged], channel.values[is_logged])


def raw_log(*forces: Channel, tilt: Channel = EVEN) -> RawLog:
    return RawLog(tilts_deg=[tilt], forces_g=list(forces) or [WHOLE])


def log_of(*forces: Channel, tilt: Channel = EVEN) -> FlightLog:
    return assembled(raw_log(*forces, tilt=tilt), "x")


def first_fire(log: FlightLog) -> float | None:
    return next((at_s for at_s, _ in fires(log)), None)


def is_enough_of(log: FlightLog, limits: TriggerLimits | None = None) -> bool:
    """Whether it may be said of this log that nothing fires."""
    return FlightSummary(log).outcome(limits or TriggerLimits()).answer is not Answer.NOT_JUDGED


@pytest.mark.promise("g")
def test_a_stuck_sensor_is_not_a_fall_and_a_long_fall_is_one() -> None:
    log = log_of(falls(50, 157, 0.3))
    assert first_fire(log) is None
    assert log.not_judged_s == pytest.approx(107, abs=1.5)
    (problem,) = problems(log)
    assert problem.startswith("Acceleration sensor 1 stuck for 10")
    log = log_of(falls(50, 55, 0.3))
    assert first_fire(log) == pytest.approx(51.6)
    assert problems(log) == []


@pytest.mark.parametrize("scale", [0.3, 9.80665, 1e-3])
@pytest.mark.promise("g")
def test_a_wrong_scale_is_not_judged_and_the_plausible_sensor_is_used(scale: float) -> None:
    log = log_of(Channel(TIMES, REST * scale))
    assert first_fire(log) is None
    assert log.not_judged_s == pytest.approx(log.duration_s)
    assert "never rests at 1 g" in problems(log)[0]
    assert first_fire(log_of(Channel(TIMES, REST * scale), falls(50, 52))) == pytest.approx(51.6)


@pytest.mark.promise("g")
def test_two_sensors_that_disagree_on_a_fall_are_not_judged() -> None:
    fall = falls(50, 54)
    log = log_of(fall, WHOLE)
    assert first_fire(log) is None
    assert 3 < log.not_judged_s < 6
    assert "Acceleration sensors differ by over 0.3 g" in problems(log)[0]
    assert first_fire(log_of(fall, Channel(TIMES, fall.values + 0.1))) == pytest.approx(51.6)


@pytest.mark.promise("g")
def test_no_sample_holds_over_a_pause() -> None:
    """The log pauses in one fall and continues in another."""
    is_logged = (TIMES < 51) | (TIMES >= 53)
    log = log_of(where(is_logged, falls(50, 54)), tilt=where(is_logged, EVEN))
    assert first_fire(log) is None
    assert log.not_judged_s == pytest.approx(2.0, abs=0.05)


def test_a_clock_that_jumps_leaves_out_the_smaller_part() -> None:
    ahead, behind = TIMES.copy(), TIMES.copy()
    ahead[1000:1010] += 5e6
    behind[5000:] -= 30
    for times, left_out in ((ahead, 10), (behind, 1500)):
        log = log_of(tilt=Channel(times, LEVEL))
        assert problems(log)[0] == f"The clock jumps back; samples left out: {left_out:,}."
        assert log.duration_s == pytest.approx(199.98)
        assert log.left_out_share == pytest.approx(left_out / 10_000)


@pytest.mark.promise("g")
def test_a_tilt_between_two_rows_is_not_missed() -> None:
    """The flight controller logs it five times as often as a module reports."""
    times = np.arange(0, 60, 0.004)
    log = log_of(tilt=Channel(times, np.where((times > 30.001) & (times < 30.015), 85.0, 5.0)))
    assert fires(log) == [(30.02, Source.ATTITUDE)]
    assert FlightSummary(log).tilt_max_deg == 85.0


def test_values_that_are_not_numbers_are_left_out() -> None:
    tilt, times = LEVEL.copy(), TIMES.copy()
    tilt[100:103] = [np.nan, np.inf, -np.inf]
    times[200:204] = [np.nan, 1e300, np.inf, np.inf]
    log = log_of(tilt=Channel(times, tilt))
    assert problems(log) == ["Invalid samples left out: 7."]
    assert np.isfinite(log.tilt_deg).sum() == len(log.time_s)
    # Every seventh is missing although there is no pause.
    log = log_of(tilt=Channel(TIMES, np.where(np.arange(len(TIMES)) % 7 == 0, np.nan, LEVEL)))
    assert not len(log.gaps[0])
    assert not is_enough_of(log)


def test_quaternions_of_no_length_are_no_attitude() -> None:
    zero, one = np.zeros(2), np.array([1.0, 0.5])
    assert np.isnan(tilt_of_quaternion(zero, zero, zero, zero)).all()
    assert np.isnan(tilt_of_quaternion(one, zero, zero, zero)).tolist() == [False, True]


def test_a_log_without_attitude_and_acceleration_cannot_be_judged() -> None:
    with pytest.raises(UserError, match="no attitude and no acceleration"):
        assembled(RawLog(), "x")
    with pytest.raises(UserError, match=r"No attitude: .* never rests at 1 g \(median 9.81 g\); not judged\.$"):
        assembled(RawLog(forces_g=[Channel(TIMES, REST * 9.81)]), "x")  # else it counts as one that does not fire


# What is on the ground, and what is missing


def test_only_the_time_from_arming_to_landing_is_judged() -> None:
    raw = raw_log(tilt=Channel(TIMES, np.where((TIMES < 20) | (TIMES > 180), 90.0, 5.0)))
    for first_s in (-np.inf, 1.0):
        raw.armed, raw.problems = [Channel(np.array([first_s, 25.0, 170.0]), np.array([0.0, 1.0, 0.0]))], []
        log = assembled(raw, "x")
        assert fires(log) == []
        assert log.not_judged_s == pytest.approx(50.0, abs=0.1)
        assert problems(log) == ["Not judged: 50.0 s on the ground."]


def test_an_aircraft_that_was_disarmed_in_the_air_still_falls() -> None:
    raw = raw_log(falls(100.5, 104))
    raw.armed = [Channel(np.array([-np.inf, 10.0, 100.0]), np.array([0.0, 1.0, 0.0]))]
    assert first_fire(assembled(raw, "x")) == pytest.approx(102.1)


def test_two_sensors_and_arming_of_a_dataflash_log_and_of_a_ulog(tmp_path: Path) -> None:
    times = np.arange(0, 60, 0.04)
    fall = np.where((times >= 30) & (times < 32), 0.2, 1.0)
    rows = made.dataflash_force(times, fall, sensor=1) + made.dataflash("EV", (1.0, 51.0), (10, 11))
    logs = [read(tmp_path / "two.bin", made.dataflash_bytes(times, 5.0, 0.3, *rows))]
    rows = made.ulog("sensor_accel", times, 0, 0, -9.80665 * fall)
    rows += made.ulog("vehicle_status", (0.0, 2.0, 51.0), (1, 2, 1), 4)
    logs.append(read(tmp_path / "two.ulg", made.ulog_bytes(times, 5.0, 0.02, *rows)))
    for log, armed_s in zip(logs, (1.0, 2.0), strict=True):
        assert first_fire(log) == pytest.approx(31.6, abs=0.05)
        assert log.not_judged_s == pytest.approx(log.duration_s - 56.0 + armed_s, abs=0.1)
        assert "Acceleration sensor 1 never rests at 1 g" in problems(log)[0]


def test_a_log_that_pauses_while_it_is_disarmed_is_judged_for_its_flights() -> None:
    is_logged = (TIMES < 60) | (TIMES >= 120)
    raw = raw_log(where(is_logged), tilt=where(is_logged, EVEN))
    assert not is_enough_of(assembled(raw, "x"))
    raw.armed = [Channel(np.array([0.0, 59.9, 120.0]), np.array([1.0, 0.0, 1.0]))]
    log = assembled(raw, "x")
    assert is_enough_of(log)
    assert log.not_judged_s == pytest.approx(60.0, abs=0.1)
    raw.armed = [Channel(np.array([0.0, 150.0]), np.array([1.0, 0.0]))]
    assert not is_enough_of(assembled(raw, "x"))


def paused(channel: Channel, for_s: float) -> Channel:
    """Nothing is logged for so long after 60 s."""
    return where((channel.time_s <= 60) | (60 + for_s - 0.001 <= channel.time_s), channel)


@pytest.mark.parametrize(("force", "tilt", "is_enough"), [
    (WHOLE, paused(EVEN, 0.2), True), (WHOLE, paused(EVEN, 0.25), False),
    (paused(WHOLE, 1.4), EVEN, True), (paused(WHOLE, 1.6), EVEN, False),
    # Together with the fall that is known beside it.
    (paused(falls(59.5, 60.01), 0.8), EVEN, True), (paused(falls(59.2, 60.01), 0.8), EVEN, False),
    # Of a tenth that is missing nothing is said.
    (where(TIMES % 10 >= 0.8), EVEN, True), (where(TIMES % 10 >= 1.2), EVEN, False),
])  # fmt: skip
def test_a_pause_that_may_hide_a_tilt_or_a_fall(force: Channel, tilt: Channel, is_enough: bool) -> None:
    log = log_of(force, tilt=tilt)
    assert not fires(log)
    assert is_enough_of(log) is is_enough
    assert is_enough_of(log, TriggerLimits(freefall_is_enabled=force is WHOLE, attitude_is_enabled=tilt is EVEN))


def test_both_ends_of_a_log_are_part_of_it() -> None:
    """The attitude begins late, and the acceleration ends early."""
    log = log_of(Channel(TIMES[:-500], REST[:-500]), tilt=Channel(TIMES[1000:], LEVEL[1000:]))
    assert log.not_judged_s == pytest.approx(30.0, abs=0.05)
    assert not is_enough_of(log)
