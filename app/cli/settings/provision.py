"""`dps-s provision --profile FILE --names M-001..M-050`: a batch of new modules, one after the other at one port.

Each module is read, gets the settings of the profile, verified, has both triggers enabled, is checked, gets the next
name, and its record is kept. What fails keeps no name and is set aside with its reason. Nothing is written to a module
that is ACTIVE or may be a known one, and nothing at all without --yes. The same command again goes on with the names
that are left. Exit code 0 if all names are given, 1 if not, 4 if a file could not be written or the store is lost.
"""

import argparse
import html
import json
import time
from collections.abc import Callable, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from datetime import datetime
from functools import partial
from pathlib import Path
from typing import Final

from app import version
from app.cli.settings.set import warn, why_not_verified
from app.engine.identity import IdentityEvidence, Trust, same_module
from app.limits.expectations import Past
from app.preflight.activation import await_while_asking
from app.preflight.evidence import Disturbance, Evidence, FrameLog
from app.preflight.findings import Case, Person
from app.preflight.module_checks import FINGERPRINT_KEYS
from app.preflight.provision import await_gone, provision
from app.preflight.verdict import Verdict, assess
from app.procedures.write_all import SettingChange, WriteContext, WriteReport
from app.records.filing import file_check
from app.records.labels import A4, PAPERS, Label, label_body
from app.records.report_files import carried_in_pdf, check_target
from app.settings.fingerprint import fingerprint
from app.settings.profile_file import read_profile
from app.settings.profiles import SETTINGS_BY_KEY, Profile
from app.store.database import StoreTrouble
from app.store.facts import FactKind
from app.store.store import Store, open_store
from app.store.store_journal import KnownAs, StoreJournal, new_run
from app.system.files import write_whole
from app.terminal import console
from app.terminal.colours import Colour, LargeLine, coloured
from app.terminal.command_journal import adapter_of
from app.terminal.connection import Conversation, LinkTrouble, connected
from app.terminal.interruption import Interruption
from app.terminal.setting_words import typed
from app.text.csv_cells import csv_text, utc_cell
from app.text.i18n import tr
from app.text.messages import UserMessage, clean, joined, message, message_from_json
from app.text.sentences import join_sentences, not_written
from protocol.catalogue import BAUD_RATE
from protocol.translatable import marked

HEAD: Final = ("name", "result", "time_utc", "settings_code", "boot_count", "why")
FORMAT: Final = "dps-s batch"
"""Marks the files of a batch, which a batch may replace."""
READY, SET_ASIDE, OPEN = marked("READY"), marked("SET ASIDE"), marked("open")
_LOOKS, _LOOK_EVERY_S = 5, 0.1
"""Pauses between two attempts to find a module."""
_ROWS_ON_PAGE: Final = 40
_TRIGGERS: Final = ("attitude_trigger", "freefall_trigger")


def run(args: argparse.Namespace) -> int:
    batch = _batch_of(args)
    for path in filter(None, (args.labels, args.list)):
        check_target(path, lambda _file: True)
        for file in (path, path.with_suffix(".csv")):
            if file.exists() and not _is_ours(file):
                raise console.Refused(tr("{file} exists and is of no batch: choose another name.", file=file))
    if not args.yes:
        return _say_what_happens(batch)
    warn(batch.changes)
    if any(change.risks for change in batch.changes) and not args.accept_risk:
        return console.refuse_without("--accept-risk")
    if not args.enable_triggers and not all(batch.profile.settings.get(key) is True for key in _TRIGGERS):
        return console.refuse_without("--enable-triggers")
    with closing(open_store()) as store:
        trouble: BaseException | None = None
        try:
            with Interruption() as interruption:
                _Bench(batch, store, args, interruption).run()
        except (KeyboardInterrupt, StoreTrouble) as error:
            trouble = error
        rows = _rows(batch, _kept(store, batch))
        console.write_lines(["", *console.columns([row.cells() for row in rows])])
        is_written = _write_files(args, batch, rows)
    if isinstance(trouble, StoreTrouble):
        console.notify(join_sentences((trouble.sentence, tr("Not kept."))))
        return console.PARTIAL
    if trouble is not None:
        raise trouble
    if not is_written:
        return console.PARTIAL
    return console.SUCCESS if not any(row.result == OPEN for row in rows) else console.ANSWER_NO


@dataclass(frozen=True, slots=True)
class _Batch:
    names: tuple[str, ...]
    profile: Profile
    changes: tuple[SettingChange, ...]

    @property
    def title(self) -> str:
        return "..".join(dict.fromkeys((self.names[0], self.names[-1])))

    @property
    def key(self) -> str:
        """The same for the same names and settings: what is done is left out."""
        return f"{self.title} {len(self.names)} {fingerprint(self.profile.settings).code}"


def _batch_of(args: argparse.Namespace) -> _Batch:
    """Raises `UserError` where a batch cannot pass the check."""
    profile = read_profile(args.profile)
    settings = {key: value for key, value in profile.settings.items() if SETTINGS_BY_KEY[key] is not BAUD_RATE}
    if not settings:
        raise console.Refused(tr("{path} holds no settings.", path=args.profile))
    if profile.settings.get("baud_rate", args.baud) != args.baud:
        raise console.Refused(tr("A batch does not change the baud rate: take it out of the profile."))
    if profile.tests_within_days or any(line.is_required for line in profile.manual):
        raise console.Refused(tr("The profile demands manual checks or guided tests, which a batch does not have."))
    changes = tuple(SettingChange(SETTINGS_BY_KEY[key], value) for key, value in settings.items())
    return _Batch(args.names, profile, changes)


def _say_what_happens(batch: _Batch) -> int:
    console.write_lines([
        tr("Each module plugged in gets these settings, has both triggers enabled, is checked and named:"),
        *console.columns([(change.command.key, typed(change.value)) for change in batch.changes], indent=2),
        f"  {batch.title}",
    ])  # fmt: skip
    return console.refuse_without("--yes")


# The modules


class _Bench:
    """Takes one module after the other at one port."""

    def __init__(self, batch: _Batch, store: Store, args: argparse.Namespace, interruption: Interruption) -> None:
        self._batch, self._store, self._args, self._interruption = batch, store, args, interruption
        self._said = ""
        self._last = ""
        """The name given last."""

    def run(self) -> None:
        done = {row.name for row in _kept(self._store, self._batch) if row.result == READY}
        for name in self._batch.names:
            if name in done:
                continue
            if self._store.module_named(name) is not None:
                console.notify(tr("{module} is the name of another module: left out.", module=name))
                continue
            while not self._take(name):
                self._interruption.check()

    def _take(self, name: str) -> bool:
        """Wait for a module, and for its end; whether it has the name now."""
        self._say(tr("PLUG IN: {module}", module=name))
        log = FrameLog()
        with (
            LinkTrouble() as link,
            connected(self._args.port, self._args.baud, interruption=self._interruption,
                      on_batch=lambda batch: log.feed(batch.events)) as conversation,
        ):  # fmt: skip
            self._said = ""
            console.write_lines([tr("A module answers: leave it plugged in.")])
            return self._provision(name, conversation, log)
        console.show_progress(link.sentence or "")
        for _ in range(_LOOKS):
            self._interruption.check()
            time.sleep(_LOOK_EVERY_S)
        return False

    def _provision(self, name: str, conversation: Conversation, log: FrameLog) -> bool:
        store, port = self._store, self._args.port
        evidence = Evidence(port=port)
        journal = StoreJournal(
            store, port=port, origin="provision", adapter=adapter_of(port), known_as=KnownAs(run=new_run())
        )
        accepted = frozenset(self._batch.changes if self._args.accept_risk else ())
        context = WriteContext(journal=journal, accepted_risks=accepted)
        find_known = partial(_resembling, self._known())
        done = None
        try:
            with LinkTrouble():
                done = conversation.run(
                    provision(
                        evidence, self._batch.changes, context, find_known, is_enabling=self._args.enable_triggers
                    )
                )
        except KeyboardInterrupt:
            console.notify(tr("Interrupted; may have been carried out."))
            raise
        why = message(Disturbance.DISCONNECTED.value) if done is None else done.why or _write_fault(done.report)
        keeping = store.queue.submit(
            partial(self._keep, name, evidence, log, why, None if done is None else done.boot_count)
        )
        with LinkTrouble():
            conversation.run(await_while_asking(keeping))
        why = keeping.result()
        if why is None:
            self._last = name
            console.write_lines([coloured(f"{name}: {tr(READY)}", Colour.GOOD)])
        else:
            console.write_lines([coloured(f"{tr(SET_ASIDE)}: {why.translated()}", Colour.BAD)])
        if why is None and name == self._batch.names[-1]:
            return True
        self._say(tr("UNPLUG, NEXT"))
        with LinkTrouble():
            if done is not None:
                conversation.run(await_gone(done.presence))
        return why is None

    def _known(self) -> list[tuple[str, IdentityEvidence]]:
        """The modules that what is plugged in may be."""
        names = [self._last] if self._args.all_new else [module.name for module in self._store.modules()]
        return [(name, self._store.evidence(name)) for name in names if name]

    def _keep(
        self, name: str, evidence: Evidence, log: FrameLog, why: UserMessage | None, boot_count: int | None
    ) -> UserMessage | None:
        """Keep the record, under the name only where it is READY; why it is set aside. Raises `StoreTrouble`."""
        person = Person(who=self._args.who, module=name, are_records_reviewed=self._args.records_reviewed,
                        is_named_by_option=True)  # fmt: skip
        profile = self._batch.profile
        judged = assess(Case(evidence=evidence, profile=profile, past=Past(module=name), person=person))
        if why is None and judged.verdict is not Verdict.READY:
            why = joined(judged.titles_against)
        person = replace(person, module=None if why else name)
        settings = evidence.settings(FINGERPRINT_KEYS)
        with self._store.database.transaction():
            if evidence.began_at is not None:
                filed = file_check(evidence, profile, person, log, store=self._store,
                                   program_version=version(), past=Past(module=person.module),
                                   adapter=adapter_of(self._args.port))  # fmt: skip
                if filed.trouble is not None:
                    raise filed.trouble
            if why is None:
                self._store.store_evidence(name, IdentityEvidence(boot_count, settings))
            content = {"name": name, "why": None if why is None else why.to_json(),
                       "settings_code": fingerprint(settings).code, "boot_count": boot_count}  # fmt: skip
            self._store.facts.add(FactKind.PROVISIONED, content, module=person.module, link=self._batch.key)
        return why

    def _say(self, sentence: str) -> None:
        """Once, in large letters."""
        if sentence != self._said:
            self._said = sentence
            console.write_lines([LargeLine(sentence)])


def _resembling(known: Sequence[tuple[str, IdentityEvidence]], now: IdentityEvidence) -> str | None:
    """The first module that nothing refutes; what is known too little of refutes itself."""
    fits = (name for name, before in known if before.is_complete and same_module(before, now) is not Trust.REFUTED)
    return next(fits, None)


def _write_fault(report: WriteReport | None) -> UserMessage | None:
    """The first setting that was not verified; None where all are."""
    if report is None or report.is_fine:
        return None
    for written in report.results:
        why = why_not_verified(written, report.refusals)
        if why is not None:
            return message(marked("{setting}: {what}"), setting=message(written.command.title), what=why)
    return message(marked("A setting changed without being written, or could not be read again."))


# The list


@dataclass(frozen=True, slots=True)
class _Row:
    """A name, or a module that was set aside, which has none."""

    name: str
    result: str = OPEN
    at: str = ""
    code: str = ""
    boot_count: object = None
    why: UserMessage | None = None

    def cells(self) -> tuple[str, ...]:
        """For people."""
        boots = "" if self.boot_count is None else str(self.boot_count)
        return (
            self.name,
            tr(self.result),
            utc_cell(self.at),
            self.code,
            boots,
            "" if self.why is None else self.why.translated(),
        )


def _kept(store: Store, batch: _Batch) -> list[_Row]:
    """What was done in this batch, also in former runs."""
    facts = store.facts.select(FactKind.PROVISIONED, "AND link = ? ORDER BY number", (batch.key,))
    rows = []
    for fact in facts:
        name, why, code, boots = (fact.content[key] for key in ("name", "why", "settings_code", "boot_count"))
        if why is None:
            rows.append(_Row(str(name), READY, fact.at, str(code or ""), boots))
        else:
            rows.append(_Row("", SET_ASIDE, fact.at, str(code or ""), boots, message_from_json(why)))
    return rows


def _rows(batch: _Batch, kept: Sequence[_Row]) -> list[_Row]:
    """Every name, then what was set aside."""
    done = {row.name: row for row in kept if row.result == READY}
    return [*(done.get(name, _Row(name)) for name in batch.names), *(row for row in kept if row.result == SET_ASIDE)]


def _is_ours(path: Path) -> bool:
    """Whether a batch may replace this file."""
    try:
        data = path.read_bytes()
    except OSError:
        return False
    return any(carried_in_pdf(data, FORMAT)) or data.startswith(",".join(HEAD).encode())


def _write_files(args: argparse.Namespace, batch: _Batch, rows: Sequence[_Row]) -> bool:
    """The labels of the names that are given, and the list as PDF and CSV."""
    mark, is_written = json.dumps({"format": FORMAT}).encode(), True
    labels = [
        Label(row.name, datetime.fromisoformat(row.at).astimezone(), row.code) for row in rows if row.result == READY
    ]
    works: list[tuple[Path | None, Callable[[Path], object]]] = [
        (args.list, lambda path: write_whole(path.with_suffix(".csv"), _csv(rows).encode())),
        (args.list, lambda path: write_whole(path, args.printer(_pages(batch, rows), A4, mark))),
        (args.labels if labels else None,
         lambda path: write_whole(path, args.printer(list(map(label_body, labels)), PAPERS[args.tape], mark))),
    ]  # fmt: skip
    for path, write in works:
        if path is None:
            continue
        try:
            write(path)
        except (OSError, RuntimeError) as error:
            console.notify(not_written(path, error))
            is_written = False
    return is_written


def _csv(rows: Sequence[_Row]) -> str:
    return csv_text(HEAD, (
        (row.name, row.result.lower(), utc_cell(row.at), row.code, row.boot_count,
         "" if row.why is None else row.why.in_english()) for row in rows
    ))  # fmt: skip


def _pages(batch: _Batch, rows: Sequence[_Row]) -> list[str]:
    """The list as HTML, by page."""
    head = [tr(title) for title in (marked("Module"), marked("Result"), marked("Time (UTC)"), marked("Settings code"),
                                    marked("Boot count"), marked("Why not"))]  # fmt: skip
    count = sum(row.result == READY for row in rows)
    title = tr("Batch {names}, profile {profile}: {count} of {all} done", names=batch.title,
               profile=clean(batch.profile.name), count=count, all=len(batch.names))  # fmt: skip
    return [
        f'<p><font size="5"><b>{html.escape(title)}</b></font></p>'
        '<table width="100%" cellpadding="3" cellspacing="0" border="1">'
        + "".join(
            "<tr>" + "".join(f"<td>{html.escape(cell)}</td>" for cell in cells) + "</tr>"
            for cells in (head, *(row.cells() for row in rows[start : start + _ROWS_ON_PAGE]))
        )
        + "</table>"
        for start in range(0, len(rows), _ROWS_ON_PAGE)
    ]
