"""What people did to a module: repacked it, changed ejector or cell, its firmware; and which of that is due again."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from datetime import date, datetime
from enum import Enum
from typing import Final, NamedTuple

from app.store.fact_store import Kept
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


def service_of(content: Serviced) -> Service:
    return Service(
        kind=ServiceKind(content.service),
        on=content.on,
        due=content.due,
        who=clean(content.who),
        note=clean(content.note),
    )


def repack_due(fired_at: str | None, services: Iterable[Kept[Serviced]]) -> DueService | None:
    """A module that may have fired has no parachute until a person has packed one. None where nothing fired, or a
    repack was entered since. `fired_at`: ISO 8601 in UTC."""
    if fired_at is None:
        return None
    fired_on = datetime.fromisoformat(fired_at).astimezone().date()
    for kept in services:
        is_repack = kept.content.service == ServiceKind.REPACK.value
        if is_repack and kept.at > fired_at and kept.content.on >= fired_on:
            return None
    text = marked("It fired, or was told to, on {date}; no repack was entered since.")
    return DueService(message(text, date=fired_on.isoformat()), is_overdue=True, is_after_firing=True)


def due_services(contents: Iterable[Serviced], today: date) -> list[DueService]:
    """What is due of the last service of each kind, without those of days to come. `contents`: the oldest first."""
    last: dict[str, Serviced] = {}
    for content in contents:
        if content.on <= today:
            last[content.service] = content
    due = []
    for kind in ServiceKind:
        service = last.get(kind.value)
        if service is not None and service.due is not None and (service.due - today).days <= SOON_DAYS:
            due.append(_due(kind, service.due, (service.due - today).days))
    return due


def _due(kind: ServiceKind, on: date, days: int) -> DueService:
    text = marked("{what} overdue since {date}.") if days < 0 else marked("{what} due on {date}, days left: {days}.")
    return DueService(message(text, what=message(TITLES[kind]), date=on.isoformat(), days=days), days < 0)
