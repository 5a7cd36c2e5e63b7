"""The archive of this station: collects its records, exchanges them, says what is not shared yet, settles conflicts."""

from collections.abc import Mapping
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

from app.archive.exchange import Exchanged, OnProgress, exchange, export_facts, import_facts
from app.archive.local_facts import LocalFacts, open_facts
from app.archive.module_names import KnownModule, ModuleNames, NamedModule, Settlement, names_of, pair_of, settled_in
from app.archive.server_url import server_url
from app.limits.service import Service
from app.stations.known import Stations
from app.stations.station import Station, encoded, own_station
from app.store.facts import FactKind
from app.store.store import Store
from app.text.messages import clean
from app.text.user_error import UserError
from protocol.translatable import marked


@dataclass(frozen=True, slots=True, kw_only=True)
class ArchiveStatus:
    """`not_shared`: records of this station that are not known to be on the server `place`. `last_at`: time of the last
    complete exchange with it; None if there was none."""

    stations: Mapping[str, int]
    """Number of records by public key."""
    place: str | None
    not_shared: int
    last_at: str | None
    conflicts: int


class Archive:
    """Made by `open_archive`. Every method may block and raises `UserError`; thread-safe."""

    def __init__(self, store: Store, facts: LocalFacts, station: Station) -> None:
        self.store = store
        self.facts = facts
        self.station = station
        self.known = Stations(store.database.path.parent)

    @property
    def public(self) -> str:
        """This station's public key, as used in facts."""
        return encoded(self.station.public)

    def close(self) -> None:
        self.facts.close()

    def collect(self) -> int:
        """Sign what this station recorded; returns the number of new facts."""
        return self.facts.sign(self.station)

    def sync(self, url: str, *, on_page: OnProgress = lambda _done: None) -> Exchanged:
        """Exchange with a server."""
        from app.archive.postgres import open_server

        shown = server_url(url).shown
        self.collect()
        with closing(open_server(url)) as server:
            last = self.facts.last_number()
            done = exchange(self.facts, server, on_page=on_page)
        if not done.damaged:
            self.facts.note_exchange(shown, last)
        return done

    def export(self, path: Path, *, on_page: OnProgress = lambda _done: None) -> Exchanged:
        """Add what the file lacks; a missing file is created."""
        self.collect()
        return export_facts(self.facts, path, on_page=on_page)

    def import_file(self, path: Path, *, on_page: OnProgress = lambda _done: None) -> Exchanged:
        return import_facts(self.facts, path, on_page=on_page)

    def status(self, url: str | None) -> ArchiveStatus:
        """`url`: the configured server."""
        names = self.names()
        place = server_url(url).shown if url else None
        not_shared, last_at = self.facts.not_shared(place)
        return ArchiveStatus(
            stations=self.facts.counts(),
            place=place,
            not_shared=not_shared,
            last_at=last_at,
            conflicts=len(names.conflicts),
        )

    def names(self) -> ModuleNames:
        """Also of what this station recorded last."""
        self.collect()
        return names_of(self.facts, self._known())

    def _known(self) -> frozenset[str]:
        """Public keys of the stations whose decisions count."""
        return frozenset(encoded(station.public) for station in self.known.known() if not station.is_revoked) | {
            self.public
        }

    def keep_service(self, module: KnownModule, service: Service) -> None:
        """Keep what a person did to a module, under its name here; one that has none gets that of another station, and
        the person's word that it is the same module. Raises `UserError`."""
        content, member = service.content(), min(module.members, key=lambda member: member.station != self.public)
        here = member._replace(station=self.public)
        if here != member and self.store.module_named(member.name) is not None:
            text = marked("“{name}” is another module here: settle first whether they are one.")
            raise UserError(text, name=clean(member.name))
        if here != member and not service.who.strip():
            raise UserError(marked("Enter the name of the person who decides."))
        with self.store.database.transaction():
            self.store.register_module(member.name)
            self.store.facts.add(FactKind.SERVICE, content, module=member.name)
        if here != member:
            self.settle(here, member, is_same=True, name=module.name, who=service.who)

    def settle(self, first: NamedModule, second: NamedModule, *, is_same: bool, name: str = "", who: str) -> None:
        """Store the decision of `who` whether two modules are the same; it overrides earlier ones, and accepts
        that of a station that is not known here."""
        members = {member for module in self.names().modules for member in module.members}
        if first == second or not members >= {first, second}:
            raise UserError(marked("No such pair of modules in the archive."))
        pair = pair_of(first, second)
        if not who.strip():
            raise UserError(marked("Enter the name of the person who decides."))
        settled = settled_in(self.facts, self._known()).get(pair)
        settlement = Settlement(
            pair=pair, is_same=is_same, name=clean(name.strip() or first.name) if is_same else "",
            who=clean(who.strip()), revision=1 if settled is None else settled.next_revision,
        )  # fmt: skip
        self.store.facts.add(FactKind.SETTLEMENT, settlement.content())
        self.collect()


def open_archive(store: Store) -> Archive:
    """Open the archive beside the store; creates the station key if it is missing. Raises `UserError`."""
    return Archive(store, open_facts(store.facts), own_station(store.database.path.parent))
