"""Describes how a module differs from the expected one."""

from app.engine.identity import Identity
from app.settings.setting_texts import value_text
from app.text.i18n import tr


def differences(identity: Identity) -> list[str]:
    """Each difference in a few words, in the language in use."""
    before, found = identity.before, []
    if before is not None and identity.is_boot_count_lower:
        found.append(tr("boot count {now}, was {before}", now=identity.now.boot_count, before=before.boot_count))
    for one in identity.changed:
        name = tr(one.command.title)
        values = {"now": value_text(one.command, one.after), "before": value_text(one.command, one.before)}
        found.append(tr("{name} {now}, was {before}", name=name[:1].lower() + name[1:], **values))
    return found
