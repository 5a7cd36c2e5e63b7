"""What is known under a module's name, what speaks against a person's word for it, services that are due, labels."""

import base64
import re
from collections.abc import Iterator
from contextlib import closing
from datetime import UTC, date, datetime, timedelta
from pathlib import Path
from types import MappingProxyType

import pytest

from app.engine.conversation import ConversationView, How, Known
from app.modules.labels import MAX_NAME_LENGTH, Label, label_body
from app.modules.names import Remembered, modules, remember, remembered, what_differs, what_speaks_against
from app.modules.service import all_due, repack_due, service_summary, serviced
from app.store.fact_store import Facts, Kept, connect
from app.store.rows import ModuleNamed, Row, Serviced, ServiceKind
from app.text.messages import UserError
from protocol.fields import Value

NOW = datetime(2026, 11, 24, 12, tzinfo=UTC)
TODAY = NOW.date()
SETTINGS: dict[str, Value] = {"attitude_threshold_deg": 60, "freefall_time_s": 1.6}


class Desk:
    """Facts on a clock that the test sets."""

    def __init__(self, path: Path) -> None:
        self.now = NOW
        self.facts = Facts(connect(path), "a" * 64, self.tick)

    def tick(self) -> datetime:
        self.now += timedelta(microseconds=1)
        return self.now

    @property
    def known(self) -> Remembered:
        known = remembered(self.facts, "M-07")
        assert known is not None
        return known

    def against(self, boot_count: int | None) -> list[str]:
        return [text.in_english() for text in what_speaks_against(self.known, conversation(boot_count))]


@pytest.fixture
def desk(tmp_path: Path) -> Iterator[Desk]:
    desk = Desk(tmp_path / "dps-s.sqlite")
    with closing(desk.facts.connection):
        yield desk


def conversation(boot_count: int | None = None, **settings: Value) -> ConversationView:
    values = dict(settings) if boot_count is None else {"boot_count": boot_count, **settings}
    known = {key: Known(value, How.READ, 0.0) for key, value in values.items()}
    return ConversationView(number=1, values=MappingProxyType(known))


# Names


def test_what_is_not_given_stays(desk: Desk) -> None:
    remember(desk.facts, "M-07", boot_count=12, settings=SETTINGS)
    remember(desk.facts, "M-07")
    assert (desk.known.boot_count, desk.known.settings) == (12, SETTINGS)
    remember(desk.facts, "M-07", boot_count=13)
    assert (desk.known.boot_count, desk.known.settings) == (13, SETTINGS)
    assert len(desk.facts.of_module(ModuleNamed, "M-07")) == 1


def test_the_last_seen_comes_first(desk: Desk) -> None:
    for name in ("M-01", "M-02", "M-03", "M-01"):
        remember(desk.facts, name)
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
    assert desk.against(now) == ([f"boot count {now}, was {before}"] if speaks else [])


@pytest.mark.parametrize("kind", ServiceKind)
def test_a_part_that_was_changed_since_may_have_reset_the_count(desk: Desk, kind: ServiceKind) -> None:
    desk.facts.add(serviced(kind, on=TODAY), "M-07")
    remember(desk.facts, "M-07", boot_count=200)
    assert desk.against(150), "it was entered before the count was read"
    desk.facts.add(serviced(kind, on=TODAY), "M-07")
    assert bool(desk.against(150)) is (kind in (ServiceKind.CELL, ServiceKind.REPACK))


def test_after_half_a_year_the_count_says_nothing(desk: Desk) -> None:
    remember(desk.facts, "M-07", boot_count=12)
    desk.now += timedelta(days=179)
    assert desk.against(3)
    remember(desk.facts, "M-07")  # it was seen, but not read
    desk.now += timedelta(days=2)
    assert desk.against(3) == []
    remember(desk.facts, "M-07", boot_count=12)
    assert desk.against(3), "it was read again"


@pytest.mark.promise("a")
def test_settings_that_differ_are_shown_and_speak_neither_way(desk: Desk) -> None:
    remember(desk.facts, "M-07", boot_count=12, settings=SETTINGS)
    now = conversation(12, attitude_threshold_deg=75, freefall_time_s=1.6)
    assert what_speaks_against(desk.known, now) == ()
    differs = [text.in_english() for text in what_differs(desk.known, now, 0.0)]
    assert differs == ["Attitude threshold 75°, was 60°"]
    assert what_differs(desk.known, conversation(12), 0.0) == ()


# Services


def kept(
    days: int | None = None, *, on: date = date(2026, 5, 24), kind: ServiceKind = ServiceKind.REPACK,
    at: str = "2026-05-24T12:00:00.000000+00:00",
) -> Kept[Serviced]:  # fmt: skip
    """One that is due again in so many days."""
    due = None if days is None else TODAY + timedelta(days=days)
    content = serviced(kind, on=on, due=due, who="Li Wei", note="\x1b[2J")
    return Kept(Row("0" * 40, "service", "M-07", "a" * 64, at, "{}"), content)


@pytest.mark.parametrize(
    ("days", "said"),
    [
        (31, []),
        (30, [("Repack due on 2026-12-24, days left: 30.", False)]),
        (0, [("Repack due on 2026-11-24, days left: 0.", False)]),
        (-1, [("Repack overdue since 2026-11-23.", True)]),
        (None, []),
    ],
)
def test_what_is_due_is_said_in_time(days: int | None, said: list[tuple[str, bool]]) -> None:
    due = all_due(None, [kept(days)], TODAY)
    assert [(service.text.in_english(), service.is_overdue) for service in due] == said


def test_the_last_of_each_kind_counts_and_none_of_a_day_to_come() -> None:
    late = [kept(-23), kept(-23, kind=ServiceKind.CELL)]
    assert len(all_due(None, late, TODAY)) == 2
    assert all_due(None, [*late, kept(), kept(999, kind=ServiceKind.CELL)], TODAY) == []
    assert len(all_due(None, [*late, kept(on=TODAY + timedelta(days=1))], TODAY)) == 2


@pytest.mark.promise("f")
def test_what_may_have_fired_needs_a_repack_that_was_entered_afterwards() -> None:
    fired, next_day = "2026-11-20T10:00:00.000000+00:00", "2026-11-21T09:00:00.000000+00:00"
    due = repack_due(fired)
    assert due is not None
    assert due.is_after_firing
    before = kept(on=date(2026, 11, 20), at="2026-11-20T09:00:00.000000+00:00")
    backdated = kept(on=date(2026, 11, 18), at=next_day)
    cell = kept(on=date(2026, 11, 21), kind=ServiceKind.CELL, at=next_day)
    assert repack_due(fired, [before, backdated, cell]) is not None
    assert repack_due(fired, [kept(on=date(2026, 11, 21), at=next_day)]) is None
    assert repack_due(None) is None


def test_it_is_told_as_it_was_kept() -> None:
    told = service_summary(kept(12).content).in_english()
    assert told == "Repack on 2026-05-24 by Li Wei, due again: 2026-12-06. [U+001B][2J"
    assert "due again: never" in service_summary(kept().content).in_english()
    with pytest.raises(UserError, match="on a later day"):
        kept(0, on=TODAY)


# Labels: what a person and a scanner read, escaped


@pytest.mark.parametrize(
    ("name", "shown"),
    [
        ("伞仓 07", "伞仓 07"),
        (" <b>&\x1b[31m\u202e ", "&lt;b&gt;&amp;[U+001B][31m[U+202E]"),
        ("M" * MAX_NAME_LENGTH, "M" * MAX_NAME_LENGTH),
    ],
)
def test_a_label_has_name_date_code_and_a_picture(name: str, shown: str) -> None:
    body = label_body(Label(name, NOW, "K7QF-3M2X"))
    assert f"<b>{shown}</b>" in body
    assert "<br>2026-11-24<br>K7QF-3M2X<" in body
    picture = re.search(r'src="data:image/png;base64,([^"]+)"', body)
    assert picture is not None
    assert base64.b64decode(picture[1]).startswith(b"\x89PNG")
    assert "<br>2026-11-24</td>" in label_body(Label(name, NOW)), "no code is better than one of half the settings"


@pytest.mark.parametrize("name", ["   ", "M" * (MAX_NAME_LENGTH + 1)])
def test_a_name_that_no_scanner_reads_has_no_label(name: str) -> None:
    with pytest.raises(UserError, match="at most 60"):
        label_body(Label(name, NOW))
