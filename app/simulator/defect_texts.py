"""Text syntax for codes, occasions and rules of defects: `14,33/2`, `21:20=14/2@500`.

Errors are `ValueError` with the expected form.
"""

import re
from collections.abc import Iterable

from app.simulator.defects import CHANGEABLE_CODES
from app.simulator.quirks import RULES, Marks, Occasion, Rule
from protocol.catalogue import BY_CODE, MAX_RECORDS

MAX_TIMES = 1_000_000
_RULE = re.compile(
    r"(?P<cause>[0-9a-f]{2}):(?P<effect>[0-9a-f]{2})(=(?P<value>[0-9a-f]{2}))?"
    r"(/(?P<time>[0-9]{1,6}))?(@(?P<after>[0-9]{1,7}(\.[0-9]{1,6})?))?",
    re.IGNORECASE | re.ASCII,
)


def listed(values: Iterable[int | Occasion | Rule]) -> str:
    """In the form in which they are typed."""
    texts = [f"{one:02X}" if isinstance(one, int) else str(one) for one in values]
    return ",".join(texts if isinstance(values, tuple) else sorted(texts))


def _parts(text: str) -> list[str]:
    return text.replace(",", " ").split()


def _check(found: Iterable[int], known: Iterable[int] = BY_CODE, *, form: str = "02X") -> None:
    """Raises `ValueError` with all known values."""
    if not set(found) <= set(known):
        raise ValueError("|".join(f"{one:{form}}" for one in sorted(known)))


def codes(text: str) -> frozenset[int]:
    """Codes of commands, such as 14,33; raises `ValueError`."""
    try:
        found = frozenset(int(part, 16) for part in _parts(text))
    except ValueError:
        raise ValueError("CODE,…") from None
    _check(found)
    return found


def _marks(text: str, base: int, expected: str) -> Marks:
    found = set[int | Occasion]()
    try:
        for part in _parts(text):
            what, slash, time = part.partition("/")
            found.add(Occasion(int(what, base), int(time)) if slash else int(what, base))
    except ValueError:
        raise ValueError(expected) from None
    if any(isinstance(one, Occasion) and not 1 <= one.time <= MAX_TIMES for one in found):
        raise ValueError(expected)
    return frozenset(found)


def marked_codes(text: str) -> Marks:
    """Codes of commands, each from the n-th time on, such as 14,33/2; raises `ValueError`."""
    found = _marks(text, 16, "CODE[/N],…")
    _check(one.what if isinstance(one, Occasion) else one for one in found)
    return found


def marked_records(text: str) -> Marks:
    """Record numbers, each the n-th time, such as 3,1/2; raises `ValueError`."""
    found = _marks(text, 10, "RECORD[/N],…")
    _check((one.what if isinstance(one, Occasion) else one for one in found), range(1, MAX_RECORDS + 1), form="d")
    return found


def _rule(part: str) -> Rule:
    match = _RULE.fullmatch(part)
    if match is None:
        raise ValueError(RULES)
    value, time, after = match["value"], match["time"], match["after"]
    return Rule(
        int(match["cause"], 16), int(match["effect"], 16), None if value is None else int(value, 16),
        int(time or 0), float(after or 0),
    )  # fmt: skip


def rules(text: str) -> tuple[Rule, ...]:
    """Rules by which a request causes further replies; raises `ValueError`."""
    found = tuple(_rule(part) for part in _parts(text))
    _check(code for rule in found for code in (rule.cause, rule.effect))
    return found


def changes(text: str) -> tuple[Rule, ...]:
    """Rules by which a request changes settings; raises `ValueError`."""
    found = rules(text)
    _check((rule.effect for rule in found), CHANGEABLE_CODES)
    return found
