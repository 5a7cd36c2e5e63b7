"""The names of a batch, from one to another. Loaded for the help of every command, so it loads nothing itself."""

import re
from typing import Final

from app.text.visible_text import visible

MAX_BATCH: Final = 1000
MAX_NAME_LENGTH: Final = 60
EXAMPLE: Final = "M-001..M-050"
_NUMBERED: Final = re.compile(r"(.*?)([0-9]{1,9})")


def counted_names(text: str) -> tuple[str, ...] | None:
    """ "M-001..M-050": names that count upwards, with as many digits; or one name. None where it is neither."""
    first, dots, last = text.partition("..")
    begin, end = (_NUMBERED.fullmatch(name) for name in (first, last))
    names: tuple[str, ...] = (first,)
    if begin is not None and end is not None and begin[1] == end[1]:
        low, high, digits = int(begin[2]), int(end[2]), len(begin[2])
        names = tuple(f"{begin[1]}{number:0{digits}}" for number in range(low, min(high, low + MAX_BATCH) + 1))
        is_valid = len(names) <= MAX_BATCH and names[-1:] == (last,)
    else:
        is_valid = not dots
    is_valid &= all(visible(name) == name and 0 < len(name.strip()) == len(name) <= MAX_NAME_LENGTH for name in names)
    return names if is_valid else None
