"""Every trigger is stored once, in any order, across wraps and with equal bytes."""

import csv
import io
import random
from collections.abc import Iterator
from contextlib import closing
from datetime import timedelta
from itertools import count
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.modules.names import remembered
from app.store.fact_store import Facts, connect, utc_now
from app.store.rows import Judgement
from app.text.messages import UserMessage
from app.trigger_records.history import (
    CSV_HEAD,
    KeptTriggers,
    Visit,
    do_continue,
    file_triggers,
    in_order,
    new_records,
    read_triggers,
    record_of,
    sentence,
    write_archive,
)
from protocol.messages import encode_long
from tests.support.line.sim_line import settled_rig

WORKED = bytes.fromhex("41 75 35 01 01 00 6C 02 3C 05 A0 00 01 0C EB 7E")


def raw(boot: int, uptime: int, source: int = 2, *, charge: int = 1, serial: int = 0, cell: int = 0xC8) -> bytes:
    data = bytes((1, boot % 256, uptime >> 8, uptime & 0xFF, source, 60, 5, 160, serial, charge, 3, cell))
    return encode_long(0x35, data)


@pytest.fixture
def facts(tmp_path: Path) -> Iterator[Facts]:
    """In a file without a store's thread: each is there at once, and later than the one before."""
    later = count()
    with closing(connect(tmp_path / "dps-s.sqlite")) as connection:
        yield Facts(connection, "a" * 64, lambda: utc_now() + timedelta(microseconds=next(later)))


# Sentences


TOLD = {
    WORKED: "tipped past 60° 1 min 48 s after power-on of boot 1, serial link connected, 4.70 V (implausible)",
    raw(
        7, 9, 8, serial=1
    ): "fell (below 0.5 g for 1.60 s) 9 s after power-on of boot 7, serial link not connected, 4.00 V",
    raw(200, 65535, 5, charge=0): "fired by serial + fired by PWM ≥ 18 h 12 min 15 s after power-on of boot 200, "
    "serial link connected, on external power, 4.00 V",
    raw(0, 3600, 0x12): "tipped past 60° + fired by bit4 1 h 0 min 0 s after power-on of boot 0, "
    "serial link connected, 4.00 V",
    raw(1, 0, 0): "no cause stated 0 s after power-on of boot 1, serial link connected, 4.00 V",
}


def test_each_is_told_in_one_sentence() -> None:
    assert {record: sentence(record_of(record)).translated() for record in TOLD} == TOLD


# Merging


def _slots(life: list[bytes], order: str) -> list[bytes]:
    kept = life[-9:]
    if order == "newest first":
        return kept[::-1]
    if order == "ring" and len(life) > 9:
        cut = len(life) % 9
        return kept[-cut:] + kept[:-cut] if cut else kept
    return kept


@pytest.mark.parametrize("order", ["oldest first", "newest first", "ring"])
@given(steps=st.lists(st.integers(0, 9), min_size=1, max_size=12), seed=st.integers(0, 999))
def test_no_trigger_is_ever_lost_or_counted_twice(order: str, steps: list[int], seed: int) -> None:
    """A module that fires 0 to 9 times between visits while the boot count wraps."""
    source = random.Random(seed)
    boot = source.randrange(256)
    life: list[bytes] = []
    last: list[bytes] = []
    known: tuple[bytes, ...] = ()
    for fired in steps:
        for _ in range(fired):
            boot += source.randrange(1, 12)
            life.append(raw(boot, source.randrange(3000), source.choice((1, 2, 8))))
        slots = _slots(life, order)
        assert do_continue(last, slots)
        known, last = known + in_order(new_records(last, slots), boot % 256), slots
    assert list(known) == life


def test_equal_records_are_counted_separately() -> None:
    one, two = raw(3, 10), raw(4, 20)
    assert new_records([one], [one, one]) == [one]
    assert new_records([one, one], [one, one, two]) == [two]
    full = [one] * 9
    assert new_records(full, [*full[1:], two]) == [two]
    assert new_records(full, full) == []


def test_another_module_is_detected_but_not_by_a_lossy_reading(facts: Facts) -> None:
    mine, others = [raw(boot, 5) for boot in range(3)], [raw(boot, 77) for boot in range(3)]
    assert not do_continue(mine, others)
    assert not do_continue(mine, mine[:2])
    nine = [raw(boot, 5) for boot in range(9)]
    assert do_continue(nine, [raw(boot, 5) for boot in range(20, 29)])
    store = KeptTriggers(facts)
    store.store_visit("M-07", mine, port="p", boot_count=9, is_confirmed=True)
    assert not store.do_follow("M-07", mine[:2], is_confirmed=True)
    assert store.do_follow("M-07", mine[:2], is_confirmed=False)


# The store


def test_the_tenth_trigger_removes_no_stored_record(facts: Facts) -> None:
    store, number = KeptTriggers(facts), "M-07"
    life = [raw(boot, 100 + boot) for boot in range(9)]
    first = store.store_visit(number, life, port="p", boot_count=9, is_confirmed=True)
    assert first.new == len(first.records) == 9
    store.judge(number, first.records[0], Judgement.BENCH_TEST, "on the table\n\u202e=1+1")
    life.append(raw(10, 3))
    second = store.store_visit(number, life[-9:], port="p", boot_count=10, is_confirmed=True)
    assert [record.raw for record in second.records] == life
    assert second.new == 1
    assert second.records[0].judgement is Judgement.BENCH_TEST
    assert second.records[0].note == "on the table [U+202E]=1+1"
    store.judge(number, second.records[0], None, "")
    assert store.records(number)[0].judgement is None
    third = store.store_visit(number, life[-9:], port="p", boot_count=10, is_confirmed=True)
    assert third.new == 0


def test_a_lossy_reading_removes_no_record(facts: Facts) -> None:
    store, number = KeptTriggers(facts), "M-07"
    store.store_visit("M-08", [raw(9, 9)], port="p", boot_count=9, is_confirmed=True)  # of nobody else
    life = [raw(boot, 5) for boot in range(4)]
    for slots, is_confirmed in ((life, True), ([life[0], life[2]], False), (life, True)):
        visit = store.store_visit(number, slots, port="p", boot_count=4, is_confirmed=is_confirmed)
    assert [record.raw for record in visit.records] == life


# Read from a module, and filed under the name that a person said


@pytest.mark.promise("a")
def test_records_that_do_not_follow_are_kept_under_a_name_only_by_a_persons_word(facts: Facts) -> None:
    first = settled_rig(history=3).run(read_triggers())
    assert first.boot_count == 37
    visit = file_triggers(facts, first, "M-07", port="p", adapter="usb")
    assert isinstance(visit, Visit)
    assert len(visit.records) == 3
    known = remembered(facts, "M-07")
    assert known is not None
    assert (known.boot_count, known.settings) == (37, dict(first.settings))
    other = settled_rig(history=5, seed=9).run(read_triggers())
    refused = file_triggers(facts, other, "M-07", port="p")
    assert isinstance(refused, UserMessage)
    assert refused.in_english() == "the records do not follow those of its last visit"
    assert len(KeptTriggers(facts).records("M-07")) == 3
    assert isinstance(file_triggers(facts, other, "M-07", port="p", is_same_module=True), Visit)


# CSV


def test_the_csv_tells_all_of_each_and_contains_no_formulas(facts: Facts, tmp_path: Path) -> None:
    store, path, text = KeptTriggers(facts), tmp_path / "all.csv", '=HYPERLINK("x";"y"),"'
    store.store_visit("M-07", [WORKED, raw(2, 2)], port="p", boot_count=2, is_confirmed=True)
    store.judge("M-07", store.records("M-07")[0], Judgement.REAL, text)
    write_archive(path, text, store.records("M-07"), seen_once=frozenset({1}))
    data = path.read_bytes()
    assert data.startswith(b"\xef\xbb\xbf")
    head, *lines = csv.reader(io.StringIO(data.decode("utf-8-sig"), newline=""))
    assert tuple(head) == CSV_HEAD
    assert not [value for value in (*lines[0], *lines[1]) if value.startswith("=")]
    first, second = (dict(zip(head, line, strict=True)) for line in lines)
    told = first["cell_voltage_v"], first["judgement"], first["implausible"], first["confirmed"], second["confirmed"]
    assert told == ("4.7", "real", "cell_voltage_v", "true", "false")
