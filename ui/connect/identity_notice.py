"""Asks which module is connected where it may not be the expected one."""

from app.engine.identity import Identity
from app.settings.identity_words import differences
from app.text.i18n import tr
from app.text.sentences import join_names, join_sentences
from ui.services.module_name import ModuleName
from ui.style.theme import Meaning
from ui.widgets.notice_bar import Choice, Notice


def identity_notice(identity: Identity, naming: ModuleName) -> Notice | None:
    """The question, None while nothing has to be decided."""
    if not identity.is_for_a_person:
        return None
    name = naming.expected_name
    found = differences(identity)
    if found:
        what = tr("This may be another module: {differences}.", differences=join_names(found))
    elif not identity.is_adapter_same:
        what = tr("This may be another module: the port leads to another device.")
    elif name:
        what = tr("{module}? Read its label.", module=name)
    else:
        what = tr("This may be another module: the port was lost.")
    same = tr("It is {module}", module=name) if name else tr("Same module")
    choices = (
        Choice("identity_new", tr("New module"), naming.treat_as_new, is_step=True),
        Choice("identity_same", same, naming.confirm_identity, is_step=True),
    )
    return Notice(Meaning.ATTENTION, join_sentences([what, tr("Until you decide, only queries are sent.")]), choices)
