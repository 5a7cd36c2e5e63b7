"""Which modules of several stations are the same one.

A module has no serial number, so it is identified by (station, name). Two of these are one module only if a person has
said so; until then both are shown. Such a decision is a fact itself and reaches every station. The one with the highest
revision counts, independent of the clocks; that of a station that is not known here only when a person here has settled
it, too.
"""

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from itertools import combinations, count
from typing import Final, NamedTuple

from app.archive.archive import Archive
from app.archive.facts import Fact
from app.limits.service import Service
from app.records.filing import SERVICES, local_now
from app.stations.station import shown_station
from app.store.facts import FactKind
from app.text.messages import UserMessage, clean, message
from app.text.user_error import UserError
from protocol.translatable import marked


class NamedModule(NamedTuple):
    """A module by the public key of a station and its name there."""

    station: str
    name: str


MAX_ALIKE: Final = 100
"""Modules by one name, or with one record, that are asked about; the rest when these are settled."""
_WHO_NEEDED: Final = marked("Enter who decides.")
Pair = tuple[NamedModule, NamedModule]
"""In ascending order."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Settlement:
    """A person's decision about two modules. `name`: the common name if they are the same. `station`: where it was
    made."""

    pair: Pair
    is_same: bool
    name: str
    who: str
    revision: int
    made_at: str = ""
    id: str = ""
    station: str = ""

    def content(self) -> dict[str, object]:
        return {
            "modules": [list(module) for module in self.pair], "is_same": self.is_same, "name": self.name,
            "who": self.who, "revision": self.revision,
        }  # fmt: skip

    @property
    def rank(self) -> tuple[int, str, str]:
        return (self.revision, self.made_at, self.id)


class ConflictKind(Enum):
    """The value is used in JSON."""

    SAME_NAME = "same_name"
    """Two stations use the same name: one module or two?"""
    SAME_RECORDS = "same_records"
    """Two names with the same trigger records: one module named twice?"""
    CONTRADICTION = "contradiction"
    """Declared different, and each declared the same as a third."""
    PROPOSAL = "proposal"
    """Decided at a station that is not known here."""


_QUESTIONS: Final[Mapping[ConflictKind, str]] = {
    ConflictKind.SAME_NAME: marked("“{one}” at two stations: is it the same module?"),
    ConflictKind.SAME_RECORDS: marked("“{one}” and “{other}” have the same trigger records: are they the same module?"),
    ConflictKind.CONTRADICTION: marked("“{one}” and “{other}” were called different, and the same as a third."),
    ConflictKind.PROPOSAL: marked("{who} at station {station}, not known here, decided: {decision} Is it so?"),
}


class Conflict(NamedTuple):
    """To be settled by a person."""

    kind: ConflictKind
    pair: Pair
    proposal: Settlement | None = None

    def question(self) -> UserMessage:
        first, second = (clean(module.name, longest=60) for module in self.pair)
        if self.proposal is None:
            return message(_QUESTIONS[self.kind], one=first, other=second)
        who, station = decided_by(self.proposal)
        return message(_QUESTIONS[self.kind], who=who, station=station, decision=decision_text(self.proposal))


class KnownModule(NamedTuple):
    """One module according to the decisions so far. `members`: its names at the stations."""

    name: str
    members: tuple[NamedModule, ...]


class ModuleNames(NamedTuple):
    """`modules` by name. `conflicts`: not yet settled."""

    modules: tuple[KnownModule, ...]
    conflicts: tuple[Conflict, ...]

    def named(self, name: str) -> tuple[KnownModule, ...]:
        """Find by its common name or its name at a station."""
        folded = _folded(name)
        exact = tuple(module for module in self.modules if _folded(module.name) == folded)
        return exact or tuple(
            module for module in self.modules if any(_folded(member.name) == folded for member in module.members)
        )


def pair_of(first: NamedModule, second: NamedModule) -> Pair:
    return (first, second) if first <= second else (second, first)


def decision_text(settlement: Settlement) -> UserMessage:
    """As a sentence, for example "“M-07” and “M-7” are one module, “M-07”."."""
    first, second = (clean(module.name, longest=60) for module in settlement.pair)
    if settlement.is_same:
        text = marked("“{one}” and “{other}” are one module, “{name}”.")
        return message(text, one=first, other=second, name=clean(settlement.name, longest=60))
    return message(marked("“{one}” and “{other}” are two modules."), one=first, other=second)


def decided_by(settlement: Settlement) -> tuple[UserMessage, str]:
    """The person, and the station that signed it."""
    who = UserMessage(clean(settlement.who, longest=60)) if settlement.who else message(marked("not named"))
    return who, shown_station(settlement.station)


def module_of_fact(fact: Fact) -> NamedModule | None:
    """The module that a fact is about; None if it has no name."""
    name = fact.module
    return NamedModule(fact.station, name) if name else None


class Settled(NamedTuple):
    """Decisions on one pair. `decided`: the one that counts. `proposed`: a later one of an unknown station that
    differs. `next_revision`: overrides them all."""

    decided: Settlement | None
    proposed: Settlement | None
    next_revision: int


def _settled_in(archive: Archive) -> dict[Pair, Settled]:
    pairs: dict[Pair, list[Settlement]] = {}
    for fact in archive.of_kind(FactKind.SETTLEMENT):
        settlement = settlement_of(fact)
        pairs.setdefault(settlement.pair, []).append(settlement)
    known = {archive.public}
    return {pair: _settled(settlements, known) for pair, settlements in pairs.items()}


def _settled(settlements: Sequence[Settlement], known: Collection[str]) -> Settled:
    """A revision counts only where all below it are there, so that none is too high to be overridden."""
    revisions = {settlement.revision for settlement in settlements}
    following = next(number for number in count(1) if number not in revisions)
    current = sorted(
        (settlement for settlement in settlements if settlement.revision < following),
        key=lambda settlement: settlement.rank,
    )
    decided = next((settlement for settlement in reversed(current) if settlement.station in known), None)
    last = current[-1] if current else None
    is_other = last is not None and (decided is None or (last.is_same, last.name) != (decided.is_same, decided.name))
    return Settled(decided, last if last is not decided and is_other else None, following)


def names_of(archive: Archive) -> ModuleNames:
    """Also of what this station recorded last. Raises `UserError`."""
    archive.collect()
    members = {member for fact in archive.of_kind(FactKind.MODULE) if (member := module_of_fact(fact)) is not None}
    settled = _settled_in(archive)
    decided = {pair: decisions.decided for pair, decisions in settled.items() if decisions.decided is not None}
    members |= {module for pair in decided for module in pair}
    names = _names(sorted(members), decided, _records_by_module(archive))
    proposed = [Conflict(ConflictKind.PROPOSAL, pair, decisions.proposed) for pair, decisions in sorted(settled.items())
                if decisions.proposed is not None and members.issuperset(pair)]  # fmt: skip
    asked = {conflict.pair for conflict in proposed}
    return names._replace(
        conflicts=(*proposed, *(conflict for conflict in names.conflicts if conflict.pair not in asked))
    )


def _names(
    members: Sequence[NamedModule], settled: Mapping[Pair, Settlement], records: Mapping[NamedModule, frozenset[str]]
) -> ModuleNames:
    groups = _Groups({member: member for member in members})
    for pair, settlement in sorted(settled.items()):
        if settlement.is_same:
            groups.join(*pair)
    parts: dict[NamedModule, list[NamedModule]] = {}
    for member in members:
        parts.setdefault(groups.leader(member), []).append(member)
    modules = [KnownModule(_name_of(part, settled.values()), tuple(part)) for part in parts.values()]
    conflicts = [*_contradictions(settled, groups), *_open(members, settled, records, groups)]
    return ModuleNames(
        tuple(sorted(modules, key=lambda module: (_folded(module.name), module.members))), tuple(conflicts)
    )


class _Groups(dict[NamedModule, NamedModule]):
    """Groups of modules (union-find): each leads to another one of its group, finally to the smallest."""

    def leader(self, module: NamedModule) -> NamedModule:
        while self[module] != module:
            module = self[module]
        return module

    def join(self, module: NamedModule, other: NamedModule) -> None:
        first, second = sorted((self.leader(module), self.leader(other)))
        self[second] = first


def _name_of(members: Sequence[NamedModule], settlements: Iterable[Settlement]) -> str:
    naming = [
        settlement
        for settlement in settlements
        if settlement.is_same and settlement.name and settlement.pair[0] in members
    ]
    return max(naming, key=lambda settlement: settlement.rank).name if naming else members[0].name


def _contradictions(settled: Mapping[Pair, Settlement], groups: _Groups) -> Iterator[Conflict]:
    for pair, settlement in sorted(settled.items()):
        if not settlement.is_same and groups.leader(pair[0]) == groups.leader(pair[1]):
            yield Conflict(ConflictKind.CONTRADICTION, pair)


def _open(
    members: Sequence[NamedModule],
    settled: Mapping[Pair, Settlement],
    records: Mapping[NamedModule, frozenset[str]],
    groups: _Groups,
) -> Iterator[Conflict]:
    """The fewest questions that may settle it: of three with one name, the first is paired with each of the others."""
    apart = {frozenset(map(groups.leader, pair)) for pair, settlement in settled.items() if not settlement.is_same}
    by_name: dict[str, list[NamedModule]] = {}
    by_record: dict[str, list[NamedModule]] = {}
    for member in members:
        by_name.setdefault(_folded(member.name), []).append(member)
        for raw in sorted(records.get(member, ())):  # the same questions on every station
            by_record.setdefault(raw, []).append(member)
    asked = _Groups(groups)
    for kind, parts in ((ConflictKind.SAME_NAME, by_name), (ConflictKind.SAME_RECORDS, by_record)):
        for part in parts.values():
            for first, second in combinations(part[:MAX_ALIKE], 2):
                is_apart = frozenset((groups.leader(first), groups.leader(second))) in apart
                if first.station != second.station and asked.leader(first) != asked.leader(second) and not is_apart:
                    asked.join(first, second)
                    yield Conflict(kind, pair_of(first, second))


def _records_by_module(archive: Archive) -> dict[NamedModule, frozenset[str]]:
    records: dict[NamedModule, set[str]] = {}
    for fact in archive.of_kind(FactKind.TRIGGER_RECORD):
        module = module_of_fact(fact)
        if module is not None:
            records.setdefault(module, set()).add(fact.content["raw"])
    return {module: frozenset(raws) for module, raws in records.items()}


def settlement_of(fact: Fact) -> Settlement:
    """`fact` is of the kind `SETTLEMENT`."""
    content = fact.content
    first, second = (NamedModule(*module) for module in content["modules"])
    return Settlement(
        pair=pair_of(first, second), is_same=content["is_same"], name=content["name"] or "", who=content["who"] or "",
        revision=content["revision"], made_at=fact.made_at, id=fact.id, station=fact.station,
    )  # fmt: skip


def _folded(name: str) -> str:
    return " ".join(name.split()).casefold()


# What persons enter


def note_services(archive: Archive) -> None:
    """Keep in the store what other stations did to the modules of this one: a pre-flight check opens no archive. Raises
    `UserError`."""
    others = [fact for fact in archive.of_kind(FactKind.SERVICE) if fact.station != archive.public]
    for module in names_of(archive).modules:
        done = [{**fact.content, "station": fact.station} for fact in others if module_of_fact(fact) in module.members]
        for station, name in module.members:
            key, kept = SERVICES.format(module=name), {"done": done} if done else None
            if station == archive.public and archive.own.state(key) != kept:
                archive.own.set_state(key, kept)


def keep_service(archive: Archive, module: KnownModule, service: Service) -> None:
    """Keep what a person did to a module, under its name here; one that has none gets that of another station, and the
    person's word that it is the same module. Raises `UserError`."""
    if service.on > local_now().date():
        raise UserError(marked("It cannot have been done on a day later than today."))
    store, content = archive.store, service.content()
    member = min(module.members, key=lambda member: member.station != archive.public)
    here = member._replace(station=archive.public)
    if here != member and store.module_named(member.name) is not None:
        text = marked("“{name}” is another module here: settle first whether they are one.")
        raise UserError(text, name=clean(member.name))
    if here != member and not service.who.strip():
        raise UserError(_WHO_NEEDED)
    with store.database.transaction():
        store.register_module(member.name)
        store.facts.add(FactKind.SERVICE, content, module=member.name)
    if here != member:
        settle(archive, here, member, is_same=True, name=module.name, who=service.who)


def settle(
    archive: Archive, first: NamedModule, second: NamedModule, *, is_same: bool, name: str = "", who: str
) -> Settlement:
    """Store the decision of `who` whether two modules are the same; it overrides earlier ones, and accepts that of a
    station that is not known here. Raises `UserError`."""
    members = {member for module in names_of(archive).modules for member in module.members}
    if first == second or not members >= {first, second}:
        raise UserError(marked("No such pair of modules in the archive."))
    pair = pair_of(first, second)
    if not who.strip():
        raise UserError(_WHO_NEEDED)
    settled = _settled_in(archive).get(pair)
    settlement = Settlement(
        pair=pair, is_same=is_same, name=clean(name.strip() or first.name) if is_same else "",
        who=clean(who.strip()), revision=1 if settled is None else settled.next_revision,
    )  # fmt: skip
    archive.store.facts.add(FactKind.SETTLEMENT, settlement.content())
    note_services(archive)
    archive.collect()
    return settlement
