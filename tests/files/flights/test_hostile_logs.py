"""Cut, damaged and malicious logs give a flight or a message, in bounded memory."""

import os
import struct
import tracemalloc
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from app.flights.flight_log import FlightLog
from app.flights.judging import FlightSummary
from app.flights.read_log import read_flight_log, summarise_log
from app.text.messages import UserError
from tests.support.flights import log_bytes as made

TIMES = np.arange(60) / 20
MEGABYTE = 1 << 20
ULOG = b"ULog\x01\x12\x35\x01" + bytes(8)


def ulog() -> bytes:
    rows = made.ulog_attitude(TIMES, 20 * TIMES) + made.ulog_force(TIMES, 1.0) + made.ulog_second_force(TIMES, 1.0)
    rows += made.ulog_status((0.0, 2, 1), (2.0, 1, 2))
    return made.ulog_bytes(rows + made.ulog_altitude(TIMES, 5.0))


def dataflash() -> bytes:
    rows = made.dataflash_attitude(TIMES, 20 * TIMES) + made.dataflash_force(TIMES, 1.0)
    rows += made.dataflash_events((0.5, 10), (2.0, 11)) + made.dataflash_modes((0.1, 3))
    return made.dataflash_bytes(rows + made.dataflash_altitude(TIMES, 5.0) + made.dataflash_message(0.0, "ArduCopter"))


def check(path: Path) -> FlightSummary | None:
    """Checks what holds for every log."""
    found = summarise_log(path)
    if found.flight is None:
        assert found.why_not is not None
        assert found.why_not.in_english().endswith(".")
        return None
    log = read_flight_log(path)
    assert isinstance(log, FlightLog)
    assert (np.diff(log.time_s) >= 0).all()
    assert len({len(log.time_s), len(log.tilt_deg), len(log.specific_force_g), len(log.is_judged)}) == 1
    known = log.tilt_deg[np.isfinite(log.tilt_deg)]
    assert len(known) == 0 or (known.min() >= 0)
    assert 0 <= log.not_judged_s <= log.duration_s + 1e-6
    assert len(log.time_s) <= 60 * len(path.read_bytes())
    return found.flight


@given(
    st.binary(max_size=400), st.sampled_from([b"ULog\x01\x12\x35\x01" + bytes(8), b"\xa3\x95", b"\x89MCAP0\r\n", b""])
)
@settings(max_examples=150, suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
def test_files_that_only_begin_like_a_log(tmp_path: Path, data: bytes, begin: bytes) -> None:
    path = tmp_path / "log.csv"
    path.write_bytes(begin + data)
    check(path)


def peak_bytes(path: Path) -> int:
    tracemalloc.start()
    try:
        check(path)
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


def test_an_mcap_file_of_another_program(tmp_path: Path) -> None:
    path = tmp_path / "other.mcap"
    path.write_bytes(b"\x89MCAP0\r\n\x01" + struct.pack("<QI4sI", 12, 4, b"ros2", 0))
    with pytest.raises(UserError, match="not a recording by this program"):
        read_flight_log(path)


def many_subscriptions() -> bytes:
    records = made.ulog_record("F", b"vehicle_attitude:uint64_t timestamp;float[4] q;")
    return ULOG + records + made.ulog_record("A", struct.pack("<BH", 0, 1) + b"vehicle_attitude") * 20_000


def times_years_apart() -> bytes:
    times = np.arange(200) * 3e7
    return made.ulog_bytes(made.ulog_attitude(times, 5.0) + made.ulog_force(times, 1.0))


def rubbish_like_samples() -> bytes:
    return ulog() + b"D" * (4 * MEGABYTE)


def rubbish_like_records() -> bytes:
    return dataflash() + b"\xa3\x95" * (2 * MEGABYTE)


def a_line_without_end() -> bytes:
    return b"t_s,tilt_deg\n" + b"1,2," * (2 * MEGABYTE)


@pytest.mark.parametrize(("make", "megabytes"), [
    (many_subscriptions, 8), (times_years_apart, 8), (rubbish_like_samples, 48),
    (rubbish_like_records, 24), (a_line_without_end, 60),
])  # fmt: skip
@pytest.mark.promise("g")
def test_memory_is_bounded(tmp_path: Path, make: Callable[[], bytes], megabytes: int) -> None:
    path = tmp_path / "log"
    path.write_bytes(make())
    assert peak_bytes(path) < megabytes * MEGABYTE


@pytest.mark.skipif(os.name == "nt", reason="Windows has no named pipes in folders")
def test_a_pipe_is_not_waited_for(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "log.bin")
    with pytest.raises(UserError):
        read_flight_log(tmp_path / "log.bin")


def test_a_file_that_is_too_large_is_not_read(tmp_path: Path) -> None:
    path = tmp_path / "large.ulg"
    path.write_bytes(b"ULog\x01\x12\x35\x01")
    os.truncate(path, (1 << 30) + 1)  # sparse: takes no space
    with pytest.raises(UserError, match="too large"):
        read_flight_log(path)


def test_a_newer_ulog_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "new.ulg"
    path.write_bytes(b"ULog\x01\x12\x35\x01" + bytes(8) + made.ulog_record("B", bytes(8) + b"\x02" + bytes(31)))
    with pytest.raises(UserError, match="newer version"):
        read_flight_log(path)


def test_a_ulog_whose_data_go_on_at_its_end(tmp_path: Path) -> None:
    """As PX4 appends data after a crash: the last record is cut."""
    rows = made.ulog_attitude(TIMES, 5.0) + made.ulog_force(TIMES, 1.0)
    data = made.ulog_bytes(rows)
    cut = data[:-7]
    more = b"".join(row for _, row in made.ulog_attitude(TIMES + 3.05, 70.0) + made.ulog_force(TIMES + 3.05, 1.0))
    appended = cut.replace(bytes(40), bytes(8) + b"\x01" + bytes(7) + struct.pack("<3Q", len(cut), 0, 0), 1)
    path = tmp_path / "appended.ulg"
    path.write_bytes(appended + more)
    flight = check(path)
    assert flight is not None
    assert flight.duration_s == pytest.approx(6.0, abs=0.1)
    assert flight.tilt_max_deg == pytest.approx(70)
