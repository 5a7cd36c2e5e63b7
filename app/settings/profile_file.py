"""The files of profiles, which are TOML. What is wrong in one is named by its key."""

import logging
import tomllib
from collections.abc import Callable, Mapping
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Annotated, Any, Final, Literal

import msgspec
from msgspec import Meta

from app.guided.results import GuidedKind
from app.settings.profiles import LIMITS, ActivatedBy, ManualLine, Profile
from app.settings.values import LONGEST_SHOWN, SETTINGS_BY_KEY, field_of, fitting
from app.system.files import CANNOT_READ, write_whole
from app.text.messages import UserError, clean, error_text, visible
from protocol.catalogue import Command
from protocol.fields import Value
from protocol.translatable import marked

_log = logging.getLogger(__name__)
FORMAT = 1
MAX_NAME_LENGTH = 200
MAX_NOTES_LENGTH = 8_000
MAX_ITEMS = 40
MAX_TEST_DAYS = 3650
LARGEST_BYTES: Final = 128 * 1024
MAX_WHY: Final = 120  # characters of what `tomllib` says


class ProfileRefused(UserError):
    """The file is not a valid profile."""


# Reading. A reader returns what a value says, given the value and its key, or raises `ProfileRefused`.

_Reader = Callable[[object, str], Any]


def _unexpected(key: str, expected: str) -> ProfileRefused:
    return ProfileRefused(marked("{key}: expected {expected}."), key=key, expected=expected)


def _of_kind(kind: Any, expected: str) -> _Reader:
    def read(value: object, key: str) -> Any:
        try:
            return msgspec.convert(value, kind)
        except ValueError:  # msgspec's error, and Python's about an integer of thousands of digits
            raise _unexpected(key, expected) from None

    return read


def _number(kind: type[float], least: float, most: float) -> _Reader:
    return _of_kind(Annotated[kind, Meta(ge=least, le=most)], f"{least:g} … {most:g}")


def _text(longest: int, show: Callable[[str], str] = clean) -> _Reader:
    """A text that shows what it is, see `visible`."""
    read = _of_kind(Annotated[str, Meta(max_length=longest)], f'"…", 0 … {longest}')
    return lambda value, key: show(read(value, key))


def _setting(command: Command) -> _Reader:
    """Exactly as it will be sent."""

    def read(value: object, key: str) -> Value:
        try:
            return fitting(field_of(command), value)
        except UserError as error:
            raise ProfileRefused(marked("{key}: {why}."), key=key, why=error.message) from None

    return read


def _table(readers: Mapping[str, _Reader]) -> _Reader:
    def read(table: object, key: str) -> dict[str, Any]:
        if not isinstance(table, dict):
            raise _unexpected(key, "[…]")
        found = {}
        for name, value in table.items():
            where = f"{key}.{clean(name, longest=LONGEST_SHOWN)}".removeprefix(".")
            if name not in readers:
                raise ProfileRefused(marked("“{name}” is unknown."), name=where)
            found[name] = readers[name](value, where)
        return found

    return read


def _manual(items: object, key: str) -> tuple[ManualLine, ...]:
    lines = []
    for number, item in enumerate(_ITEMS(items, key), 1):
        found = _ITEM(item, f"{key} {number}")
        if not found.get("text", "").strip():
            raise _unexpected(f"{key} {number}.text", '"…"')
        lines.append(ManualLine(found["text"], found.get("required", False)))
    return tuple(lines)


_NAME: Final = _text(MAX_NAME_LENGTH, partial(clean, longest=MAX_NAME_LENGTH))
_FLAG: Final = _of_kind(bool, "true, false")
_ITEMS: Final = _of_kind(Annotated[list[Any], Meta(max_length=MAX_ITEMS)], f"[[manual]], ≤ {MAX_ITEMS}")
_ITEM: Final = _table({"text": _NAME, "required": _FLAG})
_PROFILE: Final = _table(
    {
        "format": _of_kind(Literal[1], f"{FORMAT}"),
        "name": _NAME,
        "airframe": _NAME,
        "notes": _text(MAX_NOTES_LENGTH, partial(visible, keep="\n\t")),
        "approved_fingerprint": _NAME,
        "light_inverted": _FLAG,
        "service_required": _FLAG,
        "settings": _table({key: _setting(command) for key, command in SETTINGS_BY_KEY.items()}),
        "expectations": _table(
            {"activated_by": _of_kind(ActivatedBy, ", ".join(f'"{who.value}"' for who in ActivatedBy))}
        ),
        "limits": _table({name: _number(float, limit.low, limit.high) for name, limit in LIMITS.items()}),
        "tests": _table({kind.value: _number(int, 1, MAX_TEST_DAYS) for kind in GuidedKind}),
        "manual": _manual,
    }
)
# Where a profile has other names than its file.
_FIELDS: Final = {
    "light_inverted": "is_light_inverted",
    "service_required": "is_service_required",
    "tests": "tests_within_days",
}


def read_profile(path: Path) -> Profile:
    """Return the profile in a file; one without a name is named after the file. Raises `ProfileRefused`, also where the
    file cannot be read."""
    try:
        with path.open("rb") as file:
            data = file.read(LARGEST_BYTES + 1)
    except (OSError, ValueError) as error:  # ValueError: a NUL in the name
        raise ProfileRefused(CANNOT_READ, file=path, why=error_text(error)) from error
    try:
        profile = parse_profile(data)
    except ProfileRefused as refusal:  # of several files, it has to be said which
        text = marked("{file} is not a profile: {why}")
        raise ProfileRefused(text, file=path.name, why=refusal.message) from refusal
    return profile if profile.name.strip() else profile._replace(name=clean(path.stem, longest=MAX_NAME_LENGTH))


def parse_profile(data: bytes) -> Profile:
    """Return the profile in the content of a file. Raises `ProfileRefused`."""
    if len(data) > LARGEST_BYTES:
        raise ProfileRefused(marked("too large."))
    try:
        document = tomllib.loads(data.decode("utf-8-sig"))
    except (ValueError, RecursionError) as error:
        raise ProfileRefused(marked("not TOML: {why}."), why=clean(str(error), longest=MAX_WHY)) from error
    found = _PROFILE(document, "")
    found.pop("format", None)
    found |= found.pop("expectations", {})
    if "tests" in found:
        found["tests"] = {GuidedKind(kind): days for kind, days in found["tests"].items()}
    return Profile(**{_FIELDS.get(key, key): value for key, value in found.items()})


# Writing


def save_profile(path: Path, profile: Profile, *, source: Path | None = None) -> None:
    """Write a profile. `source` is the file that was edited; what did not change is kept, with its comments.

    Raises OSError, or `ProfileRefused` for a profile that could not be read again.
    """
    before = ""
    if source is not None:
        with suppress(OSError), source.open("rb") as file:
            before = file.read(LARGEST_BYTES).decode("utf-8-sig", "replace")
    # Read again before it is written: what a person would find refused tomorrow is refused now.
    text = profile_text(profile, before)
    parse_profile(text.encode())
    write_whole(path, text.encode())


def profile_text(profile: Profile, source: str = "") -> str:
    """Return the text of a file, without what need not be said. `source`: the former one, of which what did not change
    is kept, with its comments."""
    import tomlkit  # to load it takes longer than a reply of the module
    from tomlkit.exceptions import TOMLKitError

    person = profile.activated_by is ActivatedBy.PERSON
    tables: dict[str, Any] = {
        "name": profile.name,
        "airframe": profile.airframe,
        "notes": profile.notes,
        "approved_fingerprint": profile.approved_fingerprint,
        "light_inverted": profile.is_light_inverted,
        "service_required": profile.is_service_required,
        "settings": {key: profile.settings[key] for key in SETTINGS_BY_KEY if key in profile.settings},
        "expectations": {} if person else {"activated_by": profile.activated_by.value},
        "limits": {name: profile.limits[name] for name in LIMITS if name in profile.limits},
        "tests": {kind.value: days for kind, days in profile.tests_within_days.items()},
        "manual": [{"text": one.text, **({"required": True} if one.is_required else {})} for one in profile.manual],
    }
    wanted = {"format": FORMAT} | {key: value for key, value in tables.items() if value or key == "settings"}
    if source:
        try:
            # What is the same stays as it is written; a part that changed is written again.
            document = tomlkit.parse(source)
            before = document.unwrap()
            for key in before.keys() - wanted.keys():
                del document[key]
            document.update({key: value for key, value in wanted.items() if before.get(key) != value})
            text = tomlkit.dumps(document)
            if parse_profile(text.encode()) == profile:
                return text
        except (TOMLKitError, ProfileRefused, ValueError, RecursionError) as error:
            _log.warning("The comments of the profile are not kept: %s", error)
    return tomlkit.dumps(wanted)
