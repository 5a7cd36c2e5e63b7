"""What is known under a name, and what speaks against a person's word that this is the module."""

from collections.abc import Iterator
from contextlib import closing
from datetime import UTC, date, datetime, timedelta
from pathlib import Path
from types import MappingProxyType

import pytest

from app.engine.conversation import ConversationView, How, Known
from app.modules.names import modules, remember, remembered, what_differs, what_speaks_against
from app.modules.service import ServiceKind, serviced
from app.store.fact_store import Facts, connect
from app.store.rows import ModuleNamed
from protocol.fields import Value

NOW = datetime(2026, 5, 1, 12, tzinfo=UTC)
SETTINGS: dict[str, Value] = {"attitude_threshold_deg": 60, "freefall_time_s": 1.6}


class Desk:
    """Facts on a clock that the test sets."""

    def __init__(self, facts: Facts) -> None:
        self.facts, self.now = facts, NOW

    def later(self, days: float = 0.001) -> None:
        self.now += timedelta(days=days)


@pytest.fixture
def desk(tmp_path: Path) -> Iterator[Desk]:
    with closing(connect(tmp_path / "dps-s.sqlite")) as connection:
        desk: Desk

        def tick() -> datetime:
            desk.now += timedelta(microseconds=1)
            return desk.now

        desk = Desk(Facts(connection, "a" * 64, tick))
        yield desk


def conversation(boot_count: int | None = None, **settings: Value) -> ConversationView:
    values = dict(settings) if boot_count is None else {"boot_count": boot_count, **settings}
    known = {key: Known(value, How.READ, 0.0) for key, value in values.items()}
    return ConversationView(number=1, values=MappingProxyType(known))


def against(desk: Desk, boot_count: int | None) -> list[str]:
    known = remembered(desk.facts, "M-07")
    assert known is not None
    return [text.in_english() for text in what_speaks_against(known, conversation(boot_count))]


def test_what_is_not_given_stays(desk: Desk) -> None:
    remember(desk.facts, "M-07", boot_count=12, settings=SETTINGS)
    remember(desk.facts, "M-07")
    known = remembered(desk.facts, "M-07")
    assert known is not None
    assert (known.boot_count, known.settings) == (12, SETTINGS)
    assert len(desk.facts.of_module(ModuleNamed, "M-07")) == 1
    remember(desk.facts, "M-07", boot_count=13)
    known = remembered(desk.facts, "M-07")
    assert known is not None
    assert (known.boot_count, known.settings) == (13, SETTINGS)


def test_the_last_seen_comes_first(desk: Desk) -> None:
    for name in ("M-01", "M-02", "M-03"):
        remember(desk.facts, name)
        desk.later()
    remember(desk.facts, "M-01")
    assert [module.name for module in modules(desk.facts)] == ["M-01", "M-03", "M-02"]


@pytest.mark.parametrize(
    ("before", "now", "speaks"),
    [(12, 12, False), (12, 13, False), (12, 140, False), (12, 11, True), (12, 255, True), (255, 0, False),
     (12, None, False), (None, 3, False)],
)  # fmt: skip
@pytest.mark.promise("a")
def test_a_boot_count_that_went_back_speaks_against_it(
    desk: Desk, before: int | None, now: int | None, speaks: bool
) -> None:
    remember(desk.facts, "M-07", boot_count=before)
    assert against(desk, now) == ([f"boot count {now}, was {before}"] if speaks else [])


@pytest.mark.parametrize(
    ("kind", "speaks"),
    [
        (ServiceKind.FIRMWARE, False),
        (ServiceKind.EJECTOR, False),
        (ServiceKind.CELL, True),
        (ServiceKind.REPACK, True),
    ],
)
def test_a_part_that_was_changed_since_may_count_anew(desk: Desk, kind: ServiceKind, speaks: bool) -> None:
    desk.facts.add(serviced(kind, on=date(2026, 4, 1)), "M-07")
    remember(desk.facts, "M-07", boot_count=200)
    assert against(desk, 150), "it was entered before the count was read"
    desk.later()
    desk.facts.add(serviced(kind, on=date(2026, 5, 1)), "M-07")
    assert bool(against(desk, 150)) is speaks


def test_after_half_a_year_the_count_says_nothing(desk: Desk) -> None:
    remember(desk.facts, "M-07", boot_count=12)
    desk.later(days=179)
    assert against(desk, 3)
    remember(desk.facts, "M-07")  # it was seen, but not read
    desk.later(days=2)
    assert against(desk, 3) == []


@pytest.mark.promise("a")
def test_settings_that_differ_are_shown_and_speak_neither_way(desk: Desk) -> None:
    remember(desk.facts, "M-07", boot_count=12, settings=SETTINGS)
    known = remembered(desk.facts, "M-07")
    assert known is not None
    now = conversation(12, attitude_threshold_deg=75, freefall_time_s=1.6)
    assert what_speaks_against(known, now) == ()
    assert [text.in_english() for text in what_differs(known, now, 0.0)] == ["Attitude threshold 75°, was 60°"]
    assert what_differs(known, conversation(12), 0.0) == ()
