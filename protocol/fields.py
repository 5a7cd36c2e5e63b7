"""Field types of one data byte (D4 of a six-byte frame) in the vendor's table.

    on the wire        in the program          as text
    0x05 (u8)    <->   5 / 10 = 0.5 (float) <-> "0.5 g"

`decode` accepts every byte in `allowed`; the stream parser rejects all others. `encode` never rounds: a rounded
threshold is not the one that was asked for.
"""

from collections.abc import Mapping
from decimal import Decimal
from itertools import count
from typing import NamedTuple

from protocol.translatable import marked

Value = bool | int | float

EVERY_BYTE = frozenset(range(256))


class ValueRefused(ValueError):
    """A value that the field's byte cannot represent. `text`: English, translatable, with the placeholders of
    `values`."""

    def __init__(self, text: str, **values: object) -> None:
        super().__init__(text.format(**values))
        self.text, self.values = text, values


NUMBER_NEEDED = marked("a number is needed")


class Quantity(NamedTuple):
    """A measured or set amount: byte / `per_unit`, in `unit`.

    Dividing by a whole number gives the nearest float to the decimal that the vendor prints (190 / 50 is 3.8),
    which multiplying by 0.02 does not.
    """

    unit: str  # symbol beside the number: "V", "g", "s", "°", or "" for a count
    suffix: str  # adds the unit to a name: "_v" makes "light_v"
    # Steps to one unit: 10 for a step of 0.1 V. Divides a power of ten, so that every step is a finite decimal.
    per_unit: int

    @property
    def allowed(self) -> frozenset[int]:
        return EVERY_BYTE

    @property
    def decimals(self) -> int:
        return next(places for places in count() if 10**places % self.per_unit == 0)

    def decode(self, raw: int) -> Value:
        return raw if self.per_unit == 1 else raw / self.per_unit

    def encode(self, value: Value) -> int:
        """Byte for `value`; raises `ValueRefused` off the range of a byte or between two steps."""
        exact = Decimal("nan" if isinstance(value, bool) else str(value))
        if not exact.is_finite():
            raise ValueRefused(NUMBER_NEEDED)
        steps = exact * self.per_unit
        if not 0 <= steps <= 255:
            text = marked("{value} is outside {low} to {high}")
            raise ValueRefused(text, value=value, low=self.text(0), high=self.text(255))
        raw = int(steps)
        if steps != raw:
            text = marked("{value}: the nearest steps are {low} and {high}")
            raise ValueRefused(text, value=value, low=self.text(raw), high=self.text(raw + 1))
        return raw

    def text(self, raw: int) -> str:
        gap = "" if self.unit in ("°", "") else " "
        return f"{raw / self.per_unit:.{self.decimals}f}{gap}{self.unit}"


class Flag(NamedTuple):
    """Yes or no. `true` is the byte for yes: 00 for the two inverted trigger flags (16, 17).

    `lenient`: any byte but `true` means no, as the table says of 30 and 31 ("01 active, anything else not").
    """

    true: int = 0x01
    lenient: bool = False

    @property
    def allowed(self) -> frozenset[int]:
        return EVERY_BYTE if self.lenient else frozenset((0x00, 0x01))

    def decode(self, raw: int) -> Value:
        return raw == self.true

    def encode(self, value: Value) -> int:
        """Byte for `value`; raises `ValueRefused` for anything but True and False."""
        if not isinstance(value, bool):
            raise ValueRefused(marked("expected {expected}"), expected="true, false")
        return self.true if value else 1 - self.true

    def text(self, raw: int) -> str:
        return marked("yes") if raw == self.true else marked("no")


class Choice(NamedTuple):
    """One of a few values, each with its own code (the baud rates)."""

    values: Mapping[int, int]  # code on the wire -> value
    unit: str

    @property
    def allowed(self) -> frozenset[int]:
        return frozenset(self.values)

    def decode(self, raw: int) -> Value:
        return self.values[raw]

    def encode(self, value: Value) -> int:
        """Code for `value`; raises `ValueRefused` for a value that has none."""
        for code, known in self.values.items():
            if known == value:
                return code
        listed = ", ".join(map(str, self.values.values()))
        raise ValueRefused(marked("{value} is not one of {values}"), value=value, values=listed)

    def text(self, raw: int) -> str:
        return f"{self.values[raw]} {self.unit}"


class Done(NamedTuple):
    """A byte that is always 01 and says only "understood" (12, 25)."""

    @property
    def allowed(self) -> frozenset[int]:
        return frozenset((0x01,))

    def decode(self, raw: int) -> Value:
        return raw == 0x01

    def encode(self, value: Value) -> int:
        """01; raises `ValueRefused` for anything but True: no byte means "no"."""
        if value is not True:
            raise ValueRefused(marked("expected {expected}"), expected="true")
        return 0x01

    def text(self, raw: int) -> str:
        return marked("done") if raw == 0x01 else f"{raw:02X}"


Field = Quantity | Flag | Choice | Done
