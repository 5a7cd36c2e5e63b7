"""Which modules of several stations are the same one.

A module has no serial number, so it is identified by (station, name). Two of these are one module only if a person has
said so; until then both are shown. Such a decision is a fact itself and reaches every station. The one with the highest
revision counts, independent of the clocks.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from itertools import combinations
from typing import Final, NamedTuple

from app.archive.facts import Fact, FactKind
from app.archive.local_facts import LocalFacts
from app.text.messages import UserMessage, clean, message
from protocol.translatable import marked

MAX_NAME_LENGTH: Final = 200


class NamedModule(NamedTuple):
    """A module by the public key of a station and its name there."""

    station: str
    name: str


Pair = tuple[NamedModule, NamedModule]
"""In ascending order."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Settlement:
    """A person's decision about two modules. `name`: the common name if they are the same."""

    pair: Pair
    is_same: bool
    name: str
    who: str
    revision: int
    made_at: str = ""
    id: str = ""

    def content(self) -> dict[str, object]:
        """Content of the fact."""
        return {
            "modules": [list(one) for one in self.pair], "is_same": self.is_same, "name": self.name, "who": self.who,
            "revision": self.revision,
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


_QUESTIONS: Final[Mapping[ConflictKind, str]] = {
    ConflictKind.SAME_NAME: marked("“{one}” at two stations: is it the same module?"),
    ConflictKind.SAME_RECORDS: marked("“{one}” and “{other}” have the same trigger records: are they the same module?"),
    ConflictKind.CONTRADICTION: marked("“{one}” and “{other}” were called different, and the same as a third."),
}


@dataclass(frozen=True, slots=True)
class Conflict:
    """To be settled by a person."""

    kind: ConflictKind
    pair: Pair

    def question(self) -> UserMessage:
        one, other = (clean(module.name, longest=60) for module in self.pair)
        return message(_QUESTIONS[self.kind], one=one, other=other)


@dataclass(frozen=True, slots=True)
class KnownModule:
    """One module according to the decisions so far. `members`: its names at the stations."""

    name: str
    members: tuple[NamedModule, ...]


@dataclass(frozen=True, slots=True)
class ModuleNames:
    """`modules` by name. `conflicts`: not yet settled."""

    modules: tuple[KnownModule, ...]
    conflicts: tuple[Conflict, ...]

    def module_of(self, member: NamedModule) -> KnownModule | None:
        return next((one for one in self.modules if member in one.members), None)

    def named(self, name: str) -> tuple[KnownModule, ...]:
        """Find by its common name or its name at a station."""
        wanted = _folded(name)
        exact = tuple(one for one in self.modules if _folded(one.name) == wanted)
        return exact or tuple(
            one for one in self.modules if any(_folded(member.name) == wanted for member in one.members)
        )


def pair_of(one: NamedModule, other: NamedModule) -> Pair:
    return (one, other) if one <= other else (other, one)


def module_of_fact(fact: Fact) -> NamedModule | None:
    """The module that a fact is about; None if it has no name."""
    name = fact.module
    return NamedModule(fact.station, name) if name and len(name) <= MAX_NAME_LENGTH else None


def settlements_in(facts: LocalFacts) -> dict[Pair, Settlement]:
    """The current decision on each pair."""
    last: dict[Pair, Settlement] = {}
    for fact in facts.of_kind(FactKind.SETTLEMENT):
        found = _settlement(fact)
        if found is not None and (found.pair not in last or last[found.pair].rank < found.rank):
            last[found.pair] = found
    return last


def names_of(facts: LocalFacts) -> ModuleNames:
    """Raises `ArchiveTrouble`."""
    members = {found for fact in facts.of_kind(FactKind.MODULE) if (found := module_of_fact(fact)) is not None}
    settled = settlements_in(facts)
    members |= {one for pair in settled for one in pair}
    return _names(sorted(members), settled, _records_by_module(facts))


def _names(
    members: Sequence[NamedModule], settled: Mapping[Pair, Settlement], records: Mapping[NamedModule, frozenset[str]]
) -> ModuleNames:
    groups = _Groups({one: one for one in members})
    for pair, settlement in sorted(settled.items()):
        if settlement.is_same:
            groups.join(*pair)
    parts: dict[NamedModule, list[NamedModule]] = {}
    for one in members:
        parts.setdefault(groups.leader(one), []).append(one)
    modules = [KnownModule(_name_of(part, settled.values()), tuple(part)) for part in parts.values()]
    conflicts = [*_contradictions(settled, groups), *_open(members, settled, records, groups)]
    return ModuleNames(tuple(sorted(modules, key=lambda one: (_folded(one.name), one.members))), tuple(conflicts))


class _Groups(dict[NamedModule, NamedModule]):
    """Groups of modules (union-find): each leads to another one of its group, finally to the smallest."""

    def leader(self, one: NamedModule) -> NamedModule:
        while self[one] != one:
            one = self[one]
        return one

    def join(self, one: NamedModule, other: NamedModule) -> None:
        first, second = sorted((self.leader(one), self.leader(other)))
        self[second] = first


def _name_of(members: Sequence[NamedModule], settlements: Iterable[Settlement]) -> str:
    said_names = [one for one in settlements if one.is_same and one.name and one.pair[0] in members]
    return max(said_names, key=lambda one: one.rank).name if said_names else members[0].name


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
    apart = {frozenset(map(groups.leader, pair)) for pair, one in settled.items() if not one.is_same}
    by_name: dict[str, list[NamedModule]] = {}
    by_record: dict[str, list[NamedModule]] = {}
    for one in members:
        by_name.setdefault(_folded(one.name), []).append(one)
        for raw in sorted(records.get(one, ())):  # the same questions on every station
            by_record.setdefault(raw, []).append(one)
    asked = _Groups(groups)
    for kind, parts in ((ConflictKind.SAME_NAME, by_name), (ConflictKind.SAME_RECORDS, by_record)):
        for part in parts.values():
            for one, other in combinations(part, 2):
                is_apart = frozenset((groups.leader(one), groups.leader(other))) in apart
                if one.station != other.station and asked.leader(one) != asked.leader(other) and not is_apart:
                    asked.join(one, other)
                    yield Conflict(kind, pair_of(one, other))


def _records_by_module(facts: LocalFacts) -> dict[NamedModule, frozenset[str]]:
    found: dict[NamedModule, set[str]] = {}
    for fact in facts.of_kind(FactKind.TRIGGER_RECORD):
        module, raw = module_of_fact(fact), fact.content.get("raw")
        if module is not None and isinstance(raw, str):
            found.setdefault(module, set()).add(raw)
    return {module: frozenset(raws) for module, raws in found.items()}


def _settlement(fact: Fact) -> Settlement | None:
    """None if the content is not valid."""
    content = fact.content
    modules, is_same, name, who, revision = (
        content.get(key) for key in ("modules", "is_same", "name", "who", "revision")
    )
    if not (isinstance(modules, list) and len(modules) == 2 and all(_is_module(one) for one in modules)):
        return None
    if not (isinstance(is_same, bool) and isinstance(name, str) and isinstance(who, str) and type(revision) is int):
        return None
    one, other = (NamedModule(*module) for module in modules)
    return Settlement(
        pair=pair_of(one, other), is_same=is_same, name=clean(name, longest=MAX_NAME_LENGTH), who=clean(who),
        revision=revision, made_at=fact.made_at, id=fact.id,
    )  # fmt: skip


def _is_module(value: object) -> bool:
    return isinstance(value, list) and len(value) == 2 and all(isinstance(one, str) and one for one in value)


def _folded(name: str) -> str:
    return " ".join(name.split()).casefold()
