"""Line numbers of the keys of a TOML text, which `tomllib` does not report."""

import re
from collections import Counter
from collections.abc import Mapping

_TABLE = re.compile(r"\[\[?([^\]]*)\]")
_KEY = re.compile(r"""(?:"([^"]*)"|'([^']*)'|([A-Za-z0-9_-]+))\s*+(?:\.\s*+([A-Za-z0-9_-]+)\s*+)?=""")
_LONG_QUOTES = ('"""', "'''")


def key_lines(text: str) -> Mapping[tuple[str, ...], int]:
    """The line (from 1) of each key by its path, (table, key) or (key,), and of each table's first header. In the n-th
    table of a list (from 0) also (table, n, key), and (table, n) for its header.

    A key in a notation that is not supported here has only the line of its table, or none.
    """
    found: dict[tuple[str, ...], int] = {}
    table: tuple[str, ...] = ()
    entry: tuple[str, ...] = ()
    entries: Counter[str] = Counter()
    open_quote: str | None = None
    for number, row in enumerate(text.split("\n"), start=1):
        line = row.strip()  # else the patterns are slow on a long line of spaces
        if open_quote is not None:
            if open_quote in line:
                open_quote = None
            continue
        head = _TABLE.match(line)
        if head is not None:
            table = (head.group(1).strip("\"' \t"),)
            found.setdefault(table, number)
            entry = ()
            if line.lstrip().startswith("[["):
                entry = (*table, str(entries[table[0]]))
                entries[table[0]] += 1
                found[entry] = number
            continue
        key = _KEY.match(line)
        if key is not None:
            name = next(part for part in key.groups()[:3] if part is not None)
            inner = (key.group(4),) if key.group(4) else ()
            found.setdefault((*table, name, *inner), number)
            if entry:
                found.setdefault((*entry, name), number)
        open_quote = _quote_left_open(line)
    return found


def _quote_left_open(line: str) -> str | None:
    for quote in _LONG_QUOTES:
        if line.count(quote) % 2:
            return quote
    return None
