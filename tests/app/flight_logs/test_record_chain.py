"""Runs of records found with numpy equal those found by single steps."""

import struct
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.flight_logs import dataflash_file, ulog_file
from app.flight_logs.dataflash import TABLES
from app.flight_logs.dataflash_file import DataflashFile
from app.flight_logs.record_chain import positions
from app.flight_logs.ulog import TOPICS
from app.flight_logs.ulog_file import UlogFile
from app.text.user_error import UserError
from tests.support.flights import log_bytes as made

TIMES = np.arange(120) / 20
NEVER = 10**9
Found = tuple[object, ...]


@contextmanager
def chain_after(steps: int) -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(dataflash_file, "STEPS_BEFORE", steps)
        patch.setattr(ulog_file, "STEPS_BEFORE", steps)
        yield


def found_in_ulog(data: bytes) -> Found:
    try:
        file = UlogFile(data, TOPICS)
    except UserError as error:
        return (str(error),)
    return ([(one.name, list(one.places)) for one in file.topics], file.skipped_bytes, file.dropout_s)


def found_in_dataflash(data: bytes) -> Found:
    try:
        file = DataflashFile(data, TABLES)
    except UserError as error:
        return (str(error),)
    return ({name: list(one.places) for name, one in file.tables.items()}, file.skipped_bytes)


def ulog() -> bytes:
    """A late subscription with a reused message id, and a sync record."""
    rows = made.ulog_attitude(TIMES, 300.0) + made.ulog_force(TIMES, 1.0) + made.ulog_altitude(TIMES, 5.0)
    rows += [(at_s, made.ulog_record("S", b"\x2f\x73\x13\x20\x25\x0c\xbb\x12")) for at_s in TIMES[::10].tolist()]
    rows += [(3.0, made.ulog_record("A", struct.pack("<BH", 1, 0) + b"vehicle_local_position"))]
    return made.ulog_bytes(rows)


def dataflash() -> bytes:
    """A late definition of a type."""
    rows = made.dataflash_attitude(TIMES, 30.0) + made.dataflash_force(TIMES, 1.0)
    rows += [(at_s, b"\xa3\x95\xc8" + struct.pack("<Q", 7)) for at_s in TIMES[60:].tolist()]
    rows += [(2.0, made.dataflash_format(200, "EV2", "Q", "TimeUS"))]
    rows += made.dataflash_table("MSG", [(1.0, (b"the magic \xa3\x95\x0a within a text",))])
    return made.dataflash_bytes(rows)


WHOLE = {"ulog": (ulog(), found_in_ulog), "dataflash": (dataflash(), found_in_dataflash)}


@pytest.mark.parametrize("kind", WHOLE)
def test_whole_files(kind: str) -> None:
    data, find = WHOLE[kind]
    with chain_after(NEVER):
        stepped = find(data)
    assert len(str(stepped)) > 500
    for steps in (0, 1, 7, 100):
        with chain_after(steps):
            assert find(data) == stepped


@pytest.mark.parametrize("kind", WHOLE)
@settings(max_examples=100, deadline=None)
@given(
    changes=st.lists(st.tuples(st.floats(0, 1), st.one_of(st.binary(min_size=1, max_size=5), st.just(b"\xa3\x95\x0a"))),
                     max_size=5),
    steps=st.sampled_from([0, 3, 50]),
)  # fmt: skip
def test_damaged_files(kind: str, changes: list[tuple[float, bytes]], steps: int) -> None:
    data, find = WHOLE[kind]
    damaged = bytearray(data)
    for place, new in changes:
        start = int(len(damaged) * place)
        damaged[start : start + len(new)] = new
    with chain_after(NEVER):
        stepped = find(bytes(damaged))
    with chain_after(steps):
        assert find(bytes(damaged)) == stepped


def test_a_file_of_beginnings_alone_takes_no_memory() -> None:
    assert positions(b"\xa3\x95" * 1000, 0, 2000, 0xA3, 0x95) is None
    found = positions(b"abcabc" + bytes(30), 0, 36, ord("a"), ord("b"))
    assert found is not None
    assert found.tolist() == [0, 3]
    with chain_after(0):
        assert found_in_dataflash(b"\xa3\x95" * 20_000)[1] == 40_000
