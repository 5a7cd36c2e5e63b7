"""Catalogue of guided tests: texts, what must be made safe, steps, act and procedures.

    prepare   refuses unless the module is locked and has not fired; reads the values that the test needs
    measure   what it returns: the steps with the person

Both raise `UserError`: the test is not completed, does not count and is not kept.

Both are of one conversation. Its end breaks the test off, except where it is one of `expects`: then it is its result.

Whatever can be tested on a locked module is tested on a locked one. Where it must be active, a person confirms its
activation between the two: the same steps, conditions and log as on the Commands page.
"""

from collections.abc import Callable
from typing import NamedTuple

from app.engine.procedure import Procedure
from app.guided.bay import CLOSE, OPEN, prepare_bay
from app.guided.free_fall import DROP, HOLD, WAIT, prepare_free_fall
from app.guided.link import LOOSE_ENDS, REST, SHAKE, prepare_link
from app.guided.results import GuidedKind
from app.guided.status_watch import Measure
from app.guided.tilt import TILT_SLOWLY, TiltDirection, prepare_tilt
from app.safety.journal import TITLES as ACT_TITLES
from app.safety.journal import Act
from app.text.i18n import tr
from app.text.messages import UserMessage, join_sentences, message
from protocol.events import EndReason
from protocol.translatable import marked


class GuidedTest(NamedTuple):
    """Texts are English, translatable. `statement`: what the person states before a test with an active module;
    `confirms`: the text of the button for each step that the person confirms."""

    kind: GuidedKind
    safety: str
    steps: tuple[UserMessage, ...]
    prepare: Callable[[], Procedure[Measure]]
    # It needs an active module, which must be locked afterwards in any case.
    is_active: bool = False
    statement: str = ""
    confirms: tuple[str, ...] = ()
    # The ends of its conversation that are a result of the test.
    expects: frozenset[EndReason] = frozenset()

    @property
    def precautions(self) -> str:
        """What must be made safe, translated."""
        common = "" if self.is_active else tr("Even locked, keep clear of its opening.")
        return join_sentences((common, tr(self.safety)))


GUIDED_TESTS: tuple[GuidedTest, ...] = (
    GuidedTest(
        GuidedKind.TILT,
        marked("It will FIRE four times: take off the ejector (pyro or spring) and the rotors."),
        (message(ACT_TITLES[Act.ACTIVATE]),
         *(message(TILT_SLOWLY, direction=message(direction.value)) for direction in TiltDirection),
         message(ACT_TITLES[Act.LOCK])),
        prepare_tilt, is_active=True, statement=marked("Ejector and rotors are off"),
    ),
    GuidedTest(
        GuidedKind.FREE_FALL,
        marked("Take the rotors off."),
        (message(HOLD), message(DROP), message(WAIT)),
        prepare_free_fall,
    ),
    GuidedTest(
        GuidedKind.BAY,
        marked("Secure the loaded spring under the lid."),
        (message(CLOSE), message(OPEN)),
        prepare_bay,
        confirms=(marked("Bay closed"), marked("Bay open")),
    ),
    GuidedTest(
        GuidedKind.LINK,
        marked("Take the rotors off."),
        (message(REST), message(SHAKE)),
        prepare_link,
        confirms=("", marked("Shaken for 15 s")),
        expects=LOOSE_ENDS,
    ),
)  # fmt: skip
GUIDED_BY_KIND = {test.kind: test for test in GUIDED_TESTS}
