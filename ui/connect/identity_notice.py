"""Asks which module it is where it may not be the expected one."""

from app.engine.identity import Identity
from app.settings.identity_words import differences
from app.text.i18n import tr
from app.text.sentences import listed, together
from ui.services.module_name import ModuleName
from ui.style.theme import Meaning
from ui.widgets.notice_bar import Choice, Notice


def identity_notice(identity: Identity, naming: ModuleName) -> Notice | None:
    """None while nothing has to be decided."""
    if not identity.is_for_a_person:
        return None
    name = naming.meant
    found = differences(identity)
    if found:
        what = tr("This is another module than {module}: {differences}.", module=name, differences=listed(found))
        if not name:
            what = tr("This is another module than before: {differences}.", differences=listed(found))
    elif not identity.is_adapter_same:
        what = tr("The port leads to another device than before: this may be another module.")
    elif name:
        what = tr("It cannot be told whether this is {module}: too little is known of it.", module=name)
    else:
        what = tr("It cannot be told whether this is the same module: too little was read.")
    same = tr("It is {module}", module=name) if name else tr("It is the same module")
    choices = (
        Choice("identity_new", tr("It is a new module"), naming.take_as_new),
        Choice("identity_same", same, naming.vouch),
    )
    return Notice(Meaning.ATTENTION, together([what, tr("Until you decide, only queries are sent.")]), choices)
