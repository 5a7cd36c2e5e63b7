"""Cut, damaged and malicious logs give a flight or a message, in bounded memory."""

import os
import struct
import tracemalloc
import zlib
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import zstandard
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from app.captures.traffic import CaptureEntry, Way
from app.flights.flight_log import FlightLog
from app.flights.many_logs import summarise_log
from app.flights.read_log import read_flight_log
from app.flights.summary import FlightSummary
from app.recordings.library import entry_of
from app.recordings.recording import export
from app.recordings.session_file import Opening
from app.text.user_error import UserError
from protocol.messages import Status
from tests.support.flights import log_bytes as made
from tests.support.flights.made_flights import recorded_reports
from tests.support.records.recordings_made import NOON, PORT
from tests.support.records.written_sessions import write_session

TIMES = np.arange(60) / 20
EVERY = 1 if settings().max_examples > 100 else 37
"""Of the bytes of a recording, all in a thorough run."""
FLIPS = (0x20, 0x01, 0xFF, 0x10, 0x80)
MEGABYTE = 1 << 20
ULOG = b"ULog\x01\x12\x35\x01" + bytes(8)
Insertions = st.lists(st.tuples(st.floats(0, 1), st.binary(min_size=1, max_size=8)), max_size=4)


def ulog(_folder: Path) -> bytes:
    rows = made.ulog_attitude(TIMES, 20 * TIMES) + made.ulog_force(TIMES, 1.0) + made.ulog_second_force(TIMES, 1.0)
    rows += made.ulog_status((0.0, 2, 1), (2.0, 1, 2))
    return made.ulog_bytes(rows + made.ulog_altitude(TIMES, 5.0))


def dataflash(_folder: Path) -> bytes:
    rows = made.dataflash_attitude(TIMES, 20 * TIMES) + made.dataflash_force(TIMES, 1.0)
    rows += made.dataflash_events((0.5, 10), (2.0, 11)) + made.dataflash_modes((0.1, 3))
    return made.dataflash_bytes(rows + made.dataflash_altitude(TIMES, 5.0) + made.dataflash_message(0.0, "ArduCopter"))


def mcap(folder: Path) -> bytes:
    return recorded_reports(folder, [(float(at_s), 20 * float(at_s), 1.0) for at_s in TIMES]).read_bytes()


def csv(folder: Path) -> bytes:
    path = folder / "session.mcap"
    path.write_bytes(mcap(folder))
    export(entry_of(path), folder / "out.csv", is_table=True)
    return (folder / "out.csv").read_bytes()


@pytest.fixture(scope="module")
def originals(tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    kinds: tuple[Callable[[Path], bytes], ...] = (ulog, dataflash, mcap, csv)
    return {kind.__name__: kind(tmp_path_factory.mktemp(kind.__name__)) for kind in kinds}


def damaged(data: bytes, cut: float, changes: list[tuple[float, bytes]]) -> bytes:
    changed = bytearray(data[: int(len(data) * cut)])
    for place, new in changes:
        start = int(len(changed) * place)
        changed[start : start + len(new)] = new
    return bytes(changed)


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


@pytest.mark.parametrize("kind", ["ulog", "dataflash", "mcap", "csv"])
@settings(max_examples=120, suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
@given(cut=st.one_of(st.just(1.0), st.floats(0, 1)), changes=Insertions)
@pytest.mark.promise("g")
def test_cut_and_damaged_files(
    kind: str, originals: dict[str, bytes], tmp_path: Path, cut: float, changes: list[tuple[float, bytes]]
) -> None:
    path = tmp_path / ("log.csv" if kind == "csv" else "log")
    path.write_bytes(damaged(originals[kind], cut, changes))
    check(path)


def reports_of(path: Path, data: bytes) -> tuple[list[float], FlightLog | None]:
    """The tilts that are read of a recording; no log where it is refused."""
    path.write_bytes(data)
    try:
        log = read_flight_log(path)
    except UserError:
        return [], None
    finally:
        path.unlink()
    return log.tilt_deg.tolist(), log


@pytest.fixture(scope="module")
def session(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """A recording of several chunks, whose tilt is another in each report."""
    path = tmp_path_factory.mktemp("session") / "session.mcap"
    entries = [
        CaptureEntry(number / 20, Way.IN, Status(number, 1.0, triggered=False, active=True).encode())
        for number in range(80)
    ]
    opening = Opening(started_at=NOON, start_s=0.0, port=PORT, baud_rate=115200)
    write_session(path, opening, entries, [(0.0, {"event": "connected", "port": PORT})])
    return path.read_bytes()


@pytest.mark.promise("g")
def test_a_recording_that_is_cut_anywhere_is_read_up_to_there_and_says_so(session: bytes, tmp_path: Path) -> None:
    whole, _ = reports_of(tmp_path / "whole.mcap", session)
    assert len(whole) == 80
    read_before = 0
    for stop in range(0, len(session), EVERY):
        found, log = reports_of(tmp_path / f"{stop}.mcap", session[:stop])
        assert found == whole[: len(found)], stop
        assert len(found) >= read_before, stop
        assert found == whole or log is None or log.problems, stop
        read_before = len(found)
    assert read_before == len(whole)


@pytest.mark.promise("g")
def test_a_flipped_byte_in_a_recording_costs_nothing_before_it_and_is_said(session: bytes, tmp_path: Path) -> None:
    whole, _ = reports_of(tmp_path / "whole.mcap", session)
    for place in range(0, len(session), EVERY):
        before, _ = reports_of(tmp_path / f"{place}-cut.mcap", session[:place])
        changed = bytearray(session)
        changed[place] ^= FLIPS[place % len(FLIPS)]
        found, log = reports_of(tmp_path / f"{place}.mcap", bytes(changed))
        if log is None:  # the heading, without which nobody knows what it is
            assert before == [], place
            continue
        assert found[: len(before)] == before, place
        assert set(found) <= set(whole), place
        if found != whole:
            assert log.problems, place
            # Up to four reports of 20 a second are no pause in which a tilt may hide.
            assert log.not_judged_s > 0 or len(found) >= len(whole) - 4, place


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


def mcap_record(kind: int, body: bytes) -> bytes:
    return bytes((kind,)) + struct.pack("<Q", len(body)) + body


def mcap_chunk(unpacked: bytes, *, claims: int | None = None) -> bytes:
    packed = zstandard.ZstdCompressor(level=1).compress(unpacked)
    size = len(unpacked) if claims is None else claims
    head = struct.pack("<QQQI", 0, 0, size, zlib.crc32(unpacked)) + struct.pack("<I4s", 4, b"zstd")
    return mcap_record(6, head + struct.pack("<Q", len(packed)) + packed)


@pytest.mark.parametrize("claims", [None, 10, 1 << 60])
@pytest.mark.promise("g")
def test_a_chunk_that_unpacks_to_more_than_it_may(tmp_path: Path, claims: int | None) -> None:
    path = tmp_path / "bomb.mcap"
    path.write_bytes(b"\x89MCAP0\r\n" + mcap_chunk(bytes(80 * MEGABYTE), claims=claims))
    assert peak_bytes(path) < 8 * MEGABYTE


def test_an_mcap_file_of_another_program(tmp_path: Path) -> None:
    channel = struct.pack("<HHI4s", 1, 0, 4, b"/imu") + bytes(8)
    path = tmp_path / "other.mcap"
    path.write_bytes(b"\x89MCAP0\r\n" + mcap_record(4, channel))
    with pytest.raises(UserError, match="not a recording by this program"):
        read_flight_log(path)


def deep_formats() -> bytes:
    """Each level contains the next thousands of times."""
    records = b"".join(
        made.ulog_record("F", f"t{level}:{''.join(f't{level + 1} f{n};' for n in range(4000))}".encode())
        for level in range(20)
    )
    records += made.ulog_record("F", b"t20:") + made.ulog_record("F", b"vehicle_attitude:uint64_t timestamp;t0 a;")
    return ULOG + records + made.ulog_record("A", struct.pack("<BH", 0, 1) + b"vehicle_attitude") * 1000


def many_subscriptions() -> bytes:
    records = made.ulog_record("F", b"vehicle_attitude:uint64_t timestamp;float[4] q;")
    return ULOG + records + made.ulog_record("A", struct.pack("<BH", 0, 1) + b"vehicle_attitude") * 20_000


def times_years_apart() -> bytes:
    times = np.arange(200) * 3e7
    return made.ulog_bytes(made.ulog_attitude(times, 5.0) + made.ulog_force(times, 1.0))


def rubbish_like_samples() -> bytes:
    return ulog(Path()) + b"D" * (4 * MEGABYTE)


def rubbish_like_records() -> bytes:
    return dataflash(Path()) + b"\xa3\x95" * (2 * MEGABYTE)


def a_line_without_end() -> bytes:
    return b"t_s,tilt_deg\n" + b"1,2," * (2 * MEGABYTE)


@pytest.mark.parametrize(("make", "megabytes"), [
    (deep_formats, 16), (many_subscriptions, 8), (times_years_apart, 8), (rubbish_like_samples, 48),
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


def test_a_folder_that_is_no_recording_and_a_recording_that_is_damaged(tmp_path: Path) -> None:
    (tmp_path / "empty").mkdir()
    with pytest.raises(UserError):
        read_flight_log(tmp_path / "empty")
    path = recorded_reports(tmp_path / "rec", [(float(at_s), 5.0, 1.0) for at_s in TIMES])
    path.write_bytes(path.read_bytes().replace(b"/dev/ttyUSB0", b"/dev/ttyUSB1"))
    with pytest.raises(UserError, match="damaged"):
        read_flight_log(path)
