"""Files a pre-flight check without blocking the GUI thread."""

from collections.abc import Callable
from functools import partial

from app import version
from app.engine.target import Target
from app.limits.expectations import Expectations, Past
from app.preflight.evidence import Evidence, FrameLog
from app.records.filing import Filed, Person, file_check
from app.store.database import StoreTrouble
from app.store.store import Store
from ui.core.background_task import BackgroundTask


def file_in_background(
    task: BackgroundTask[Filed],
    evidence: Evidence,
    expectations: Expectations,
    person: Person,
    log: FrameLog,
    *,
    is_stored: bool,
    store: Store | StoreTrouble,
    target: Target | None,
    then: Callable[[Filed], object],
    past: Past | None = None,
) -> None:
    """Call `then` with the judged check: stored in the store's thread, or at once where it is not to be stored."""
    used_store = store if is_stored and isinstance(store, Store) else None
    adapter = "" if target is None else target.identity
    work = partial(
        file_check, evidence, expectations, person, log,
        store=used_store, program_version=version(), adapter=adapter, past=past,
    )  # fmt: skip
    if used_store is None:
        task.cancel()
        then(work())
    else:
        task.run_in(used_store.queue, work, then)
