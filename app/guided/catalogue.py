"""Catalogue of guided tests: texts, what must be made safe, steps, act and procedures.

    prepare   refuses unless the module is locked and has not fired; reads what the test goes by
    act       what a person confirms before it goes on: the same steps, conditions and log as on the Commands page
    measure   the steps with the person

A module that is locked is in standby and does not fire: whatever can be tested locked is tested locked.
"""

from collections.abc import Callable
from dataclasses import dataclass

from app.engine.procedure import Procedure
from app.guided.bay import measure_bay, prepare_bay
from app.guided.charger import measure_charger, prepare_charger
from app.guided.free_fall import measure_free_fall, prepare_free_fall
from app.guided.link import measure_link, prepare_link
from app.guided.results import TITLES, BreakOff, BrokenOff, GuidedKind, GuidedResult
from app.guided.status_watch import GuidedSetup, PersonSteps
from app.guided.tilt import measure_tilt, prepare_tilt
from app.guided.zero import measure_zero, prepare_zero
from app.safety.acts import Act
from protocol.translatable import marked


@dataclass(frozen=True, slots=True)
class GuidedTest:
    """Texts are English, translatable. `statement`: what a person confirms before a test with an active module;
    `confirms`: the words of the button for each step that a person confirms."""

    kind: GuidedKind
    purpose: str
    safety: str
    steps: tuple[str, ...]
    prepare: Callable[[], Procedure[GuidedSetup]]
    measure: Callable[[GuidedSetup, PersonSteps], Procedure[GuidedResult]]
    act: Act | None = None
    statement: str = ""
    confirms: tuple[str, ...] = ()

    @property
    def title(self) -> str:
        return TITLES[self.kind]

    @property
    def is_active(self) -> bool:
        """It needs an active module, which must be locked afterwards, whatever came of it."""
        return self.act is Act.ACTIVATE


GUIDED_TESTS: tuple[GuidedTest, ...] = (
    GuidedTest(
        GuidedKind.TILT,
        marked("At which angle does it fire and rearm?"),
        marked("It will FIRE four times. Take the ejector (pyro or spring) off the module and the rotors off the "
               "aircraft. It is locked afterwards; each firing stays in its trigger records."),
        (marked("Activate the module"), marked("Tilt it forward until it fires, and back"),
         marked("Tilt it to the right until it fires, and back"), marked("Tilt it back until it fires, and back"),
         marked("Tilt it to the left until it fires, and back"), marked("The module is locked")),
        prepare_tilt, measure_tilt, Act.ACTIVATE,
        marked("The ejector is disconnected and the rotors are off"),
    ),
    GuidedTest(
        GuidedKind.FREE_FALL,
        marked("Does it notice a fall?"),
        marked("The module stays locked; keep clear of its opening all the same. "
               "Take the rotors off the aircraft, or the module out of it. Use a thick cushion."),
        (marked("Hold it level, half a metre above the cushion"), marked("Let it fall"), marked("Leave it there")),
        prepare_free_fall, measure_free_fall,
    ),
    GuidedTest(
        GuidedKind.BAY,
        marked("Does the light tell an open bay from a closed one?"),
        marked("The module stays locked; keep clear of its opening all the same. "
               "A spring under the lid is still loaded: secure it before you open the bay."),
        (marked("Close the bay"), marked("Open the bay fully")),
        prepare_bay, measure_bay,
        confirms=(marked("Bay is closed"), marked("Bay is open")),
    ),
    GuidedTest(
        GuidedKind.CHARGER,
        marked("Does it charge, and only when it is plugged in?"),
        marked("The module stays locked; keep clear of its opening all the same. "
               "Take the rotors off if plugging in powers the aircraft."),
        (marked("Unplug the external power"), marked("Plug it in"), marked("Unplug it again")),
        prepare_charger, measure_charger,
        confirms=(marked("It is unplugged"), marked("It is plugged in"), marked("It is unplugged")),
    ),
    GuidedTest(
        GuidedKind.ZERO,
        marked("Is level reported as 0°?"),
        marked("The module stays locked; keep clear of its opening all the same. "
               "Zeroing changes what it takes as level: for small mounting errors only."),
        (marked("Set the aircraft level"), marked("Zero the sensor"), marked("The tilt is measured again")),
        prepare_zero, measure_zero, Act.ZERO,
    ),
    GuidedTest(
        GuidedKind.LINK,
        marked("Does the plug hold when it is shaken?"),
        marked("The module stays locked; keep clear of its opening all the same. Take the rotors off the aircraft."),
        (marked("Leave the plug alone"), marked("Shake the plug and the cable")),
        prepare_link, measure_link,
    ),
)  # fmt: skip
GUIDED_BY_KIND = {test.kind: test for test in GUIDED_TESTS}


def prepare(test: GuidedTest) -> Procedure[GuidedSetup | BrokenOff]:
    """`test.prepare`, with what breaks it off as a result."""
    try:
        return (yield from test.prepare())
    except BreakOff as why:
        return BrokenOff(why.reason)


def measure(test: GuidedTest, setup: GuidedSetup, steps: PersonSteps) -> Procedure[GuidedResult | BrokenOff]:
    """`test.measure`, with what breaks it off as a result."""
    try:
        return (yield from test.measure(setup, steps))
    except BreakOff as why:
        return BrokenOff(why.reason)
