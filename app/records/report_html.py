"""Renders a record as HTML for the printer, in the current language.

Made from the record alone, so that it prints the same years later. The record is untrusted: texts are escaped and cut,
control characters made visible. Uses only what Qt's rich text supports: tables, colours and sizes.
"""

import html
from collections.abc import Iterable, Mapping
from datetime import datetime, tzinfo
from itertools import zip_longest

from app.guided.results import TITLES, VERDICT_WORDS, GuidedKind, GuidedVerdict, StoredTest, stored_test
from app.preflight.evidence import Disturbance
from app.preflight.findings import RESULT_WORDS, CheckResult
from app.preflight.verdict import MANUAL_WORDS, Verdict, verdict_sentence
from app.records.record import NOT_STORED, Record, activated_by, caveats, list_in, recorded_verdict
from app.stations.station import KEY_BYTES, decoded, fingerprint_of
from app.system.wall_clock import DAY, local_time
from app.text.i18n import tr
from app.text.messages import UserMessage, clean, message_from_json
from app.text.sentences import in_brackets, join_sentences, labelled

INK, PALE, GREEN, BLUE, RED, AMBER = "#111111", "#555555", "#0b5d1e", "#0b4a9e", "#a4001d", "#7a4b00"
_LONGEST_CELL, _LONGEST_ITEM = 160, 100
"""Characters; the whole text is in the record."""
_ONE_COLUMN = 8
_MAX_ROWS = 60
_MARKS = {
    CheckResult.PASS: ("√", GREEN),
    CheckResult.FAIL: ("×", RED),
    CheckResult.WARN: ("!", AMBER),
    CheckResult.UNKNOWN: ("?", RED),
}
VERDICT_STYLES = {Verdict.GO: ("√", GREEN), Verdict.READY: ("■", BLUE), Verdict.NO_GO: ("×", RED)}
_TEST_MARKS = {
    GuidedVerdict.PASSED: ("√", GREEN),
    GuidedVerdict.FAILED: ("×", RED),
    GuidedVerdict.UNCLEAR: ("?", RED),
}
_VOID_WHY: Mapping[str, str] = {disturbance.name.lower(): disturbance.value for disturbance in Disturbance}


def body(record: Record) -> str:
    checks = [check for check in list_in(record, "checks") if isinstance(check, Mapping)][:_MAX_ROWS]
    manual = [item for item in list_in(record, "manual") if isinstance(item, Mapping)][:_MAX_ROWS]
    is_crowded = (
        len(manual) > _ONE_COLUMN and sum(_result(check) is not CheckResult.PASS for check in checks) > _ONE_COLUMN
    )
    middle = _checks(checks, is_crowded=is_crowded), _manual(manual), _tests(record)
    return "\n".join((_head(record), _context_rows(record), *middle, _footer(record)))


def guided_body(record: Record) -> str:
    """What is printed of guided tests: those in `record`, with its module."""
    title = labelled(tr("Guided tests"), clean(str(record.get("module"))))
    return "\n".join((_heading(title), _tests(record), _signature()))


def _heading(title: str) -> str:
    return (
        f'<p style="margin:0"><font size="5"><b>{_escaped(title)}</b></font>'
        f' <span style="color:{PALE}">DPS-S</span></p>'
    )


def _signature() -> str:
    line = "_" * 28
    signed = f"{_escaped(tr('Signature'))} {line} &nbsp; {_escaped(tr('Name, date'))} {line}"
    return f'<p style="margin-top:12px;margin-bottom:4px">{signed}</p>'


def _head(record: Record) -> str:
    void, verdict, checks = record.get("void"), recorded_verdict(record), list_in(record, "checks")
    results = [_result(check) for check in checks]
    passed, looks = results.count(CheckResult.PASS), results.count(CheckResult.WARN)
    mark, colour = VERDICT_STYLES[verdict if void is None else Verdict.NO_GO]
    word = verdict_sentence(verdict, activated_by(record)).translated()
    skipped = sum(1 for item in list_in(record, "manual") if isinstance(item, Mapping) and item.get("is_done") is None)
    if verdict is not Verdict.NO_GO and void is None:
        under = tr("Passed: {count}; warnings: {looks}.", count=passed, looks=looks)
    else:
        under = tr("{count} of {all} checks not OK.", count=len(checks) - passed - looks, all=len(checks))
    if void is not None:
        word = f"{word} — {tr('VOID')}"
        why = _VOID_WHY.get(str(void), str(void))
        under = join_sentences((under, tr("Void: {why}.", why=tr(why))))
    if skipped:
        under = join_sentences((under, tr("Skipped: {count}.", count=skipped)))
    under = join_sentences([*(caveat.translated() for caveat in caveats(record)), under])
    return (
        f"{_heading(tr('Pre-flight check of a parachute module'))}"
        '<table width="100%" cellpadding="6" cellspacing="0" border="0" style="margin-top:4px"><tr>'
        f'<td bgcolor="{colour}" style="background-color:{colour};color:#ffffff">'
        f'<font size="7" color="#ffffff"><b>{mark}&nbsp;{_escaped(word)}</b></font><br>'
        f'<span style="color:#ffffff">{_escaped(under)}</span></td></tr></table>'
    )


def _context_rows(record: Record) -> str:
    program = record.get("program")
    version = program.get("version", "") if isinstance(program, Mapping) else ""
    read = record.get("read")
    link = read.get("link") if isinstance(read, Mapping) else None
    port, rate = (link.get("port"), link.get("baud_rate")) if isinstance(link, Mapping) else (None, None)
    boot = read.get("boot_count") if isinstance(read, Mapping) else None
    cells = (
        (tr("Module"), record.get("module") or tr("Unnamed")),
        (tr("Time"), _time(record)),
        (tr("Aircraft"), record.get("aircraft") or "—"),
        (tr("Checked by"), record.get("who") or "—"),
        (tr("Profile"), record.get("profile") or tr("Vendor's advice")),
        (tr("Settings code"), record.get("fingerprint") or tr("unknown")),
        (tr("Boot count"), tr("unknown") if boot is None else boot),
        (tr("Port"), tr("{port}, {rate} baud", port=port, rate=rate)),
        (tr("Record"), _number(record)),
        (tr("Program"), f"DPS-S Configurator {version}"),
    )
    rows = []
    for left, right in zip(cells[::2], cells[1::2], strict=True):
        rows.append("<tr>" + "".join(
            f'<td width="14%" style="color:{PALE}">{_escaped(name)}</td>'
            f'<td width="36%"><b>{_cell(value, longest=_LONGEST_ITEM)}</b></td>'
            for name, value in (left, right)
        ) + "</tr>")  # fmt: skip
    return _table(rows)


def _checks(checks: list[Mapping[str, object]], *, is_crowded: bool) -> str:
    """`is_crowded` leaves out why a check matters, and keeps what to do."""
    head = "".join(
        f'<td width="{width}" style="color:{PALE}">{_escaped(title)}</td>'
        for title, width in ((tr("Result"), "13%"), (tr("Check"), "29%"), (tr("Measured"), "29%"), (tr("Limit"), "29%"))
    )
    return _table([f'<tr bgcolor="#eeeeee">{head}</tr>', *(_row(check, is_crowded=is_crowded) for check in checks)])


def _table(rows: Iterable[str]) -> str:
    return f'<table width="100%" cellpadding="1" cellspacing="0" style="margin-top:4px">{"".join(rows)}</table>'


def _title(text: str, columns: int) -> str:
    return f'<tr bgcolor="#eeeeee"><td colspan="{columns}" style="color:{PALE}">{_escaped(text)}</td></tr>'


def _row(check: Mapping[str, object], *, is_crowded: bool) -> str:
    result = _result(check)
    mark, colour = _MARKS[result]
    word = tr(RESULT_WORDS[result])
    cells = (
        f'<span style="color:{colour}"><b>{mark}&nbsp;{_escaped(word)}</b></span>',
        _message_html(UserMessage(str(check.get("title", "")))), _message_html(message_from_json(check.get("shown"))),
        _message_html(message_from_json(check.get("limit"))),
    )  # fmt: skip
    if result is CheckResult.PASS:
        return "<tr>" + "".join(f"<td>{cell}</td>" for cell in cells) + "</tr>"
    row = "".join(f"<td><b>{cell}</b></td>" for cell in cells[:3]) + f"<td>{cells[3]}</td>"
    why, do = _message_html(UserMessage(str(check.get("why", "")))), _message_html(message_from_json(check.get("do")))
    more = do if is_crowded else f"{why} → {do}"
    more = f'<td></td><td colspan="3"><small><span style="color:{PALE}">{more}</span></small></td>'
    return f'<tr>{row}</tr><tr bgcolor="#f6f6f6">{more}</tr>'


def _manual(manual: list[Mapping[str, object]]) -> str:
    if not manual:
        return ""
    cells = []
    for item in manual:
        state = item.get("is_done")
        is_done = state if isinstance(state, bool) else None
        mark, colour = {True: ("√", GREEN), False: ("×", RED), None: ("–", AMBER)}[is_done]
        state_cell = f"<b>{mark}&nbsp;{_escaped(tr(MANUAL_WORDS[is_done]))}</b>"
        text_cell = _cell(item.get("text"), longest=_LONGEST_ITEM)
        cells.append(f'<td width="13%" style="color:{colour}">{state_cell}</td><td>{text_cell}</td>')
    columns = 2 if len(cells) > _ONE_COLUMN else 1
    half = -(-len(cells) // columns)
    pairs = zip_longest(*(cells[start : start + half] for start in range(0, len(cells), half)), fillvalue="<td></td>")
    rows = [f"<tr>{''.join(pair)}</tr>" for pair in pairs]
    return _table([_title(tr("Manual checks"), 2 * columns), *rows])


def _tests(record: Record) -> str:
    """The last guided tests at the time of the check."""
    tests = [test for test in list_in(record, "tests") if isinstance(test, Mapping)][: len(GuidedKind)]
    made_at = _made_at(record)
    zone = None if made_at is None else made_at.tzinfo
    rows = [
        _test_row(test, zone) for fields in tests if (test := stored_test(fields, str(fields.get("at")))) is not None
    ]
    if not rows:
        return ""
    return _table([_title(tr("Guided tests"), 4), *rows])


def _test_row(test: StoredTest, zone: tzinfo | None) -> str:
    mark, colour = _TEST_MARKS[test.verdict]
    when = f"{local_time(test.at, DAY, zone)}, {test.who or '—'}"
    if test.is_simulated:
        when = f"{when}, {tr('simulated')}"
    word, title = tr(VERDICT_WORDS[test.verdict]), tr(TITLES[test.kind])
    values = [_measured_text(row) for row in test.measured[:10]]
    return (
        f'<tr><td width="13%" style="color:{colour}"><b>{mark}&nbsp;{_escaped(word)}</b></td>'
        f'<td width="17%">{_escaped(title)}</td><td width="20%">{_cell(when, longest=_LONGEST_ITEM)}</td>'
        f"<td><small>{_escaped('; '.join(values))}</small></td></tr>"
    )


def _measured_text(row: Mapping[str, object]) -> str:
    name, shown, tolerance = (message_from_json(row.get(key)).translated() for key in ("name", "shown", "tolerance"))
    return f"{name}: {shown}{in_brackets(tolerance)}"


def _footer(record: Record) -> str:
    note = tr("“dps-s verify FILE” tells what this file says and who signed it. Keep it with the aircraft.")
    previous = record.get("previous") or tr("none")
    public = decoded(record.get("station"), KEY_BYTES)
    station = tr("none") if public is None else fingerprint_of(public)
    return (
        f"{_signature()}"
        f'<p style="margin:0;color:{PALE}"><small>{_escaped(tr("Station"))}: {_escaped(station)}<br>'
        f"SHA-256 {_cell(record.get('hash'))}<br>"
        f"{_escaped(tr('Previous record'))}: {_cell(previous)}<br>{_escaped(note)}</small></p>"
    )


def _result(check: object) -> CheckResult:
    try:
        return CheckResult(check.get("result") if isinstance(check, Mapping) else None)
    except ValueError:
        return CheckResult.UNKNOWN


def _number(record: Record) -> str:
    number = record.get("number")
    if number == NOT_STORED:
        return tr("not kept")
    if record.get("module") is None and record.get("adapter"):
        return f"{tr('No. {number}', number=number)}{in_brackets(str(record['adapter']))}"
    return tr("No. {number}", number=number)


def _made_at(record: Record) -> datetime | None:
    try:
        return datetime.fromisoformat(str(record.get("at")))
    except ValueError:
        return None


def _time(record: Record) -> str:
    at = _made_at(record)
    if at is None:
        return str(record.get("at"))
    offset = f"{at:%z}"
    zone = f" UTC{offset[:3]}:{offset[3:5]}" if offset.strip("+-0") else " UTC" if offset else ""
    return f"{at:%Y-%m-%d %H:%M:%S}{zone}"


def _message_html(sentence: UserMessage) -> str:
    return _escaped(sentence.translated())


def _cell(value: object, *, longest: int = _LONGEST_CELL) -> str:
    return _escaped(str(value), longest=longest)


def _escaped(text: str, *, longest: int = 2 * _LONGEST_CELL) -> str:
    return html.escape(clean(text, longest=longest))
