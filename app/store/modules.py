"""What this station knows of its modules. A module has no serial number of its own: the technician names it."""

from typing import Any, NamedTuple

from app.engine.identity import IdentityEvidence
from app.engine.snapshots import Snapshot, restorable
from app.store.fact_store import Facts
from app.store.kinds import ModuleNamed, ModuleVisited, SettingsSeen
from app.store.rows import Row, time_text
from app.text.messages import clean

_MODULE = "module:"
_EVIDENCE = "evidence:"


class Module(NamedTuple):
    """`adapter`: the USB identity it was last at."""

    name: str
    adapter: str


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
    names = sorted(states, key=lambda name: str(states[name].get("seen_at")), reverse=True)
    return tuple(_module(name, states[name]) for name in names)


def module_named(facts: Facts, name: str) -> Module | None:
    """None if there is no module of this name."""
    state = facts.state(_MODULE + name)
    return None if state is None else _module(name, state)


def store_evidence(facts: Facts, module: str, evidence: IdentityEvidence) -> None:
    """What was last read of a module, to recognise it by."""
    state = {"boot_count": evidence.boot_count, "settings": dict(evidence.settings)}
    facts.set_state(_EVIDENCE + module, state)


def evidence_of(facts: Facts, module: str) -> IdentityEvidence:
    """What was last read of a module, else the boot count of its last visit, else empty."""
    state = facts.state(_EVIDENCE + module)
    if state is not None:
        return IdentityEvidence(state["boot_count"], restorable(state["settings"]))
    visit = last_booted(facts, module)
    return IdentityEvidence() if visit is None else IdentityEvidence(visit.boot_count)


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
