"""Formats the result of `dps-s read` as JSON and as text.

An unknown value is null in JSON and "unknown" with the reason in the text, never a default.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

from app.engine.device import MAX_LAG_S, STATUS_KEYS
from app.limits.out_of_limits import LimitsInUse, line_outside, outside_of
from app.preflight.reading_object import LIVE_KEYS, SETTING_KEYS, reading_object
from app.terminal.console import columns
from app.text.i18n import tr
from app.text.messages import UserMessage, message
from app.text.sentences import in_brackets, join_names
from protocol.catalogue import BAUD_RATE, BY_NAME, SETTINGS, Command
from protocol.events import Unanswered
from protocol.fields import Choice, Done, Field, Flag, Quantity, Value
from protocol.translatable import marked

PORT_LOST = message(marked("port lost"))
FELL_SILENT = message(marked("no reply"))
RESTARTED = message(marked("the module restarted"))


def unanswered_reason(unanswered: Unanswered) -> UserMessage:
    if unanswered.attempts <= 1:
        return FELL_SILENT
    text = marked("no reply within {seconds:.1f} s, asked {attempts} times")
    return message(text, seconds=unanswered.waited_s, attempts=unanswered.attempts)


@dataclass(frozen=True, slots=True)
class Findings:
    """`values` and `errors` by key ("light_v"); `errors` has one key, "status", for all of the status."""

    port: str
    baud_rate: int
    round_trip_s: float | None = None
    """Median."""
    values: Mapping[str, Value] = field(default_factory=dict)
    errors: Mapping[str, UserMessage] = field(default_factory=dict)
    lag_s: float | None = None
    has_damaged: bool = False
    """Invalid bytes were received."""


class _Shown(NamedTuple):
    key: str
    title: str
    field: Field
    blamed: str
    """Its key in `errors`."""


def _shown(command: Command, reply: Field) -> _Shown:
    return _Shown(command.key, command.title, reply, command.key)


_STATUS = (
    _Shown("tilt_deg", marked("Tilt"), BY_NAME["attitude_threshold"].reply or Done(), "status"),
    _Shown("acceleration_g", marked("Acceleration"), BY_NAME["freefall_acceleration"].reply or Done(), "status"),
    _Shown("triggered", marked("Triggered"), Flag(), "status"),
    _Shown("active", marked("Active"), Flag(), "status"),
)
_LIVE = tuple(
    _shown(command, command.reply)
    for command in (BY_NAME[name] for name in ("cell_voltage", "charging", "light", "boot_count"))
    if command.reply is not None
)
_SETTINGS = tuple(_shown(command, command.reply) for command in SETTINGS if command.reply is not None)

_ON_OFF = {
    "active": {True: marked("active"), False: marked("locked")},
    "triggered": {True: marked("triggered"), False: marked("not triggered")},
}
"""Instead of "yes" and "no"."""


def json_of(findings: Findings) -> dict[str, object]:
    """The object of `dps-s read --json`."""
    return reading_object(
        port=findings.port,
        baud_rate=findings.baud_rate,
        round_trip_s=findings.round_trip_s,
        values=findings.values,
        errors={key: why.in_english() for key, why in findings.errors.items()},
    )


def page_of(findings: Findings) -> list[str]:
    """The lines for people."""
    line = line_outside(
        lag_s=findings.lag_s,
        round_trip_s=findings.round_trip_s,
        has_damaged=findings.has_damaged,
        in_use=LimitsInUse(),
    )
    head = tr("{port}, {rate} baud", port=findings.port, rate=findings.baud_rate)
    if findings.lag_s is not None and findings.lag_s > MAX_LAG_S:
        head = join_names((head, f"{findings.lag_s:.1f} s"))
    elif findings.round_trip_s is not None:
        head = join_names((head, f"{1000 * findings.round_trip_s:.1f} ms"))
    if line is not None:
        head = line.beside(head)
    ordered = sorted(_SETTINGS, key=lambda shown: SETTING_KEYS.index(shown.key))
    groups = [(tr("Status"), [_row(shown, findings) for shown in (*_STATUS, *_LIVE)])]
    groups.append((tr("Settings"), [_row(shown, findings) for shown in ordered]))
    rows = columns([row for _, group in groups for row in group], indent=2)
    lines = [head]
    for title, group in groups:
        lines += ["", title, *rows[: len(group)]]
        del rows[: len(group)]
    return lines


def _row(shown: _Shown, findings: Findings) -> tuple[str, str]:
    title = shown.title
    return tr(title), _value(shown, findings)


def _value(shown: _Shown, findings: Findings) -> str:
    value = findings.values.get(shown.key)
    if value is not None:
        text = value_text(shown.key, shown.field, value)
        outside = outside_of(shown.key, findings.values, LimitsInUse())
        return text if outside is None else outside.beside(text)
    why = findings.errors.get(shown.blamed)
    return tr("unknown") + in_brackets(tr("cannot be read") if why is None else why.translated())


def value_text(key: str, shown_by: Field, value: Value) -> str:
    """A value in the language in use: "4.00 V", "60°", "yes"."""
    if isinstance(value, bool):
        words = _ON_OFF.get(key)
        text = words[value] if words is not None else (marked("yes") if value else marked("no"))
        return tr(text)
    match shown_by:
        case Quantity() | Choice():
            return shown_by.text(shown_by.encode(value))
        case Flag() | Done():
            return str(value)


def readable_keys() -> frozenset[str]:
    """Keys of the values that a complete reading has."""
    unreadable = {command.key for command in SETTINGS if not command.reads_back} - {BAUD_RATE.key}
    return frozenset((*STATUS_KEYS, *LIVE_KEYS, *SETTING_KEYS)) - unreadable
