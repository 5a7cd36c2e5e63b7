"""Trigger records that were read are kept under the name of their module, and what is new is told."""

from typing import TYPE_CHECKING

from app.commands.console import say
from app.i18n import tr
from app.procedure import Procedure
from app.procedures.history import History

if TYPE_CHECKING:
    from app.store.checks import CheckStore


def read_boot_count() -> Procedure[int | None]:
    """It tells old records from new ones over the wrap at 256; None where it is not answered twice alike."""
    from app.procedures.write import read_back
    from protocol.catalogue import BY_NAME

    return (yield from read_back(BY_NAME["boot_count"])).raw


def keep_visit(history: History, module: str, *, port: str, boot_count: int | None) -> None:
    """Never raises: what was read has been printed, and a store that cannot be had is said."""
    from app.playback import is_playback
    from app.preflight.wording import clean
    from app.store.checks import CheckStore
    from app.store.database import StoreTrouble
    from app.store.store import open_store

    name = clean(module.strip())
    if not name:
        return
    if is_playback(port):
        say(tr("Not kept: a capture was played, which is no visit of {module}.", module=name))
        return
    slots = [record.raw for record in history.records]
    try:
        store = open_store()
        try:
            if store.notice is not None:
                say(store.notice)
            checks, known = CheckStore(store.database), {one.name: one.id for one in store.modules()}
            if name in known and not _fits(checks, known[name], name, slots, boot_count, history):
                say(tr("Not kept: these records or the boot count do not follow those of {module}.", module=name))
                return
            visit = checks.visit(
                store.meet_module(name).id, slots, port=port, boot_count=boot_count, is_confirmed=history.is_confirmed
            )
        finally:
            store.close()
    except StoreTrouble as error:
        say(error.sentence)
        return
    if visit.new is None:
        say(tr("{module}: the first visit; {count} records are kept.", module=name, count=len(visit.records)))
    else:
        say(tr("{module}: {new} new since the last visit; {count} records are kept.", module=name,
               new=len(visit.new), count=len(visit.records)))  # fmt: skip


def _fits(
    checks: "CheckStore", module_id: int, name: str, slots: list[bytes], boot_count: int | None, history: History
) -> bool:
    """Whether it is the module of that name, as far as its records and its boot count tell."""
    from app.preflight.judging_module import went_back

    past = checks.past(module_id, name, slots, is_confirmed=history.is_confirmed)
    return past.is_same_module and not went_back(past.boot_count, boot_count)
