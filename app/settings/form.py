"""Form model of a module's settings: module value, edited value and row state.

    unknown       never reported by the module, or lost for good
    read          read from the module, or reported unasked
    acknowledged  set and acknowledged; it cannot be read back (E8)
    stale         known earlier, but something casts doubt on it
    edited        another value was entered and not sent yet
    not possible  what was typed cannot be sent; nothing is written while it stands
    writing
    verified      written and read back equal, and nothing has cast doubt on it since
    changed       reads differently than before, and was not written here
    failed        the write failed; with the reason, until the module has the value

The baud rate is not a row of the form: changing it may cut the link, so it has a procedure and a panel of its own.
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from enum import Enum
from typing import NamedTuple

from app.engine.device import DeviceView, How, Known
from app.engine.setting_changes import ChangedSetting
from app.procedures.write import WriteFault, Written
from app.procedures.write_all import SettingChange
from app.safety.consequences import Consequence, consequences
from app.settings.setting_texts import value_text
from app.settings.settings_watch import SettingsWatch
from app.text.i18n import tr
from protocol.catalogue import BAUD_RATE, SERIAL_OUTPUT, SETTINGS, Command
from protocol.fields import Value
from protocol.translatable import marked

FORM_COMMANDS: tuple[Command, ...] = (
    *(command for command in SETTINGS if command.reads_back),
    *(command for command in SETTINGS if not command.reads_back and command not in (BAUD_RATE, SERIAL_OUTPUT)),
    SERIAL_OUTPUT,
)
"""In the order of the rows, thresholds first."""
_BY_KEY = {command.key: command for command in FORM_COMMANDS}


class RowState(Enum):
    """The value is its English, translatable word."""

    UNKNOWN = marked("unknown")
    READ = marked("read")
    ACKNOWLEDGED = marked("acknowledged")
    STALE = marked("stale")
    EDITED = marked("edited")
    IMPOSSIBLE = marked("not possible")
    WRITING = marked("writing")
    VERIFIED = marked("verified")
    CHANGED = marked("changed")
    FAILED = marked("failed")


@dataclass(frozen=True, slots=True, kw_only=True)
class FormRow:
    command: Command
    module_value: Known | None
    edited: Value | None
    state: RowState
    reason: str = ""
    """Why it failed, in the language in use."""
    is_pending: bool = False
    """The next write will send it."""
    mistyped: str = ""
    """What was typed and cannot be sent."""

    @property
    def consequences(self) -> tuple[Consequence, ...]:
        """Of the edited value, else of the module's."""
        value = self.edited
        if value is None and self.module_value is not None and not self.module_value.is_stale:
            value = self.module_value.value
        return () if value is None else consequences(self.command, value)


class _Failure(NamedTuple):
    target: Value
    text: str
    read_back: Value | None = None


_INTERRUPTED = marked("interrupted while writing; the value is unknown")


class SettingsForm:
    """See the module docstring. Belongs to one thread.

    `is_in_doubt`: whether the module may be another one; nothing that it reports settles an edit or a failure then, and
    no row says what came of a write.
    """

    def __init__(self, is_in_doubt: Callable[[], bool] = bool, watch: SettingsWatch | None = None) -> None:
        self._is_in_doubt = is_in_doubt
        self._edited: Mapping[str, Value] = {}
        """The edited values by the setting's key; replaced, never modified."""
        self._mistyped: dict[str, str] = {}
        """What was typed and cannot be sent, by the setting's key."""
        self._writing: dict[str, Value] = {}
        self._verified: dict[str, Value] = {}
        self._seen: tuple[int, float | None] | None = None
        """Restart count and `presence_since` at the last look."""
        self._failures: dict[str, _Failure] = {}
        self.watch = watch or SettingsWatch()
        """Of the connection; it knows what other parts of the program write."""

    # Editing

    def choose(self, key: str, value: Value) -> None:
        self._forget_mistyped([key])
        self._change({**self._edited, key: value})

    def mistype(self, key: str, text: str) -> None:
        """What was typed is no value: it takes the place of the edit, so that half of it is never sent."""
        if self._writing:
            return
        self.revert(key)
        self._mistyped[key] = text

    def fill(self, values: Mapping[str, Value]) -> None:
        """Edits all of these; keys that are not rows of the form are ignored."""
        known = {key: value for key, value in values.items() if key in _BY_KEY}
        self._forget_mistyped(known)
        self._change({**self._edited, **known})

    def revert(self, key: str | None = None) -> None:
        """Removes the edit of one row, or all edits."""
        self._forget_mistyped(list(self._mistyped) if key is None else [key])
        self._change({} if key is None else {name: value for name, value in self._edited.items() if name != key})

    def _forget_mistyped(self, keys: Iterable[str]) -> None:
        if not self._writing:
            for key in keys:
                self._mistyped.pop(key, None)

    def _change(self, values: Mapping[str, Value]) -> None:
        """Replaces the edits, and removes failures of settings that are no longer edited."""
        if self._writing or values == self._edited:
            return
        self._edited = values
        self._failures = {key: failure for key, failure in self._failures.items() if key in values}

    def _drop(self, keys: Iterable[str]) -> None:
        """Removes these edits, of values that the module has now."""
        gone = frozenset(keys)
        self._edited = {key: value for key, value in self._edited.items() if key not in gone}

    # Rows

    def rows(self, device: DeviceView, now: float) -> tuple[FormRow, ...]:
        self.observe(device, now)
        return tuple(self._row(command, device, now) for command in FORM_COMMANDS)

    @property
    def is_writing(self) -> bool:
        return bool(self._writing)

    @property
    def edited(self) -> dict[str, Value]:
        """The edited values by key, those that the module already has included."""
        return dict(self._edited)

    @property
    def mistyped(self) -> dict[str, str]:
        """What was typed and cannot be sent, by the setting's key."""
        return dict(self._mistyped)

    @property
    def has_drafts(self) -> bool:
        return bool(self._edited or self._mistyped)

    def would_change(self, values: Mapping[str, Value], device: DeviceView, now: float) -> bool:
        """Whether `fill` with these would leave something to write that is not edited already."""

        def is_new(key: str, value: Value) -> bool:
            if key in self._mistyped:
                return True
            edited = self._edited.get(key)
            return not is_confirmed(_BY_KEY[key], device.known(key, now), value) if edited is None else edited != value

        return any(is_new(key, value) for key, value in values.items() if key in _BY_KEY)

    def changes(self, device: DeviceView, now: float) -> tuple[SettingChange, ...]:
        """What a write would send: edits that are not known to be on the module."""
        rows = self.rows(device, now)
        return tuple(
            SettingChange(row.command, row.edited) for row in rows if row.is_pending and row.edited is not None
        )

    def count_unsent(self, device: DeviceView, now: float) -> int:
        """Edits that leaving would lose, those being written included."""
        rows = self.rows(device, now)
        return sum(row.is_pending or row.state is RowState.WRITING or bool(row.mistyped) for row in rows)

    def observe(self, device: DeviceView, now: float) -> None:
        is_in_doubt = self._is_in_doubt()
        if not self._writing and not is_in_doubt:
            self.watch.observe(device, now)
        seen = (device.restarts, device.presence_since)
        if seen != self._seen:
            # A restart or a lost link in between: what was verified before proves nothing now.
            self._seen, self._verified = seen, {}
        for key, value in list(self._verified.items()):
            known = device.known(key, now)
            if known is None or known.is_stale or known.how is not How.READ or known.value != value:
                del self._verified[key]
        settled = [
            key for key, failure in self._failures.items()
            if is_confirmed(_BY_KEY[key], device.known(key, now), failure.target)
        ]  # fmt: skip
        if not self._writing and not is_in_doubt:
            self.watch.accept(settled)  # written after all, but late
            self._drop(key for key in settled if self._edited.get(key) == self._failures[key].target)
            self._failures = {key: failure for key, failure in self._failures.items() if key not in settled}

    def _row(self, command: Command, device: DeviceView, now: float) -> FormRow:
        key = command.key
        module_value, value, is_in_doubt = device.known(key, now), self._edited.get(key), self._is_in_doubt()
        failure = self._failures.get(key)
        has_it = value is not None and is_confirmed(command, module_value, value) and not is_in_doubt
        is_pending = value is not None and not has_it and key not in self._writing
        reason = ""
        if key in self._writing:
            state = RowState.WRITING
        elif key in self._mistyped:
            state = RowState.IMPOSSIBLE
        elif is_in_doubt:  # what came of a write may be of another module
            state = RowState.EDITED if is_pending else _known_state(module_value)
        elif failure is not None:
            state, reason = RowState.FAILED, _failure_text(command, failure)
        elif key in self.watch.changed and key not in self._verified:
            state, reason = RowState.CHANGED, changed_text(self.watch.changed[key])
        elif is_pending:
            state = RowState.EDITED
        elif key in self._verified:
            state = RowState.VERIFIED
        else:
            state = _known_state(module_value)
        return FormRow(
            command=command, module_value=module_value, edited=value, state=state, reason=reason, is_pending=is_pending,
            mistyped=self._mistyped.get(key, ""),
        )  # fmt: skip

    # Writing

    def begin_write(self, changes: Iterable[SettingChange]) -> None:
        """Blocks editing until `on_written` or `abort_write`."""
        self._writing = {change.command.key: change.value for change in changes}
        for key in self._writing:
            self._failures.pop(key, None)
            self._verified.pop(key, None)

    def on_written(self, results: Iterable[Written], device: DeviceView | None = None, now: float = 0.0) -> None:
        """Takes the outcome of each change. What was refused before it was sent stays edited; of the rest, what the
        `device` holds already is no edit any more."""
        self.watch.accept(self._writing)
        self._writing = {}
        settled = []
        for written in results:
            key = written.command.key
            if written.fault is WriteFault.NOT_ALLOWED or key not in _BY_KEY:
                continue
            if written.fault is None:
                settled.append(key)
                if written.verified:
                    self._verified[key] = written.target
                    self.watch.expect(key, written.target)
            else:
                self._failures[key] = _Failure(written.target, written.fault.value, written.read_back)
        if device is not None and not self._is_in_doubt():
            settled += [
                key for key, value in self._edited.items()
                if is_confirmed(_BY_KEY[key], device.known(key, now), value)
            ]  # fmt: skip
        self._drop(settled)

    def abort_write(self, results: Iterable[Written], begun: Iterable[Command]) -> None:
        """The link was lost, or the write was cancelled: takes the outcomes that there are. What was begun without an
        outcome counts as failed; what was not begun stays edited."""
        known = list(results)
        begun_keys = {command.key for command in begun} - {written.command.key for written in known}
        self._failures |= {
            key: _Failure(value, _INTERRUPTED) for key, value in self._writing.items() if key in begun_keys
        }
        self.on_written(known)

    def reset(self, watch: SettingsWatch | None = None) -> None:
        """Discards everything, for another module."""
        self.watch = watch or SettingsWatch()
        self._edited = {}
        self._mistyped = {}
        self._writing, self._verified, self._failures = {}, {}, {}
        self._seen = None


def is_confirmed(command: Command, known: Known | None, value: Value) -> bool:
    """Whether the module has reported `value`. An acknowledgement proves nothing where it can be read back (E2)."""
    if known is None or known.is_stale or known.value != value:
        return False
    return known.how is not How.ACKNOWLEDGED or not command.reads_back


def _known_state(known: Known | None) -> RowState:
    if known is None:
        return RowState.UNKNOWN
    if known.is_stale:
        return RowState.STALE
    return RowState.ACKNOWLEDGED if known.how is How.ACKNOWLEDGED else RowState.READ


def changed_text(changed: ChangedSetting) -> str:
    before, after = value_text(changed.command, changed.before), value_text(changed.command, changed.after)
    return tr("Was {before}, now {after}; not written here.", before=before, after=after)


def _failure_text(command: Command, failure: _Failure) -> str:
    target, why = value_text(command, failure.target), tr(failure.text)
    if failure.read_back is None:
        return tr("{wanted} was sent: {why}.", wanted=target, why=why)
    read_back = value_text(command, failure.read_back)
    return tr("{wanted} was sent: {why}. It holds {stands}.", wanted=target, why=why, stands=read_back)
