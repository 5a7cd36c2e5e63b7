"""State of one module as the fleet board shows it: what it needs next, and the order of all cards."""

import re
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from enum import Enum
from typing import NamedTuple

from app.diagnosis.link_state import LinkState, Phase, link_text
from app.engine.device import DeviceView, Known
from app.engine.identity import Identity
from app.limits.out_of_limits import LimitsInUse, Outside, value_outside
from app.preflight.verdict import Verdict, Void, verdict_sentence
from app.procedures.lock import Locked, waiting_sentence
from app.safety.last_known import LAST_HEARD_ACTIVE, Activation, SeenActivation
from app.settings.identity_words import identity_question
from app.settings.profiles import ActivatedBy
from app.text.i18n import tr
from app.text.messages import UserMessage
from app.text.sentences import capitalised, join_names, join_sentences, labelled
from protocol.translatable import marked

_BUSY = (Phase.OPENING, Phase.FINDING, Phase.ASKING)
_DIGITS = re.compile(r"(\d+)")


class Need(Enum):
    """What a module needs next, the most urgent first. The value is a translatable sentence, or a name where
    `Card.next_step` makes the sentence."""

    TRIGGERED = marked("TRIGGERED: lock it, read its records.")
    NOT_LOCKED = "not locked"
    WAS_ACTIVE = LAST_HEARD_ACTIVE
    IDENTITY = "identity"
    LINK = "link"
    NO_GO = marked("Not met: {names}")
    OUTSIDE = "outside"
    ACTIVE = marked("ACTIVE, not checked")
    ACTIVE_READY = marked("ACTIVE; the check said READY")
    VOID = marked("Check again: {why}")
    CHECK = marked("Start the check.")
    ACTIVATE = "activate"
    WAIT = "wait"
    NOTHING = marked("None")

    @property
    def rank(self) -> int:
        return list(Need).index(self)


class HeldVerdict(NamedTuple):
    """`verdict` None: the check is void, `void` says why. `at`: when it ended, in monotonic seconds;
    None for one that broke off."""

    verdict: Verdict | None
    at: float | None
    void: Void | None = None
    against: tuple[UserMessage, ...] = ()
    """Titles of what stands against it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Card:
    """Everything that the board shows of one module. `trigger` keeps its last value with its age; cell voltage and tilt
    are None unless current: an old number would be taken for a live one. `card_of` adds what follows from `device`."""

    port: str
    link: LinkState
    device: DeviceView = field(compare=False, repr=False)
    activation: SeenActivation
    name: str = ""
    expected: str = ""
    """The name of the module that it may be."""
    identity: Identity = field(default_factory=Identity)
    verdict: HeldVerdict | None = None
    is_checking: bool = False
    lock_sent: int | None = None
    """Number of frames sent, while LOCK is being repeated."""
    lock_failed: Locked | None = None
    """The module did not report that it is locked."""
    is_shown: bool = False
    """The other pages show this module."""
    can_lock: bool = False
    due: tuple[UserMessage, ...] = ()
    """Service that is due, of a module with a name."""
    trigger: Known | None = None
    cell_v: float | None = None
    cell_outside: Outside | None = None
    is_charging: bool = False
    """The voltage is the charger's."""
    tilt_deg: int | None = None
    need: Need = Need.WAIT

    @property
    def has_age(self) -> bool:
        """Whether an age is shown, which changes by itself."""
        is_old = self.activation.state in (Activation.WAS_ACTIVE, Activation.WAS_LOCKED)
        return is_old or (self.trigger is not None and self.trigger.is_stale)

    @property
    def title(self) -> str:
        return self.name or tr("Unnamed")

    @property
    def label(self) -> str:
        """In a list of modules, where an unnamed one is known by its port."""
        return self.name or self.port

    def next_step(self, now: float) -> str:
        """`need` with its reason, and what is due, translated."""
        due = join_sentences(due.translated() for due in self.due)
        return due if due and self.need is Need.NOTHING else f"{self._need(now)}\n{due}".strip()

    def _need(self, now: float) -> str:
        match self.need:
            case Need.NOT_LOCKED if self.lock_sent is not None:
                return waiting_sentence(self.lock_sent)
            case Need.NOT_LOCKED if self.lock_failed is not None:
                return self.lock_failed.sentence
            case Need.IDENTITY:
                return identity_question(self.identity, self.expected)
            case Need.LINK:
                words = link_text(self.link, now)
                return words.next_step or words.what
            case Need.NO_GO if self.verdict is not None:
                return tr(Need.NO_GO.value, names=join_names(title.translated() for title in self.verdict.against))
            case Need.VOID if self.verdict is not None and self.verdict.void is not None:
                return tr(Need.VOID.value, why=self.verdict.void.message.translated())
            case Need.OUTSIDE if self.cell_outside is not None:
                fault, limit = tr(self.cell_outside.fault.value), tr("limit {value}", value=self.cell_outside.limit)
                return labelled(tr("Cell voltage"), join_names((fault, limit)))
            case Need.ACTIVATE:
                return verdict_sentence(Verdict.READY, ActivatedBy.PERSON).translated()
            case Need.WAIT if self.is_checking:
                return capitalised(tr("checking…"))
            case Need.WAIT:
                return link_text(self.link, now).what
            case _:
                return tr(self.need.value)


def card_of(card: Card, now: float, in_use: LimitsInUse) -> Card:
    """With what its device says at `now`."""
    device = card.device
    is_live = card.link.phase is Phase.ONLINE
    cell = device.fresh("cell_voltage_v", now) if is_live else None
    tilt = device.fresh("tilt_deg", now) if is_live else None
    trigger = device.known("triggered", now)
    outside = value_outside("cell_voltage_v", device, now, in_use) if cell is not None else None
    return replace(
        card,
        activation=_without_fresh_time(card.activation),
        trigger=trigger if trigger is None or trigger.is_stale else trigger._replace(at=0.0, sent_after=0.0),
        cell_v=None if cell is None else float(cell),
        cell_outside=outside,
        is_charging=device.fresh("charging", now) is True,
        tilt_deg=None if tilt is None else int(tilt),
        need=_need_of(card, now, has_low_cell=outside is not None),
        identity=card.identity if card.identity.is_for_a_person else Identity(),
    )


def _without_fresh_time(seen: SeenActivation) -> SeenActivation:
    """Drop the time of a fresh report, which is not shown: cards that look the same are equal."""
    return SeenActivation(seen.state) if seen.state in (Activation.ACTIVE, Activation.LOCKED) else seen


def _need_of(card: Card, now: float, *, has_low_cell: bool) -> Need:
    """The most urgent thing for a person to do."""
    triggered = card.device.known("triggered", now)
    state, verdict = card.activation.state, card.verdict
    if triggered is not None and triggered.value is True:
        return Need.TRIGGERED
    if card.lock_failed is not None or card.lock_sent is not None:
        return Need.NOT_LOCKED
    if state is Activation.WAS_ACTIVE:
        return Need.WAS_ACTIVE
    if card.identity.is_for_a_person:
        return Need.IDENTITY
    if card.link.phase in _BUSY or (card.is_checking and card.link.phase is Phase.ONLINE):
        return Need.WAIT
    if card.link.phase is not Phase.ONLINE:
        return Need.LINK
    if verdict is not None and verdict.verdict is Verdict.NO_GO:
        return Need.NO_GO
    if has_low_cell:
        return Need.OUTSIDE
    if verdict is not None and verdict.verdict is Verdict.GO:
        return Need.NOTHING
    if state is Activation.ACTIVE and verdict is None:
        return Need.ACTIVE
    if state is Activation.ACTIVE and verdict is not None and verdict.verdict is Verdict.READY:
        return Need.ACTIVE_READY
    if verdict is None:
        return Need.CHECK
    return Need.VOID if verdict.verdict is None else Need.ACTIVATE


def by_need(cards: Iterable[Card]) -> list[Card]:
    """Sorted by urgency, then by name and port; numbers in them sort as numbers."""
    return sorted(cards, key=lambda card: (card.need.rank, not card.name, _natural(card.name), _natural(card.port)))


def _natural(text: str) -> tuple[tuple[int, str], ...]:
    parts = _DIGITS.split(text.casefold())
    return tuple((int(part), "") if part.isdigit() and part.isascii() else (-1, part) for part in parts)
