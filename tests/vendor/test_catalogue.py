"""The product's catalogue says what the vendor's table says."""

import pytest

from protocol import catalogue
from protocol.catalogue import BY_NAME, COMMANDS
from protocol.fields import ValueRefused
from tests.vendor import table


def test_names_and_codes() -> None:
    assert {command.name: command.code for command in COMMANDS} == table.CODES


def test_queries() -> None:
    queries = {
        command.name: command.query().encode().hex(" ") for command in COMMANDS if command.query_data is not None
    }
    assert queries == table.QUERIES


@pytest.mark.parametrize(("name", "value", "frame"), table.SETS)
def test_sets(name: str, value: bool | float, frame: str) -> None:
    assert BY_NAME[name].set(value).encode().hex(" ") == frame


def test_nothing_else_can_be_set() -> None:
    can_be_set = {command.name for command in COMMANDS if command.write is not None}
    assert can_be_set == {name for name, _, _ in table.SETS}


@pytest.mark.parametrize("name", table.STEPS)
def test_scales(name: str) -> None:
    command = BY_NAME[name]
    assert command.reply is not None
    for byte in range(256):
        value = byte / table.STEPS[name]
        assert command.reply.decode(byte) == value
        if command.write is not None:
            assert command.set(value).data == byte


def test_cell_voltages() -> None:
    reply = BY_NAME["cell_voltage"].reply
    assert reply is not None
    assert {byte: reply.decode(byte) for byte in table.CELL_VOLTAGES} == table.CELL_VOLTAGES


def test_baud_codes() -> None:
    command = BY_NAME["baud_rate"]
    assert command.reply is not None
    for code, rate in table.BAUD_CODES.items():
        assert command.set(rate).data == code
        assert command.reply.decode(code) == rate
    assert command.reply.allowed == set(table.BAUD_CODES)
    assert set(catalogue.BAUD_RATES) == set(table.BAUD_CODES.values())
    assert table.BAUD_CODES[table.DEFAULTS["baud_rate"]] == catalogue.DEFAULT_BAUD_RATE
    with pytest.raises(ValueRefused):
        command.set(14400)


@pytest.mark.parametrize("name", table.YES)
def test_flags(name: str) -> None:
    command = BY_NAME[name]
    yes = table.YES[name]
    assert command.reply is not None
    assert command.reply.decode(yes) is True
    assert command.reply.decode(1 - yes) is False
    if command.write is not None:
        assert command.set(True).data == yes
        assert command.set(False).data == 1 - yes


@pytest.mark.parametrize("name", ["active", "triggered"])
def test_anything_but_01_means_no(name: str) -> None:
    reply = BY_NAME[name].reply
    assert reply is not None
    assert [byte for byte in range(256) if reply.decode(byte)] == [0x01]
    assert reply.allowed == set(range(256))


def test_defaults_and_advice() -> None:
    assert {one.name: one.default for one in COMMANDS if one.default is not None} == table.DEFAULTS
    attitude = BY_NAME["attitude_threshold"].advice
    assert attitude is not None
    assert attitude.is_followed_by(table.LOWEST_ADVISED_ATTITUDE_DEG)
    assert not attitude.is_followed_by(table.LOWEST_ADVISED_ATTITUDE_DEG - 1)
    acceleration = BY_NAME["freefall_acceleration"].advice
    assert acceleration is not None
    assert acceleration.is_followed_by(0.6)
    assert not acceleration.is_followed_by(table.ACCELERATION_ADVISED_BELOW_G)
    assert catalogue.RESET_BELOW_THRESHOLD_DEG == table.RESET_BELOW_THRESHOLD_DEG
    assert catalogue.MAX_RECORDS == table.RECORDS_KEPT


def test_codes_that_the_table_prints_for_another_command() -> None:
    """E3: the cell voltage comes as 35. E4: 17 is acknowledged as 16."""
    others = {one.name: set(one.reply_codes - {one.code}) for one in COMMANDS if one.reply_codes != {one.code}}
    assert others == {"cell_voltage": {0x35}, "freefall_trigger": {0x16}}


def test_codes_that_may_acknowledge_by_01() -> None:
    """E2."""
    assert {one.code for one in COMMANDS if one.acknowledged_by_one} == {0x21, 0x22, 0x24}


def test_places_of_the_values_in_the_long_frames() -> None:
    assert {part.name: part.first for part in catalogue.STATUS_PARTS} == table.STATUS_BYTES
    assert {part.name: part.first for part in catalogue.RECORD_PARTS} == table.RECORD_BYTES
