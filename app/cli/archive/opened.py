"""Opens the archive of this computer, and formats modules."""

from collections.abc import Iterator
from contextlib import closing, contextmanager

from app.archive.archive import Archive, open_archive
from app.archive.module_names import NamedModule
from app.stations.station import shown_station
from app.store.store import open_store
from app.terminal import console


@contextmanager
def opened_archive() -> Iterator[Archive]:
    """Raises `UserError` if the records of this computer cannot be read."""
    with closing(open_store()) as store, closing(open_archive(store)) as archive:
        for notice in (store.notice, archive.facts.others.notice):
            if notice is not None:
                console.notify(notice.translated())
        yield archive


def shown_member(module: NamedModule) -> str:
    return f"{shown_station(module.station)}/{module.name}"


def member_json(module: NamedModule) -> dict[str, object]:
    return {"station": shown_station(module.station), "name": module.name}
