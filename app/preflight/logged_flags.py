"""Infers the state of an unreadable trigger flag (E8) from the audit log of this computer.

An earlier session enabled the trigger, logged that and ended; an active module cannot be written to again. The last
logged set counts while all of this holds, else the trigger stays unknown:

    it was acknowledged, with the value "enabled", on the same port and adapter, not for a module of another name
    boot count and all readable settings are as logged with it: the same start of the same module
    no later entry contradicts it: no other set of this trigger, no unknown outcome, no shutdown
    it is not older than `VALID_FOR_S`, and the log was not altered
"""

import logging
from collections.abc import Iterable
from dataclasses import dataclass, replace
from datetime import datetime

from app.engine.identity import IdentityEvidence as Seen
from app.engine.identity import as_logged
from app.engine.setting_changes import BOOT_COUNT, READABLE_SETTINGS
from app.preflight.evidence import Evidence, FlagState, LoggedSet, TriggerFlag
from app.preflight.verdict import VALID_FOR_S
from app.safety.acts import Act
from app.safety.journal import Outcome
from app.store.audit_chain import check_audit_chain
from app.store.database import StoreTrouble
from app.store.store import AuditEntry, Store
from protocol.frame import decode_request

_log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class _Now:
    """The module that is checked. `seen`: boot count and settings, in the form that is logged."""

    port: str
    adapter: str
    module: str | None
    seen: dict[str, object]
    at: datetime


def with_logged_flags(
    evidence: Evidence, store: Store, *, adapter: str, module: str | None, at: datetime
) -> Evidence:  # fmt: skip
    """Add the trigger states that only the log knows; never replaces what the module told this session."""
    unknown = [key for key, flag in evidence.flags.items() if _is_unknown(flag, evidence)]
    boots, settings = evidence.values.get(BOOT_COUNT.key), evidence.settings(one.key for one in READABLE_SETTINGS)
    is_read = boots is not None and len(settings) == len(READABLE_SETTINGS)
    if not unknown or not is_read or not evidence.is_complete or evidence.changes:
        return evidence
    now = _Now(evidence.port, adapter, module, as_logged(Seen(int(boots or 0), settings)), at)
    try:
        entries = store.audit()
        found = {key: logged for key in unknown if (logged := _last_set(key, entries, now)) is not None}
        if not found or check_audit_chain(store.database.read):
            return evidence
    except (StoreTrouble, ValueError, TypeError, KeyError):
        _log.warning("The audit log does not tell how the triggers stand", exc_info=True)
        return evidence
    flags = {key: TriggerFlag(FlagState.ENABLED, logged=logged) for key, logged in found.items()}
    return replace(evidence, flags=evidence.flags | flags)


def _is_unknown(flag: TriggerFlag, evidence: Evidence) -> bool:
    """Also where enabling it was not sent because the module is active."""
    return flag.state is FlagState.NEVER_SET or (flag.state is FlagState.NOT_SENT and evidence.is_active is True)


def _last_set(key: str, entries: Iterable[AuditEntry], now: _Now) -> LoggedSet | None:
    """`entries`: newest first. An entry of another port counts if it may have been this module."""
    for entry in entries:
        is_other_start = entry.detail.get("boot_count") not in (None, now.seen["boot_count"])
        if entry.outcome is Outcome.NOT_SENT or (entry.port != now.port and is_other_start):
            continue
        if entry.act is Act.WRITE and decode_request(entry.frame).command.key == key:
            return _as_enabled(entry, now)
        if entry.outcome is Outcome.UNKNOWN or entry.act is Act.SHUTDOWN:
            return None
    return None


def _as_enabled(entry: AuditEntry, now: _Now) -> LoggedSet | None:
    request = decode_request(entry.frame)
    is_enabled = request.command.write is not None and request.command.write.decode(request.data) is True
    is_acknowledged = entry.outcome is Outcome.CONFIRMED and entry.result.get("acknowledged") is True
    is_here = entry.port == now.port and entry.detail.get("adapter", "") == now.adapter
    name = entry.detail.get("module")
    is_other_name = None not in (name, now.module) and name != now.module
    is_same_start = all(entry.detail.get(part) == value for part, value in now.seen.items())
    age_s = (now.at - datetime.fromisoformat(entry.at)).total_seconds()
    is_recent = 0.0 <= age_s <= VALID_FOR_S
    is_known = is_enabled and is_acknowledged and is_here and not is_other_name and is_same_start and is_recent
    return LoggedSet(entry.id, age_s) if is_known else None
