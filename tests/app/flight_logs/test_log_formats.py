"""Logs of every kind with known contents: times, tilt, acceleration, arming, landing, altitude."""

from pathlib import Path

import numpy as np
import pytest

from app.firing.judge import TriggerLimits
from app.flight_analysis.judged_flight import judge_flight
from app.flight_logs.csv_columns import CsvColumns, CsvRole, parse_choice
from app.flight_logs.flight_log import FlightLog
from app.flight_logs.read_log import find_logs, read_flight_log
from app.recordings.export import export
from app.recordings.library import entry_of
from app.text.user_error import UserError
from protocol.messages import Source
from tests.support.flights import log_bytes as made
from tests.support.flights.recorded_flight import recorded_reports

STARTS_S = 73.0
"""Of the flight controller's clock."""
RATE_HZ = 100
FAST = np.arange(1000) / RATE_HZ
TIPS_S, FALLS_S, LANDS_S = 4.0, 6.0, 7.75
TILT = np.where(FAST >= TIPS_S, 61.0, 12.0)
FORCE = np.where((FAST >= FALLS_S) & (FAST < LANDS_S), 0.3, 1.0)


def read(path: Path, data: bytes) -> FlightLog:
    path.write_bytes(data)
    return read_flight_log(path)


def fires(log: FlightLog) -> list[tuple[float, Source]]:
    return [(round(one.at_s, 6), one.sources) for one in judge_flight(log, TriggerLimits()).firings]


EXPECTED = [(TIPS_S, Source.ATTITUDE), (FALLS_S + 1.6, Source.FREEFALL)]


def test_a_ulog_is_judged(tmp_path: Path) -> None:
    rows = made.ulog_attitude(STARTS_S + FAST, TILT) + made.ulog_force(STARTS_S + FAST, FORCE)
    rows += made.ulog_altitude(STARTS_S + FAST[::10], 50 - FAST[::10])
    rows += made.ulog_status((STARTS_S, 2, 2), (STARTS_S + 3, 2, 5))
    log = read(tmp_path / "flight.ulg", made.ulog_bytes(rows))
    assert fires(log) == EXPECTED
    assert log.duration_s == pytest.approx(9.99)
    assert log.not_judged_s == pytest.approx(0.0, abs=0.02)
    assert log.altitude_m is not None
    assert log.altitude_m[log.time_s == 4.0] == pytest.approx(46.0, abs=0.05)
    assert log.problems == ()


@pytest.mark.parametrize(("clock", "per_us"), [(b"TimeUS", 1), (b"TimeMS", 1e-3)])
def test_a_dataflash_log_is_judged(tmp_path: Path, clock: bytes, per_us: float) -> None:
    times = (STARTS_S + FAST) * per_us
    rows = made.dataflash_attitude(times, TILT) + made.dataflash_force(times, FORCE)
    rows += made.dataflash_altitude(times[::10], 50 - FAST[::10])
    rows += made.dataflash_message(times[0], "ArduCopter V4.5.1") + made.dataflash_modes((times[100], 5))
    log = read(tmp_path / "00000012.BIN", made.dataflash_bytes(rows).replace(b"TimeUS", clock))
    assert fires(log) == EXPECTED
    assert log.altitude_m is not None
    assert log.altitude_m[log.time_s == 4.0] == pytest.approx(46.0, abs=0.05)
    assert log.problems == ()


def test_a_slow_log_is_judged_at_its_own_samples(tmp_path: Path) -> None:
    """Attitude at 10 Hz, acceleration at 25 Hz: a row holds the newest sample of each."""
    slow = np.arange(100) / 10
    rows = made.dataflash_attitude(slow, np.where(slow >= 4.05, 75.0, 0.0))
    rows += made.dataflash_force(FAST[::4], FORCE[::4])
    log = read(tmp_path / "a.bin", made.dataflash_bytes(rows))
    assert fires(log) == [(4.1, Source.ATTITUDE), (7.6, Source.FREEFALL)]


def write_csv(path: Path, head: str, *columns: np.ndarray[tuple[int, ...], np.dtype[np.float64]]) -> Path:
    lines = [head, *(",".join(f"{cell:.6f}" for cell in row) for row in np.column_stack(columns).tolist())]
    path.write_text("\n".join(lines), encoding="utf-8")
    return path


def test_a_csv_file_with_recognised_columns(tmp_path: Path) -> None:
    path = write_csv(tmp_path / "a.csv", "t_s,tilt_deg,acceleration_g", FAST + STARTS_S, TILT, FORCE)
    assert fires(read_flight_log(path)) == EXPECTED


def test_a_csv_file_with_chosen_columns(tmp_path: Path) -> None:
    axis = FORCE * 9.80665
    path = write_csv(tmp_path / "a.csv", "when;ATT.Roll;p;ax;ay;az".replace(";", ","),
                     FAST * 1000, np.radians(TILT), 0 * FAST, 0 * FAST, 0.6 * axis, 0.8 * axis)  # fmt: skip
    with pytest.raises(UserError):
        read_flight_log(path)
    chosen = parse_choice(["time_ms=when", "roll_rad=ATT.Roll", "pitch_rad=p", "x_m_s2=ax", "y_m_s2=ay", "z_m_s2=az"])
    assert fires(read_flight_log(path, chosen)) == EXPECTED


@pytest.mark.parametrize(
    "words",
    [["time_s"], ["speed=a"], ["time_s=t", "time_ms=u", "tilt_deg=x"], ["time_s=t"], ["tilt_deg=x"], ["time_s="]],
)
def test_an_insufficient_choice_of_columns_is_refused(words: list[str]) -> None:
    with pytest.raises(UserError):
        parse_choice(words)


def test_a_column_that_is_not_there_is_named(tmp_path: Path) -> None:
    path = write_csv(tmp_path / "a.csv", "t_s,tilt_deg", FAST, TILT)
    with pytest.raises(UserError, match="No column “roll”"):
        read_flight_log(path, CsvColumns({CsvRole.TIME_S: "t_s", CsvRole.TILT_DEG: "roll"}))


def test_a_csv_file_without_acceleration_is_judged_for_its_attitude_alone(tmp_path: Path) -> None:
    log = read_flight_log(write_csv(tmp_path / "a.csv", "t_s,tilt_deg", FAST, TILT))
    assert fires(log) == EXPECTED[:1]
    assert log.not_judged_s == log.duration_s
    assert [one.in_english() for one in log.problems] == ["No acceleration: free-fall trigger not judged."]


def test_recordings_and_their_exports_are_judged_alike(tmp_path: Path) -> None:
    folder = recorded_reports(tmp_path, zip(FAST.tolist(), TILT.tolist(), FORCE.tolist(), strict=True))
    export(entry_of(folder), tmp_path / "out.csv", is_table=True)
    logs = [read_flight_log(one) for one in (folder, tmp_path / "out.csv")]
    for log in logs:
        assert len(log.time_s) == len(FAST)
        assert fires(log) == EXPECTED
        assert log.problems == ()


def test_a_folder_gives_its_logs_and_recordings(tmp_path: Path) -> None:
    folder = recorded_reports(tmp_path / "rec", [(0.0, 0.0, 1.0)])
    (tmp_path / "b").mkdir()
    for name in ("b/2.BIN", "a.ulg", "readme.txt", "b/x.csv"):
        (tmp_path / name).write_bytes(b"")
    found = [one.relative_to(tmp_path).as_posix() for one in find_logs([tmp_path])]
    assert found == ["a.ulg", "b/2.BIN", "b/x.csv", folder.relative_to(tmp_path).as_posix()]
    assert list(find_logs([tmp_path / "readme.txt"])) == [tmp_path / "readme.txt"]
