"""Reads and writes profile files. Reports all errors at once, each with its line."""

import logging
import re
import tomllib
from collections import Counter
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from app.guided.results import GuidedKind
from app.settings.fingerprint import is_fingerprint
from app.settings.profiles import (
    FORMAT,
    LIMITS,
    MAX_ITEMS,
    MAX_NAME_LENGTH,
    MAX_NOTES_LENGTH,
    MAX_TEST_DAYS,
    OWN_KEYS,
    SETTINGS_BY_KEY,
    TABLES,
    ActivatedBy,
    ManualLine,
    Profile,
)
from app.settings.values import LONGEST_SHOWN, fitting
from app.system.files import CANNOT_READ, CANNOT_WRITE, write_whole
from app.text.messages import UserMessage, clean, joined, message
from app.text.sentences import error_text
from app.text.user_error import UserError
from app.text.visible_text import visible
from protocol.fields import Value
from protocol.translatable import marked

_log = logging.getLogger(__name__)
LARGEST_BYTES = 128 * 1024
MAX_ERRORS = 20
MAX_DOTS = 200
"""Dots in a key: `tomllib` takes half a minute for a key of ten thousand parts."""
_KEYS = frozenset(("format", "manual", *OWN_KEYS, *TABLES, *SETTINGS_BY_KEY))
_SYNTAX = re.compile(r"^(?P<why>.*) \(at (?:line (?P<line>\d+), column \d+|end of document)\)$", re.DOTALL)


class ProfileFault(NamedTuple):
    """One error. `line` counts from 1; None for the file as a whole."""

    line: int | None
    message: UserMessage

    @property
    def placed(self) -> UserMessage:
        """The message with its line."""
        if self.line is None:
            return self.message
        return message(marked("Line {line}: {what}"), line=self.line, what=self.message)


class ProfileRefused(UserError):
    """The file is not a valid profile; `faults` are in the order of their lines."""

    def __init__(self, faults: tuple[ProfileFault, ...]) -> None:
        super().__init__(joined([fault.placed for fault in faults], "\n"))
        self.faults = faults

    @property
    def sentences(self) -> tuple[str, ...]:
        return tuple(fault.placed.translated() for fault in self.faults)


def read_profile(path: Path) -> Profile:
    """Raises `ProfileRefused`, also where the file cannot be read. A profile without a name is named after the file."""
    try:
        data = _content(path)
    except (OSError, ValueError) as error:  # ValueError: a NUL in the name
        why = message(CANNOT_READ, file=path, why=error_text(error))
        raise ProfileRefused((ProfileFault(None, why),)) from error
    profile = parse_profile(data)
    return profile if profile.name.strip() else profile._replace(name=clean(path.stem, longest=MAX_NAME_LENGTH))


def save_profile(path: Path, profile: Profile, *, source: Path | None = None) -> None:
    """`source`: the file that was edited; its comments and its order are kept.

    Raises OSError, or `ProfileRefused` for a profile that could not be read again.
    """
    before = _text_of(source) if source is not None else ""
    text = profile_text(profile, before.replace("\r\n", "\n"))
    parse_profile(text.encode())
    write_whole(path, (text.replace("\n", "\r\n") if "\r\n" in before else text).encode())


def save_or_say_why_not(path: Path, profile: Profile, *, source: Path | None = None) -> UserMessage | None:
    """`save_profile`; what a person reads where it fails, else None."""
    try:
        save_profile(path, profile, source=source)
    except ProfileRefused as refusal:
        return refusal.message
    except OSError as error:
        return message(CANNOT_WRITE, file=path, why=error_text(error))
    return None


def profile_text(profile: Profile, source: str = "") -> str:
    """`source`: the text of a valid profile, whose comments and order are kept."""
    from tomlkit.exceptions import TOMLKitError  # loading it takes longer than a reply of the module

    from app.settings.profile_toml import toml_of

    try:
        text = toml_of(profile, source) if source else ""
        if text and parse_profile(text.encode()) == profile:
            return text
    except (TOMLKitError, ProfileRefused, ValueError, RecursionError) as error:
        _log.warning("The comments of the profile are not kept: %s", error)
    return toml_of(profile)


def _text_of(path: Path) -> str:
    """Empty where it is no longer a valid profile."""
    try:
        data = _content(path)
        parse_profile(data)
    except (OSError, ProfileRefused):
        return ""
    return data.decode("utf-8-sig")


def _content(path: Path) -> bytes:
    with path.open("rb") as file:
        return file.read(LARGEST_BYTES + 1)


def parse_profile(data: bytes) -> Profile:
    """Raises `ProfileRefused` with all faults."""
    if len(data) > LARGEST_BYTES:
        raise ProfileRefused((ProfileFault(None, message(marked("too large."))),))
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise ProfileRefused((ProfileFault(line, message(marked("not UTF-8 text."))),)) from error
    text = text.replace("\r\n", "\n")
    for number, row in enumerate(text.split("\n"), start=1):
        if row.partition("=")[0].count(".") > MAX_DOTS:
            raise ProfileRefused((ProfileFault(number, message(marked("nested too deeply."))),))
    faults: list[ProfileFault] = []
    tables = _tables(text, faults)
    newer = tables.get("format")
    if isinstance(newer, int) and not isinstance(newer, bool) and newer > FORMAT:
        raise ProfileRefused((ProfileFault(None, message(marked("written by a newer version."))),))
    reader = _Reader(key_lines(text), faults)
    profile = reader.profile(tables)
    if faults:
        ordered = sorted(faults, key=lambda fault: fault.line or 0)
        raise ProfileRefused(tuple(ordered[:MAX_ERRORS]))
    return profile


def _tables(text: str, faults: list[ProfileFault]) -> dict[str, Any]:
    """Parses the TOML; a line with a syntax error becomes a fault and is left out."""
    lines = text.split("\n")
    for _ in range(MAX_ERRORS):
        try:
            return tomllib.loads("\n".join(lines))
        except RecursionError:
            faults.append(ProfileFault(None, message(marked("nested too deeply."))))
            return {}
        except (tomllib.TOMLDecodeError, ValueError) as error:
            match = _SYNTAX.match(str(error))
            line = int(match["line"]) if match is not None and match["line"] else None
            why = clean(match["why"] if match is not None else str(error), longest=120)
            faults.append(ProfileFault(line, message(marked("not TOML: {why}."), why=message(why))))
            if line is None or not lines[line - 1]:
                return {}
            lines[line - 1] = ""
    return {}


class _Reader:
    """Reads the parsed tables; collects faults instead of stopping at the first."""

    def __init__(self, lines: Mapping[tuple[str, ...], int], faults: list[ProfileFault]) -> None:
        self._lines = lines
        self._faults = faults

    def profile(self, tables: dict[str, Any]) -> Profile:
        for key in tables:
            if key not in _KEYS:
                self._refuse_unknown(key)
        if tables.get("format", FORMAT) != FORMAT or isinstance(tables.get("format"), bool):
            self._expect(("format",), "1")
        name = self._text(tables, "name", MAX_NAME_LENGTH)
        fingerprint = self._text(tables, "approved_fingerprint", MAX_NAME_LENGTH) or None
        if fingerprint is not None and not is_fingerprint(fingerprint):
            self._refuse(("approved_fingerprint",), marked("not a settings code."))
        return Profile(
            name=name,
            airframe=self._text(tables, "airframe", MAX_NAME_LENGTH),
            notes=self._text(tables, "notes", MAX_NOTES_LENGTH),
            settings=self._all_settings(tables),
            limits=self._limits(self._table(tables, "limits")),
            manual=tuple(self._manual(tables.get("manual", []))),
            approved_fingerprint=fingerprint,
            is_light_inverted=self._flag(tables, ("light_inverted",)),
            is_service_required=self._flag(tables, ("service_required",)),
            activated_by=self._activated_by(self._table(tables, "expectations")),
            tests_within_days=dict(self._tests(self._table(tables, "tests"))),
        )

    def _all_settings(self, tables: dict[str, Any]) -> dict[str, Value]:
        at_the_top = {key: value for key, value in tables.items() if key in SETTINGS_BY_KEY}
        table = self._table(tables, "settings")
        for key in at_the_top.keys() & table.keys():
            self._refuse((key,), marked("{name} is given twice."), name=key)
        return dict([*self._settings(at_the_top, ()), *self._settings(table, ("settings",))])

    def _settings(self, table: dict[str, Any], under: tuple[str, ...]) -> Iterator[tuple[str, Value]]:
        for key, value in table.items():
            command = SETTINGS_BY_KEY.get(key)
            if command is None or command.write is None:
                self._refuse_unknown(*under, key)
                continue
            try:
                yield key, fitting(command.write, value)
            except UserError as error:
                self._refuse((*under, key), marked("{value}: {why}."), value=key, why=error.message)

    def _limits(self, table: dict[str, Any]) -> dict[str, float]:
        limits: dict[str, float] = {}
        for name, value in table.items():
            allowed = LIMITS.get(name)
            is_number = isinstance(value, int | float) and not isinstance(value, bool)
            if allowed is None:
                self._refuse_unknown("limits", name)
            elif not is_number or not allowed.low <= value <= allowed.high:
                self._refuse(
                    ("limits", name), marked("{name}: {low} to {high}; {why}."),
                    name=name, low=f"{allowed.low:g}", high=f"{allowed.high:g}", why=message(allowed.why),
                )  # fmt: skip
            else:
                limits[name] = value
        return limits

    def _activated_by(self, table: dict[str, Any]) -> ActivatedBy:
        for key in table.keys() - {"activated_by"}:
            self._refuse_unknown("expectations", key)
        try:
            return ActivatedBy(table.get("activated_by", ActivatedBy.PERSON))
        except ValueError:
            self._expect(("expectations", "activated_by"), '"person", "aircraft"')
            return ActivatedBy.PERSON

    def _tests(self, table: dict[str, Any]) -> Iterator[tuple[GuidedKind, int]]:
        for name, value in table.items():
            kind = next((kind for kind in GuidedKind if kind.value == name), None)
            is_number = isinstance(value, int) and not isinstance(value, bool)
            if kind is None:
                self._refuse_unknown("tests", name)
            elif not is_number or not 1 <= value <= MAX_TEST_DAYS:
                self._expect(("tests", name), f"1 … {MAX_TEST_DAYS}")
            else:
                yield kind, value

    def _manual(self, items: object) -> Iterator[ManualLine]:
        if not isinstance(items, list) or len(items) > MAX_ITEMS:
            self._expect(("manual",), f"[[manual]], ≤ {MAX_ITEMS}")
            return
        for place, item in enumerate(items):
            path = ("manual", str(place))
            if not isinstance(item, dict):
                self._refuse(path, marked("each manual check needs a text."))
                continue
            for key in item.keys() - {"text", "required"}:
                self._refuse_unknown(*path, key)
            text = self._text(item, "text", MAX_NAME_LENGTH, under=path)
            if isinstance(item.get("text", ""), str) and not text.strip():
                self._refuse(path, marked("each manual check needs a text."))
            yield ManualLine(text, self._flag(item, (*path, "required")))

    def _refuse_unknown(self, *path: str) -> None:
        self._refuse(path, marked("“{name}” is unknown."), name=clean(path[-1], longest=LONGEST_SHOWN))

    def _expect(self, path: tuple[str, ...], expected: str) -> None:
        why = message(marked("expected {expected}"), expected=expected)
        self._refuse(path, marked("{value}: {why}."), value=path[-1], why=why)

    def _table(self, tables: dict[str, Any], key: str) -> dict[str, Any]:
        table = tables.get(key, {})
        if isinstance(table, dict):
            return table
        self._expect((key,), f"[{key}]")
        return {}

    def _flag(self, table: dict[str, Any], path: tuple[str, ...]) -> bool:
        value = table.get(path[-1], False)
        if isinstance(value, bool):
            return value
        self._expect(path, "true, false")
        return False

    def _text(self, table: dict[str, Any], key: str, longest: int, *, under: tuple[str, ...] = ()) -> str:
        value = table.get(key, "")
        path = (*under, key)
        if not isinstance(value, str):
            self._expect(path, '"…"')
            return ""
        if len(value) > longest:
            self._refuse(path, marked("{name}: at most {count} characters."), name=key, count=longest)
        allowed = "\n\t" if key == "notes" else ""
        odd = next((character for character in value if visible(character, keep=allowed) != character), None)
        if odd is not None:
            code = f"U+{ord(odd):04X}"
            self._refuse(path, marked("{name}: {code} is not allowed."), name=key, code=code)
        return value

    def _refuse(self, path: tuple[str, ...], text: str, **values: object) -> None:
        line = next((self._lines[path[:length]] for length in (3, 2, 1) if path[:length] in self._lines), None)
        self._faults.append(ProfileFault(line, message(text, **values)))


_TABLE = re.compile(r"\[\[?([^\]]*)\]")
_KEY = re.compile(r"""(?:"([^"]*)"|'([^']*)'|([A-Za-z0-9_-]+))\s*+(?:\.\s*+([A-Za-z0-9_-]+)\s*+)?=""")
_LONG_QUOTES = ('"""', "'''")


def key_lines(text: str) -> Mapping[tuple[str, ...], int]:
    """The line (from 1) of each key by its path, (table, key) or (key,), and of each table's first header. In the n-th
    table of a list (from 0) also (table, n, key), and (table, n) for its header.

    A key in a notation that is not supported here has only the line of its table, or none.
    """
    lines: dict[tuple[str, ...], int] = {}
    table, entry, open_quote = tuple[str, ...](), tuple[str, ...](), ""
    entries: Counter[tuple[str, ...]] = Counter()
    for number, row in enumerate(text.split("\n"), start=1):
        line = row.strip()  # else the patterns are slow on a long line of spaces
        if open_quote:
            open_quote = "" if open_quote in line else open_quote
        elif (head := _TABLE.match(line)) is not None:
            table = entry = (head.group(1).strip("\"' \t"),)
            lines.setdefault(table, number)
            if line.startswith("[["):
                entry = (*table, str(entries[table]))
                entries[table] += 1
                lines[entry] = number
        else:
            if (key := _KEY.match(line)) is not None:
                *names, inner = key.groups()
                name = next(part for part in names if part is not None)
                lines.setdefault((*table, name, *filter(None, (inner,))), number)
                lines.setdefault((*entry, name), number)
            open_quote = next((quote for quote in _LONG_QUOTES if line.count(quote) % 2), "")
    return lines
