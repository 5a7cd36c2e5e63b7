"""The four kinds of field: every byte, every step, and what is refused."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from protocol.catalogue import BAUD, CELL_VOLT, CENTISECOND, COUNT, DEGREE, FLAG, INVERTED, TENTH_G, TENTH_VOLT
from protocol.fields import Choice, Done, Field, Flag, Quantity, Value, ValueRefused

QUANTITIES = [TENTH_VOLT, CELL_VOLT, TENTH_G, CENTISECOND, DEGREE, COUNT]
LENIENT = Flag(lenient=True)
FIELDS: list[Field] = [*QUANTITIES, FLAG, INVERTED, BAUD, Done()]


@pytest.mark.parametrize("field", FIELDS, ids=str)
def test_every_allowed_byte_survives_the_way_there_and_back(field: Field) -> None:
    assert field.allowed
    for raw in field.allowed:
        assert field.encode(field.decode(raw)) == raw


@pytest.mark.parametrize("field", QUANTITIES, ids=str)
def test_no_two_bytes_read_alike(field: Quantity) -> None:
    """As text for a person too: 3.80 V and 3.82 V are two values."""
    assert len({field.text(raw) for raw in range(256)}) == 256
    assert len({field.decode(raw) for raw in range(256)}) == 256


@pytest.mark.parametrize("field", QUANTITIES, ids=str)
def test_the_text_is_the_value(field: Quantity) -> None:
    for raw in range(256):
        number = field.text(raw).removesuffix(field.unit).strip()
        assert float(number) == field.decode(raw)


@pytest.mark.parametrize(
    ("field", "raw", "value", "text"),
    [
        (CELL_VOLT, 0xBE, 3.8, "3.80 V"),
        (CELL_VOLT, 0xC8, 4.0, "4.00 V"),
        (CELL_VOLT, 0xD2, 4.2, "4.20 V"),
        (CELL_VOLT, 0xEB, 4.7, "4.70 V"),
        (TENTH_VOLT, 0x12, 1.8, "1.8 V"),
        (TENTH_G, 0x05, 0.5, "0.5 g"),
        (CENTISECOND, 0xA0, 1.6, "1.60 s"),
        (DEGREE, 0x3C, 60, "60°"),
        (COUNT, 0x25, 37, "37"),
        (FLAG, 1, True, "yes"),
        (FLAG, 0, False, "no"),
        (INVERTED, 0, True, "yes"),
        (INVERTED, 1, False, "no"),
        (BAUD, 6, 115200, "115200 baud"),
        (BAUD, 1, 4800, "4800 baud"),
        (Done(), 1, True, "done"),
    ],
)
def test_the_values_of_the_table(field: Field, raw: int, value: Value, text: str) -> None:
    assert field.decode(raw) == value
    assert type(field.decode(raw)) is type(value)
    assert field.encode(value) == raw
    assert field.text(raw) == text


@pytest.mark.parametrize(
    ("field", "value", "neighbours"),
    [
        (CENTISECOND, 1.605, (1.6, 1.61)),
        (CELL_VOLT, 3.81, (3.8, 3.82)),
        (DEGREE, 60.5, (60, 61)),
        (TENTH_G, -0.1, (0.0,)),
        (TENTH_G, 25.6, (25.5,)),
        (DEGREE, 256, (255,)),
        (DEGREE, True, ()),
        (DEGREE, math.nan, ()),
        (DEGREE, math.inf, ()),
        (FLAG, 1, (True, False)),
        (INVERTED, 0, (True, False)),
        (BAUD, 115201, (4800, 9600, 19200, 38400, 57600, 115200)),
        (BAUD, True, (4800, 9600, 19200, 38400, 57600, 115200)),
        (Done(), False, (True,)),
        (Done(), 1, (True,)),
    ],
)
def test_what_a_byte_cannot_carry_is_refused_with_what_it_can(
    field: Field, value: Value, neighbours: tuple[Value, ...]
) -> None:
    with pytest.raises(ValueRefused) as refused:
        field.encode(value)
    assert refused.value.neighbours == neighbours
    assert str(refused.value)


def test_a_refusal_names_both_ends_of_the_range() -> None:
    with pytest.raises(ValueRefused, match=r"^25\.6 is outside 0\.0 g to 25\.5 g$"):
        TENTH_G.encode(25.6)


@pytest.mark.parametrize("field", QUANTITIES, ids=str)
@given(value=st.floats(allow_nan=True, allow_infinity=True) | st.integers())
def test_a_number_is_carried_exactly_or_refused(field: Quantity, value: float) -> None:
    try:
        raw = field.encode(value)
    except ValueRefused as refused:
        assert all(neighbour != value for neighbour in refused.neighbours)  # noqa: PT017  both ends are right
    else:
        assert field.decode(raw) == value


def test_zero_has_no_sign() -> None:
    assert TENTH_G.encode(-0.0) == 0


def test_a_flag_knows_its_two_bytes_and_a_lenient_one_takes_any() -> None:
    assert (FLAG.true, FLAG.false, FLAG.allowed) == (1, 0, {0, 1})
    assert (INVERTED.true, INVERTED.false, INVERTED.allowed) == (0, 1, {0, 1})
    assert LENIENT.allowed == set(range(256))
    assert [LENIENT.decode(raw) for raw in (0, 1, 2, 255)] == [False, True, False, False]
    assert LENIENT.text(7) == "no"


def test_ranges() -> None:
    assert [field.maximum for field in QUANTITIES] == [25.5, 5.1, 25.5, 2.55, 255, 255]
    assert [field.decimals for field in QUANTITIES] == [1, 2, 1, 2, 0, 0]


def test_a_choice_can_be_part_of_a_set() -> None:
    assert len({BAUD, Choice(BAUD.values, unit="baud")}) == 1
