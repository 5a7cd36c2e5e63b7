"""What people did to a module: repacked it, changed ejector or cell, its firmware; and which of that is due again."""

from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from datetime import date, datetime
from enum import Enum
from typing import Any, Final, NamedTuple

from app.store.kinds import Serviced
from app.text.messages import MAX_TEXT_LENGTH, UserMessage, clean, joined, message
from app.text.user_error import UserError
from protocol.translatable import marked

SOON_DAYS: Final = 30


class ServiceKind(Enum):
    """The value is the word in facts and on the command line."""

    REPACK = "repack"
    EJECTOR = "ejector"
    CELL = "cell"
    FIRMWARE = "firmware"


TITLES: Final[Mapping[ServiceKind, str]] = {
    ServiceKind.REPACK: marked("Repack"),
    ServiceKind.EJECTOR: marked("Ejector"),
    ServiceKind.CELL: marked("Cell"),
    ServiceKind.FIRMWARE: marked("Firmware"),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Service:
    """Done `on` a day by `who`, and to be done again on the day `due`, if any."""

    kind: ServiceKind
    on: date
    due: date | None = None
    who: str = ""
    note: str = ""

    def content(self) -> Serviced:
        """Its fact. Raises `UserError` for what makes no sense."""
        if self.due is not None and self.due <= self.on:
            raise UserError(marked("It must be due on a later day."))
        who = clean(self.who.strip(), longest=MAX_TEXT_LENGTH)
        note = clean(self.note.strip(), longest=MAX_TEXT_LENGTH)
        return Serviced(service=self.kind.value, on=self.on, due=self.due, who=who, note=note)

    def summary(self) -> UserMessage:
        """ "Repack on 2026-11-24 by Li Wei, due again: 2027-05-24. Note"."""
        text = marked("{what} on {date} by {who}, due again: {due}.")
        due = message(marked("never")) if self.due is None else UserMessage(self.due.isoformat())
        who = self.who or message(marked("not named"))
        done = message(text, what=message(TITLES[self.kind]), date=self.on.isoformat(), who=who, due=due)
        return joined([done, UserMessage(self.note)], " ") if self.note else done


class DueService(NamedTuple):
    """What is due within 30 days, or overdue."""

    text: UserMessage
    is_overdue: bool
    is_after_firing: bool = False
    """The module may have fired: without a repack it is not fit to fly, whatever a profile asks for."""


def service_of(content: Mapping[str, Any]) -> Service:
    """Raises `ValueError` for a kind or a date of a newer version."""
    due = content["due"]
    return Service(
        kind=ServiceKind(content["service"]), on=date.fromisoformat(content["on"]),
        due=None if due is None else date.fromisoformat(due), who=clean(content["who"]), note=clean(content["note"]),
    )  # fmt: skip


def repack_due(fired_at: str | None, services: Iterable[tuple[str, Mapping[str, Any]]]) -> DueService | None:
    """A module that may have fired has no parachute until a person has packed one. `services`: when each was entered,
    in UTC, and what. None where nothing fired or a repack was entered since."""
    if fired_at is None:
        return None
    fired_on = datetime.fromisoformat(fired_at).astimezone().date().isoformat()
    for made_at, content in services:
        is_repack = content.get("service") == ServiceKind.REPACK.value
        if is_repack and made_at > fired_at and str(content.get("on")) >= fired_on:
            return None
    text = message(marked("It fired, or was told to, on {date}; no repack was entered since."), date=fired_on)
    return DueService(text, is_overdue=True, is_after_firing=True)


def due_services(contents: Iterable[Mapping[str, Any]], today: date) -> list[DueService]:
    """What is due of the last service of each kind; unreadable ones, and those of days to come, are left out.
    `contents`: the oldest first."""
    last: dict[ServiceKind, Service] = {}
    for content in contents:
        with suppress(ValueError):
            service = service_of(content)
            if service.on <= today:
                last[service.kind] = service
    due = (last[kind] for kind in ServiceKind if kind in last)
    return [_due(service.kind, service.due, (service.due - today).days) for service in due
            if service.due is not None and (service.due - today).days <= SOON_DAYS]  # fmt: skip


def _due(kind: ServiceKind, on: date, days: int) -> DueService:
    text = marked("{what} overdue since {date}.") if days < 0 else marked("{what} due on {date}, days left: {days}.")
    return DueService(message(text, what=message(TITLES[kind]), date=on.isoformat(), days=days), days < 0)
