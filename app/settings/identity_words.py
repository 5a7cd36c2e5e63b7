"""By what a module is known, and how it differs from the expected one, in words."""

from typing import Final

from app.engine.identity import Identity
from app.settings.values import value_text
from app.text.i18n import tr
from app.text.messages import UserMessage, message
from app.text.sentences import join_names
from protocol.translatable import marked

NOT_NAMED: Final = message(marked("module not named"))


def known_by(name: str | None, *, is_by_option: bool = False) -> UserMessage:
    """To be said wherever something is used that is kept under the name. `is_by_option`: --module, nobody was asked."""
    if not name:
        return NOT_NAMED
    if is_by_option:
        return message(marked("{module}, given by --module"), module=name)
    return message(marked("{module}, confirmed by a person on this connection"), module=name)


def differences(identity: Identity) -> list[str]:
    """Each difference in a few words, in the language in use."""
    before, texts = identity.before, []
    if before is not None and identity.is_boot_count_lower:
        texts.append(tr("boot count {now}, was {before}", now=identity.now.boot_count, before=before.boot_count))
    for change in identity.changed:
        name = tr(change.command.title)
        values = {"now": value_text(change.command, change.after), "before": value_text(change.command, change.before)}
        texts.append(tr("{name} {now}, was {before}", name=name[:1].lower() + name[1:], **values))
    return texts


def identity_question(identity: Identity, expected: str) -> str:
    """What a person is asked who has to say which module it is, translated; `expected`: its name, where it has one."""
    why = join_names(differences(identity))
    if not why and not identity.is_adapter_same:
        why = tr("the port leads to another device")
    if not why and expected:
        return tr("{module}? Read its label.", module=expected)
    return tr("This may be another module: {differences}.", differences=why or tr("link lost"))


def same_module_words(expected: str) -> str:
    """Of the button that answers it."""
    return tr("It is {module}", module=expected) if expected else tr("Same module")
