"""What this station knows of its modules. A module has no serial number of its own: the technician names it."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, NamedTuple

from app.engine.snapshots import Snapshot
from app.store.fact_store import Facts
from app.store.kinds import ModuleNamed, ModuleVisited, SettingsSeen
from app.store.rows import Row, time_text
from app.text.messages import clean
from protocol.catalogue import SETTINGS
from protocol.fields import Value

_MODULE = "module:"
_LAST_READ = "evidence:"
BOOTS = 256
"""The boot count is one byte: 0 follows 255."""


class Module(NamedTuple):
    """`adapter`: the USB identity it was last at."""

    name: str
    adapter: str


class LastRead(NamedTuple):
    """What was last read of a module. `settings`: by key, in the field's unit, without those that were not read."""

    boot_count: int | None = None
    settings: Mapping[str, Value] = MappingProxyType({})

    @property
    def is_complete(self) -> bool:
        """Whether the boot count and every setting that can be read are known."""
        readable = [command.key for command in SETTINGS if command.reads_back]
        return self.boot_count is not None and all(key in self.settings for key in readable)


def went_back(before: int, now: int) -> bool:
    """Whether a boot count fell: forward it would have gone at least half of the way round."""
    return (now - before) % BOOTS >= BOOTS // 2


def register_module(facts: Facts, name: str, adapter: str = "") -> None:
    """It is made if it is new, and was seen now. An empty `adapter` keeps the last one."""
    known = module_named(facts, name)
    module = Module(name, clean(adapter) or (known.adapter if known else ""))
    if module != known:
        facts.add(ModuleNamed(adapter=module.adapter), name)
    facts.set_state(_MODULE + name, {"adapter": module.adapter, "seen_at": time_text(facts.now())})


def modules(facts: Facts) -> tuple[Module, ...]:
    """The last seen first."""
    states = facts.states(_MODULE)
    names = sorted(states, key=lambda name: str(states[name]["seen_at"]), reverse=True)
    return tuple(_module(name, states[name]) for name in names)


def module_named(facts: Facts, name: str) -> Module | None:
    """None if there is no module of this name."""
    state = facts.state(_MODULE + name)
    return None if state is None else _module(name, state)


def store_evidence(facts: Facts, module: str, read: tuple[int | None, Mapping[str, Value]]) -> None:
    """What was read of a module just now: its boot count, and its settings by key."""
    boot_count, settings = read
    facts.set_state(_LAST_READ + module, {"boot_count": boot_count, "settings": dict(settings)})


def evidence_of(facts: Facts, module: str) -> LastRead:
    """What was last read of a module, else the boot count of its last visit, else nothing."""
    state = facts.state(_LAST_READ + module)
    if state is not None:
        return LastRead(state["boot_count"], state["settings"])
    visit = last_booted(facts, module)
    return LastRead() if visit is None else LastRead(visit.boot_count)


def last_booted(facts: Facts, module: str) -> ModuleVisited | None:
    """The last reading of a module of which the boot count is known."""
    visits = facts.of_module(ModuleVisited, module, is_newest_first=True)
    return next((visit.content for visit in visits if visit.content.boot_count is not None), None)


def store_snapshot(facts: Facts, snapshot: Snapshot, *, port: str, module: str = "") -> Row:
    """The settings as they were found. `module`: its name, where it has one; a new one is registered."""
    if module:
        register_module(facts, module)
    seen = SettingsSeen(port=clean(port), boot_count=snapshot.boot_count, settings=dict(snapshot.settings))
    return facts.add(seen, module or None)


def _module(name: str, state: dict[str, Any]) -> Module:
    return Module(name, str(state["adapter"]))
