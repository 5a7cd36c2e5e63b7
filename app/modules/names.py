"""The names of this station's modules, and what was last read under each.

A module has no serial number of its own: a person says its name again in each conversation, after everything was read,
beside what was last read under it. The boot count only grows, so one that went back is another module's, unless a part
was changed since that starts counting from 0. The settings tell nothing, as the vendor's own tool sets them, too.
"""

from collections.abc import Mapping
from datetime import timedelta
from typing import Final

from msgspec import Struct, convert
from msgspec.structs import replace

from app.engine.conversation import ConversationView
from app.modules.service import RESETS_BOOT_COUNT
from app.settings.values import value_message
from app.store.fact_store import Facts
from app.store.rows import ModuleNamed, Row, Serviced, SettingsSeen, time_text
from app.text.messages import UserMessage, clean, message
from protocol.catalogue import BOOTS, READABLE_SETTINGS
from protocol.fields import Value
from protocol.translatable import marked

# The boot count is one byte. A module in use may go around within half a year.
COUNTS_FOR: Final = timedelta(days=180)
_MODULE = "module:"


class Remembered(Struct, frozen=True):
    """The last that was kept under a name. A value that was never read is None, or absent. Times are in UTC, as in
    facts."""

    name: str = ""
    seen_at: str = ""
    # When its boot count was read.
    read_at: str = ""
    boot_count: int | None = None
    # By key, in the field's unit.
    settings: dict[str, Value] = {}
    # Its boot count may be lower by now: it was read long ago, or a part that counts was changed since.
    may_be_reset: bool = False

    def is_past(self, boot_count: int | None) -> bool:
        """Whether `boot_count` is from before the last one: lower by less than half of the way around."""
        if self.boot_count is None or boot_count is None or self.may_be_reset:
            return False
        return (boot_count - self.boot_count) % BOOTS > BOOTS // 2


def remember(
    facts: Facts, name: str, *, boot_count: int | None = None, settings: Mapping[str, Value] | None = None
) -> None:
    """Keep what was read of the module that a person named so; a new name is made. What is not given stays. Within
    `Store.write`."""
    state, now = facts.state(_MODULE + name), time_text(facts.now())
    if state is None:
        facts.add(ModuleNamed(), name)
    state = {**(state or {}), "seen_at": now}
    if boot_count is not None:
        state |= {"boot_count": boot_count, "read_at": now}
    if settings:
        state["settings"] = dict(settings)
    facts.set_state(_MODULE + name, state)


def remembered(facts: Facts, name: str) -> Remembered | None:
    """Return what is kept under a name; None if no module has this name."""
    state = facts.state(_MODULE + name)
    if state is None:
        return None
    known = convert({**state, "name": name}, Remembered)
    changed = [one.at for one in facts.of_module(Serviced, name) if one.content.service in RESETS_BOOT_COUNT]
    return replace(known, may_be_reset=known.read_at < max([time_text(facts.now() - COUNTS_FOR), *changed]))


def modules(facts: Facts) -> list[Remembered]:
    """Return all names, the last seen first, without `may_be_reset`."""
    known = [convert({**state, "name": name}, Remembered) for name, state in facts.states(_MODULE).items()]
    return sorted(known, key=lambda module: module.seen_at, reverse=True)


# What a person reads beside the question


def what_speaks_against(known: Remembered, conversation: ConversationView) -> tuple[UserMessage, ...]:
    """Why the module of this conversation may be another one than that of this name; empty where nothing is known to
    speak against it."""
    count = conversation.boot_count
    if not known.is_past(count):
        return ()
    return (message(marked("boot count {now}, was {before}"), now=count, before=known.boot_count),)


def what_differs(known: Remembered, conversation: ConversationView, now: float) -> tuple[UserMessage, ...]:
    """The settings that are otherwise than they were last read: to be shown, speaking neither way."""
    settings = conversation.settings(now)
    return tuple(
        message(
            marked("{name} {now}, was {before}"),
            name=message(command.title),
            now=value_message(command, settings[command.key]),
            before=value_message(command, known.settings[command.key]),
        )
        for command in READABLE_SETTINGS
        if command.key in settings and settings[command.key] != known.settings.get(command.key, settings[command.key])
    )


def store_as_found(
    facts: Facts, settings: Mapping[str, Value], boot_count: int | None, *, port: str, module: str = ""
) -> Row:
    """Keep the settings as they were found. `module`: its name, where it has one. Within `Store.write`."""
    if module:
        remember(facts, module)
    seen = SettingsSeen(port=clean(port), boot_count=boot_count, settings=dict(settings))
    return facts.add(seen, module or None)
