"""Every kind of file that people drop: read alike, or refused by name; folders, archives, damage, bounded memory."""

import gzip
import io
import os
import struct
import tracemalloc
import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.flights.flight_log import FlightLog
from app.flights.judge import TriggerLimits
from app.flights.judging import Answer, FlightSummary
from app.flights.read_log import distinct_names, find_logs, read_flight_log, summarise_log
from app.text.messages import UserError
from tests.support.flights import log_bytes as made

TIMES = np.arange(0, 8, 0.04)
REST = np.ones(len(TIMES))
FALL = np.where((TIMES >= 2) & (TIMES < 6), 0.1, 1.0)
LEVEL = np.full(len(TIMES), 5.0)
TIPPED = np.where(TIMES >= 3, 75.0, 5.0)
STAMPS = TIMES + 100.0
MEGABYTE = 1 << 20
ULOG = b"ULog\x01\x12\x35\x01" + bytes(8)


def telemetry_1(times: np.ndarray, tilt: np.ndarray, force: np.ndarray) -> bytes:
    return made.telemetry_bytes(times, tilt, force, version=1)


def table(times: np.ndarray, tilt: np.ndarray, force: np.ndarray) -> bytes:
    rows = "".join(f"{at_s:.3f},{one:.2f},{other:.3f}\n" for at_s, one, other in zip(times, tilt, force, strict=True))
    return f"time_s,tilt_deg,acceleration_g\n{rows}".encode()


def packed_table(*flight: np.ndarray) -> bytes:
    return gzip.compress(table(*flight), mtime=0)


Make = Callable[..., bytes]
KINDS: tuple[Make, ...] = (
    made.ulog_bytes, made.dataflash_bytes, made.dataflash_text, made.telemetry_bytes, telemetry_1, table,
)  # fmt: skip


def read(path: Path, data: bytes) -> FlightLog:
    path.write_bytes(data)
    return read_flight_log(path)


def answer(log: FlightLog) -> Answer:
    return FlightSummary(log).outcome(TriggerLimits()).answer


def packed(members: dict[str, bytes]) -> bytes:
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        for member, data in members.items():
            archive.writestr(member, data)
        archive.writestr("__MACOSX/._x", b"junk")
    return file.getvalue()


@pytest.mark.parametrize("kind", KINDS)
def test_each_kind_is_known_by_its_first_bytes_also_packed(tmp_path: Path, kind: Make) -> None:
    for tilt, force, expected in (
        (LEVEL, FALL, Answer.FIRES), (TIPPED, REST, Answer.FIRES), (LEVEL, REST, Answer.DOES_NOT_FIRE),
    ):  # fmt: skip
        data = kind(STAMPS, tilt, force)
        for name, content in (
            ("log", data), ("log.bin", data), ("a.gz", gzip.compress(data)), ("a.zip", packed({"log.txt": data})),
        ):  # fmt: skip
            (tmp_path / name).write_bytes(content)
            (path,) = find_logs([tmp_path / name])
            log = read_flight_log(path)
            assert answer(log) is expected
            assert (log.problems, log.name) == ((), str(path))
            assert log.duration_s == pytest.approx(7.96, abs=0.01)


def test_an_archive_of_several_logs_is_like_a_folder(tmp_path: Path) -> None:
    path = tmp_path / "all.zip"
    path.write_bytes(
        packed({f"{name}.ulg": made.ulog_bytes(STAMPS, tilt, REST) for name, tilt in (("a", TIPPED), ("b", LEVEL))})
    )
    paths = list(find_logs([path]))
    assert paths == [path / "a.ulg", path / "b.ulg"]
    assert [answer(read_flight_log(one)) for one in paths] == [Answer.FIRES, Answer.DOES_NOT_FIRE]
    assert distinct_names(paths) == ["a.ulg", "b.ulg"]
    assert distinct_names([*paths, tmp_path / "a.ulg"]) == [str(path / "a.ulg"), "b.ulg", str(tmp_path / "a.ulg")]


@pytest.mark.parametrize(
    ("name", "data", "said"),
    [
        ("a.bbl", b"H Product:Blackbox flight data recorder by Nicholas Sherlock\n", "blackbox_decode"),
        ("a.bfl", b"\x00\x01\x02\xff" * 50, "blackbox_decode"),
        ("DJIFlightRecord.DAT", bytes(16) + b"BUILD 2016" + bytes(90), "DJI"),
        ("a.ulg", b"\n<!DOCTYPE html><html><body>Not found</body></html>", "web page"),
        ("a.ulg", b"version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\nsize 12345\n", "Git LFS"),
        ("a.xyz", bytes(range(256)) * 4, "nknown kind of file"),
        ("empty.csv", b"", "This file is empty."),
        ("a.mcap.gz", gzip.compress(b"\x89MCAP0\r\n", mtime=0), "packed recording: unpack it"),
        ("a.zip", packed({"[Content_Types].xml": b"<x/>", "xl/workbook.xml": b"<x/>"}), "spreadsheet"),
        ("a.zip", gzip.compress(b"x" * 5000, mtime=0)[:30], "damaged, or encrypted"),
        ("a.zip", b"PK\x03\x04rubbish", "damaged, or encrypted"),
        ("a.zip", packed({}), "no file in the archive"),
        ("a.zip", packed({"x": b""}).replace(b"\0x", b"\0\0"), "no file in the archive|damaged"),  # without a name
        ("a", b"\x89MCAP0\r\n\x01" + struct.pack("<QI4sI", 12, 4, b"ros2", 0), "not a recording by this program"),
        ("a", ULOG + made.ulog_record("B", bytes(8) + b"\x02" + bytes(31)), "newer version"),
    ],
)  # fmt: skip
def test_what_is_no_log_is_refused_by_name(tmp_path: Path, name: str, data: bytes, said: str) -> None:
    with pytest.raises(UserError, match=said) as caught:
        read(tmp_path / name, data)
    # With the list of what is read, unless it is an archive or of a known kind.
    assert (".ulg" in str(caught.value)) is (name not in ("a", "a.zip"))


def test_two_vehicles_in_one_telemetry_file_are_not_judged_as_one(tmp_path: Path) -> None:
    def read_with(*more: made.Row) -> FlightLog:
        return read(tmp_path / "a.tlog", made.telemetry_bytes(TIMES, LEVEL, REST, *more))

    with pytest.raises(UserError, match="more than one vehicle"):
        read_with(made.telemetry("ATTITUDE", 1.0, 1000, 1.5, 0, 0, 0, 0, 0, system=2))
    gimbal = made.telemetry("ATTITUDE", 1.0, 1000, 1.5, 0, 0, 0, 0, 0, component=154)
    assert answer(read_with(gimbal)) is not Answer.FIRES
    # Another system without an attitude is no vehicle, and whether it is armed does not matter.
    other = made.telemetry("HEARTBEAT", 0.0, 0, 2, 3, 0x80, 4, 3, system=2)
    log = read_with(other, made.telemetry_heartbeat(2.0, is_armed=False))
    assert answer(log) is Answer.DOES_NOT_FIRE
    assert log.problems == ()


def test_telemetry_before_arming_is_not_judged(tmp_path: Path) -> None:
    beats = (made.telemetry_heartbeat(float(at_s), is_armed=at_s >= 3) for at_s in range(8))
    log = read(tmp_path / "a.tlog", made.telemetry_bytes(TIMES, np.where(TIMES < 2, 80.0, 5.0), REST, *beats))
    assert answer(log) is Answer.DOES_NOT_FIRE
    assert log.not_judged_s == pytest.approx(3.0, abs=0.1)


# Damage

SMALL = np.arange(0, 4, 0.1)
EVERY = 1 if settings().max_examples > 100 else 13
"""Of the bytes, all in a thorough run. No record has a length of which this is a factor."""
FLIPS = (0x20, 0x01, 0xFF, 0x10, 0x80)
KEEPS_FALLING = np.where(SMALL >= 0.6, 0.1, 1.0)
"""From 0.6 s to the end: one sample that is damaged leaves enough of the fall to fire."""


def judged(path: Path, data: bytes) -> tuple[Answer, float, float]:
    """The answer, the time that is not judged, and the length of the log."""
    path.write_bytes(data)
    try:
        log = read_flight_log(path)
    except UserError:
        return Answer.UNREADABLE, 0.0, 0.0
    return answer(log), log.not_judged_s, log.duration_s


SMALL_KINDS = (*(kind for kind in KINDS if kind is not telemetry_1), packed_table)


@pytest.mark.parametrize("kind", SMALL_KINDS)
@pytest.mark.promise("g")
def test_no_damaged_byte_makes_a_no_of_a_flight_that_fires(tmp_path: Path, kind: Make) -> None:
    """Unless the time that is missing is said."""
    path = tmp_path / "log"
    tilted = np.where(SMALL >= 0.6, 80.0, 5.0)
    for data in (kind(SMALL, tilted, np.ones(40)), kind(SMALL, np.full(40, 5.0), KEEPS_FALLING)):
        assert judged(path, data)[0] is Answer.FIRES
        lies: list[int] = []
        for place in range(0, len(data), EVERY):
            changed = bytearray(data)
            changed[place] ^= FLIPS[place % len(FLIPS)]
            found, missing_s, _ = judged(path, bytes(changed))
            if found is Answer.DOES_NOT_FIRE and missing_s < 0.2:
                lies.append(place)
        assert lies == []


@pytest.mark.parametrize("kind", SMALL_KINDS)
def test_a_file_that_is_cut_anywhere_is_judged_up_to_there(tmp_path: Path, kind: Make) -> None:
    path = tmp_path / "log"
    data = kind(SMALL, np.where(SMALL >= 2, 80.0, 5.0), np.ones(40))
    for stop in range(0, len(data), EVERY):
        found, _, lasts_s = judged(path, data[:stop])
        if found is Answer.DOES_NOT_FIRE:
            assert lasts_s < 2.05, stop


def test_damage_costs_one_record_of_a_ulog(tmp_path: Path) -> None:
    """A file without sync records lost all that followed."""
    data = bytearray(made.ulog_bytes(STAMPS, TIPPED, REST))
    place = len(data) // 5
    data[place : place + 40] = bytes(40)
    log = read(tmp_path / "a.ulg", bytes(data))
    assert log.not_judged_s < 0.4
    assert answer(log) is Answer.FIRES
    assert any("bytes left out" in problem.in_english() for problem in log.problems)


def test_a_sample_of_a_ulog_that_is_shorter_than_its_topic_is_none(tmp_path: Path) -> None:
    """What stands behind it would be read as its end: an acceleration of nearly nothing."""
    ((at_s, whole),) = made.ulog("sensor_combined", STAMPS[50], 0, 0, 0, 5.88, 0, -7.85, 0)
    short = at_s, made.ulog_record("D", whole[3:-13])
    log = read(tmp_path / "a.ulg", made.ulog_bytes(STAMPS, LEVEL, REST, short))
    assert log.specific_force_g == pytest.approx(1.0, abs=0.01)


def test_a_lost_end_is_not_judged(tmp_path: Path) -> None:
    for kind in (made.ulog_bytes, made.dataflash_bytes, made.dataflash_text, made.telemetry_bytes):
        data = kind(STAMPS, LEVEL, REST)
        half = len(data) * 6 // 10
        log = read(tmp_path / "log", data[:half] + bytes(len(data) - half))
        assert answer(log) is Answer.NOT_JUDGED
        assert 2.0 < log.not_judged_s < 5.0


def test_what_others_say_at_the_end_is_no_lost_end(tmp_path: Path) -> None:
    """As the ground station itself, where the vehicle is out of reach or switched off."""
    beats = (made.telemetry("HEARTBEAT", at_s, 0, 6, 8, 0, 4, 3, system=255, component=190) for at_s in range(60))
    lines = "MSG, 0, a text\r\n" * 2000
    for data in (
        made.telemetry_bytes(STAMPS, LEVEL, REST) + made.in_order(beats),
        made.dataflash_text(STAMPS, LEVEL, REST) + lines.encode(),
    ):
        log = read(tmp_path / "log", data)
        assert answer(log) is Answer.DOES_NOT_FIRE
        assert (log.duration_s, log.problems) == (pytest.approx(7.96, abs=0.01), ())


def test_a_damaged_message_of_telemetry_is_no_measurement(tmp_path: Path) -> None:
    data = bytearray(made.telemetry_bytes(TIMES, LEVEL, REST))
    _, message = made.telemetry("ATTITUDE", TIMES[60], TIMES[60] * 1e3, np.radians(5.0), 0, 1.2, 0, 0, 0)
    place = data.index(message) + 8 + 10 + 4  # the roll, behind stamp, head and time
    data[place : place + 4] = np.float32(1.5).tobytes()
    log = read(tmp_path / "a.tlog", bytes(data))
    assert answer(log) is Answer.DOES_NOT_FIRE
    assert float(np.nanmax(log.tilt_deg)) < 10


# Hostile files


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
@settings(max_examples=150)
def test_files_that_only_begin_like_a_log(tmp_path: Path, data: bytes, begin: bytes) -> None:
    path = tmp_path / "log.csv"
    path.write_bytes(begin + data)
    check(path)


SUBSCRIPTION = made.ulog_record("A", struct.pack("<BH", 0, 1) + b"vehicle_attitude")
BOMBS: dict[str, tuple[Callable[[], bytes], int]] = {
    "many subscriptions": (lambda: made.ulog_bytes([], [], []) + SUBSCRIPTION * 20_000, 8),
    "times years apart": (lambda: made.ulog_bytes(np.arange(200) * 3e7, LEVEL, REST), 8),
    "rubbish like samples": (lambda: made.ulog_bytes(STAMPS, LEVEL, REST) + b"D" * (4 * MEGABYTE), 48),
    "rubbish like records": (lambda: made.dataflash_bytes(STAMPS, LEVEL, REST) + b"\xa3\x95" * (2 * MEGABYTE), 24),
    "a line without end": (lambda: b"t_s,tilt_deg\n" + b"1,2," * (2 * MEGABYTE), 20),
    # Read as a whole, they would also hold the interpreter, and with it the thread of the port.
    "a long table": (
        lambda: b"t_s,tilt_deg,note\n" + b"".join(b"%d.5,2,%b\n" % (row, b"n" * 200) for row in range(20_000)),
        12,
    ),
    "a long text": (lambda: made.dataflash_text(np.arange(15_000) / 50, np.ones(15_000), np.ones(15_000)), 10),
}


@pytest.mark.parametrize("bomb", BOMBS)
@pytest.mark.promise("g")
def test_memory_is_bounded(tmp_path: Path, bomb: str) -> None:
    path, (make, megabytes) = tmp_path / "log", BOMBS[bomb]
    path.write_bytes(make())
    tracemalloc.start()
    try:
        check(path)
        assert tracemalloc.get_traced_memory()[1] < megabytes * MEGABYTE
    finally:
        tracemalloc.stop()


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


def test_a_ulog_whose_data_go_on_at_its_end(tmp_path: Path) -> None:
    """As PX4 appends data after a crash: the last record is cut."""
    times = np.arange(60) / 20
    cut = made.ulog_bytes(times, 5.0, 1.0)[:-7]
    more = made.ulog_bytes(times + 3.05, 70.0, 1.0).removeprefix(made.ulog_bytes([], [], []))
    appended = cut.replace(bytes(40), bytes(8) + b"\x01" + bytes(7) + struct.pack("<3Q", len(cut), 0, 0), 1)
    path = tmp_path / "appended.ulg"
    path.write_bytes(appended + more)
    flight = check(path)
    assert flight is not None
    assert flight.duration_s == pytest.approx(6.0, abs=0.1)
    assert flight.tilt_max_deg == pytest.approx(70)
