"""What people did to a module: repacked it, changed ejector or cell, its firmware; and which of that is due again."""

from collections.abc import Iterable, Mapping
from datetime import date, datetime
from typing import Any, Final, NamedTuple

from app.engine.target import is_simulated
from app.store.acts import all_fired
from app.store.fact_store import Facts, Kept
from app.store.rows import Serviced, ServiceKind
from app.text.messages import UserError, UserMessage, clean, joined, message
from protocol.translatable import marked

SOON_DAYS: Final = 30


TITLES: Final[Mapping[ServiceKind, str]] = {
    ServiceKind.REPACK: marked("Repack"),
    ServiceKind.EJECTOR: marked("Ejector"),
    ServiceKind.CELL: marked("Cell"),
    ServiceKind.FIRMWARE: marked("Firmware"),
}
# With another one of these the module may count its starts from 0 again.
RESETS_BOOT_COUNT: Final = (ServiceKind.FIRMWARE, ServiceKind.EJECTOR)


def serviced(kind: ServiceKind, *, on: date, due: date | None = None, who: str = "", note: str = "") -> Serviced:
    """Return the fact of a service that `who` did on a day, and that is to be done again on the day `due`, if any.
    Raises `UserError` for what makes no sense."""
    if due is not None and due <= on:
        raise UserError(marked("It must be due on a later day."))
    return Serviced(service=kind, on=on, due=due, who=clean(who.strip()), note=clean(note.strip()))


def service_summary(service: Serviced) -> UserMessage:
    """ "Repack on 2026-11-24 by Li Wei, due again: 2027-05-24. Note"."""
    done = message(
        marked("{what} on {date} by {who}, due again: {due}."),
        what=message(TITLES[service.service]),
        date=service.on.isoformat(),
        who=clean(service.who) or message(marked("not named")),
        due=message(marked("never")) if service.due is None else UserMessage(service.due.isoformat()),
    )
    return joined([done, UserMessage(clean(service.note))], " ") if service.note else done


class DueService(NamedTuple):
    """A service that is due within 30 days, or overdue."""

    text: UserMessage
    is_overdue: bool
    # The module may have fired: without a repack it is not fit to fly, whatever a profile asks for.
    is_after_firing: bool = False


def service_due(
    facts: Facts, name: str, at: datetime, *, simulated: bool = False, more: Iterable[Kept[Any]] = ()
) -> list[DueService]:
    """Return the services that the module of this name needs. `simulated` asks for a simulated one; `more` is what
    fired and is not under its name yet. Only what this station knows counts, as a verdict rests on it."""
    fired = [one.at for one in (*all_fired(facts, name), *more) if is_simulated(one.content.port) is simulated]
    return all_due(max(fired, default=None), facts.of_module(Serviced, name), at.date())


def all_due(fired_at: str | None, services: Iterable[Kept[Serviced]], today: date) -> list[DueService]:
    """`fired_at`: when the module may have fired last, in UTC. Of each kind the last service counts, that was not
    entered for a day to come."""
    known = list(services)
    repack = repack_due(fired_at, known)
    due = [] if repack is None else [repack]
    for kind in ServiceKind:
        done = [one.content for one in known if one.content.service is kind and one.content.on <= today]
        again = max(reversed(done), key=lambda service: service.on).due if done else None
        if again is None or (days := (again - today).days) > SOON_DAYS:
            continue
        text = marked("{what} due on {date}, days left: {days}.")
        if days < 0:
            text = marked("{what} overdue since {date}.")
        told = message(text, what=message(TITLES[kind]), date=again.isoformat(), days=days)
        due.append(DueService(told, is_overdue=days < 0))
    return due


def repack_due(fired_at: str | None, services: Iterable[Kept[Serviced]] = ()) -> DueService | None:
    """A module that may have fired has no parachute until a person has packed one. None where nothing fired, or a
    repack was entered since."""
    if fired_at is None:
        return None
    fired_on = datetime.fromisoformat(fired_at).astimezone().date()
    for one in services:
        is_repack = one.content.service is ServiceKind.REPACK
        if is_repack and one.at > fired_at and one.content.on >= fired_on:
            return None
    text = marked("It fired, or was told to, on {date}; no repack was entered since.")
    return DueService(message(text, date=fired_on.isoformat()), is_overdue=True, is_after_firing=True)
