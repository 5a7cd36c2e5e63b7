"""What stations call themselves: each introduces itself by a fact with the key that signs its records and its name.

A name is no trust: anybody who may write to the archive may call himself so.
"""

import platform

from app.store.facts import FactKind, Facts, Kept
from app.text.messages import clean

MAX_NAME_LENGTH = 60


def introduce(facts: Facts, key: str) -> None:
    """This station by the name of its computer, unless it has done so. `key`: in hexadecimal. Raises `StoreTrouble`."""
    content = {"public_key": key, "name": clean(platform.node(), longest=MAX_NAME_LENGTH)}
    last = facts.select(FactKind.STATION, "ORDER BY number DESC LIMIT 1")
    if not last or any(last[0].content.get(name) != value for name, value in content.items()):
        facts.add(FactKind.STATION, content)


def introductions(facts: Facts) -> list[tuple[str, str]]:
    """Keys with names. Raises `StoreTrouble`."""
    return [pair for fact in facts.select(FactKind.STATION) if (pair := _pair(fact)) is not None]


def _pair(fact: Kept) -> tuple[str, str] | None:
    key, name = fact.content.get("public_key"), fact.content.get("name")
    return (key, name) if isinstance(key, str) and isinstance(name, str) else None
