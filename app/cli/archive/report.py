"""`dps-s archive report`: the present state of all modules, or the history of one, from all stations."""

import argparse
from collections.abc import Iterable
from datetime import UTC, datetime

from app.archive.fleet_state import ModuleToday, fleet_state
from app.archive.module_history import ModuleHistory, module_history
from app.cli.archive.opened import member_json, opened_archive
from app.records.check_store import CheckLine
from app.stations.station import shown_station
from app.terminal import console
from app.text.csv_cells import csv_text, utc_cell
from app.text.i18n import tr
from app.text.sentences import labelled

FLEET_HEAD = (
    "module", "stations", "last_at", "verdict", "void", "simulated", "check_at", "check_number", "who", "aircraft",
    "fingerprint", "checks", "trigger_records", "not_judged", "due",
    "since_repack",
)  # fmt: skip
LIFE_HEAD = ("at", "station", "kind", "told", "value_name", "value")


def run(args: argparse.Namespace) -> int:
    with opened_archive() as archive:
        archive.collect()
        names = archive.names()
        if args.module is not None:
            lives = [module_history(archive.facts, one) for one in names.named(args.module)]
            if not lives:
                console.notify(labelled(args.module, tr("none")))
                return console.ANSWER_NO
            return _print_histories(args, lives)
        now = datetime.now(UTC)
        states = fleet_state(archive.facts, names, now, check_days=args.check_days, test_days=args.test_days)
    return _print_fleet(args, states, now)


def _print_fleet(args: argparse.Namespace, states: list[ModuleToday], now: datetime) -> int:
    if args.csv:
        console.write(csv_text(FLEET_HEAD, map(_fleet_cells, states)))
        return console.SUCCESS
    at = now.isoformat(timespec="seconds")
    head = (tr("Module"), tr("Last check"), tr("Verdict"), tr("Trigger records"), tr("Due"))
    console.emit(args, states, lambda states: {"at": at, "modules": [state_json(state) for state in states]},
                 lambda states: console.columns([head, *map(_fleet_row, states)]))  # fmt: skip
    return console.SUCCESS


def _fleet_row(state: ModuleToday) -> tuple[str, ...]:
    check = state.last_check
    at, verdict = (check.at[:16].replace("T", " "), check.words.translated()) if check else ("", tr("none"))
    return (state.module.name, at, verdict, state.counted.translated(), state.due_words)


def _print_histories(args: argparse.Namespace, lives: list[ModuleHistory]) -> int:
    if args.csv:
        console.write(csv_text(LIFE_HEAD, (row for life in lives for row in _life_rows(life))))
    else:
        console.emit(args, lives, lambda lives: {"lives": [life_json(live) for live in lives]},
                     lambda lives: [line for life in lives for line in _life_page(life)])  # fmt: skip
    return console.SUCCESS


def _life_page(life: ModuleHistory) -> list[str]:
    rows = [
        (event.fact.made_at[:19].replace("T", " "), shown_station(event.fact.station)[:9], event.text.translated())
        for event in life.events
    ]
    return [life.module.name, *console.columns([(tr("Time"), tr("Station"), ""), *rows])]


def state_json(state: ModuleToday) -> dict[str, object]:
    check = state.last_check
    return {
        "module": state.module.name,
        "members": [member_json(member) for member in state.module.members],
        "last_at": state.last_at or None,
        "last_check": None if check is None else _check_json(check),
        "checks": state.checks,
        "trigger_records": state.trigger_records,
        "not_judged": state.unjudged,
        "since_repack": state.since_repack,
        "tests": [{"test": test.kind.value, "verdict": test.verdict.value, "at": test.at} for test in state.tests],
        "due": [{"kind": one.kind.value, "text": one.text.in_english()} for one in state.due],
    }


def _check_json(check: CheckLine) -> dict[str, object]:
    return {
        "at": check.at, "station": shown_station(check.station), "number": check.number, "verdict": check.verdict,
        "void": check.is_void, "simulated": check.is_simulated,
        "altered": check.is_altered, "who": check.who, "aircraft": check.aircraft,
        "fingerprint": check.fingerprint, "hash": check.hash,
    }  # fmt: skip


def life_json(life: ModuleHistory) -> dict[str, object]:
    return {
        "module": life.module.name,
        "members": [member_json(member) for member in life.module.members],
        "events": [
            {"at": event.fact.made_at, "station": shown_station(event.fact.station), "kind": event.fact.kind,
             "id": event.fact.id, "told": event.text.in_english(), "content": dict(event.fact.content)}
            for event in life.events
        ],
        "values": {
            name: [{"at": point.at, "station": shown_station(point.station), "value": point.value} for point in points]
            for name, points in life.values.items()
        },
    }  # fmt: skip


def _fleet_cells(state: ModuleToday) -> tuple[object, ...]:
    check = state.last_check
    of_check = (
        (None,) * 8
        if check is None
        else (check.verdict, check.is_void, check.is_simulated, utc_cell(check.at), check.number, check.who,
              check.aircraft, check.fingerprint)
    )  # fmt: skip
    stations = len({member.station for member in state.module.members})
    counts = (state.checks, state.trigger_records, state.unjudged)
    return (
        state.module.name,
        stations,
        utc_cell(state.last_at),
        *of_check,
        *counts,
        state.due_words,
        state.since_repack,
    )


def _life_rows(life: ModuleHistory) -> Iterable[tuple[object, ...]]:
    for event in life.events:
        station = shown_station(event.fact.station)
        yield utc_cell(event.fact.made_at), station, event.fact.kind, event.text.translated(), None, None
    for name, points in life.values.items():
        for point in points:
            yield utc_cell(point.at), shown_station(point.station), "value", "", name, point.value
