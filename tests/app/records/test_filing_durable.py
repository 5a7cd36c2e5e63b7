"""A check that was reported as stored survives a kill at any moment."""

import subprocess
import sys
from pathlib import Path

import pytest

from app.records.check_store import CheckStore
from app.records.verification import Chain, RecordState, verify
from app.store.database import open_database
from tests.support.processes import ENVIRONMENT, ROOT

_WRITER = """
import sys
from datetime import UTC, datetime
from pathlib import Path
from app.records.record import RecordContext, make_record
from app.records.check_store import CheckStore
from app.store.database import open_database
from tests.support.records.preflight_rig import check
from tests.app.trigger_records.test_trigger_history import raw

database = open_database(Path(sys.argv[1])).database
store = CheckStore(database)
module = database.write("INSERT INTO modules (name, adapter, first_seen_at, last_seen_at) VALUES ('M', '', '', '')")
checked, number, life = check(), 0, []

def make(number, previous):
    about = RecordContext(at=datetime.now(UTC), program_version="1", module="M", number=number, previous=previous)
    return make_record(checked.assessment, about, checked.log)

while True:
    number += 1
    life.append(raw(number, 7))
    store.store_visit(module, life[-9:], port="p", boot_count=number % 256, is_confirmed=True)
    print(number, store.append_check(make, module)["hash"], flush=True)
"""


@pytest.mark.parametrize("after", [1, 3, 8])
def test_kill_loses_nothing_that_was_acknowledged(tmp_path: Path, after: int) -> None:
    with subprocess.Popen(
        [sys.executable, "-c", _WRITER, str(tmp_path)], cwd=ROOT, env=ENVIRONMENT, stdout=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None
        said = [process.stdout.readline() for _ in range(after)]
        process.kill()
        said += process.stdout.readlines()
    acknowledged = [line.split() for line in said if line.endswith("\n")]
    assert len(acknowledged) >= after
    opened = open_database(tmp_path)
    assert opened.set_aside is None
    store = CheckStore(opened.database)
    for number, hash_ in acknowledged:
        record = store.record(hash_)
        assert record is not None
        verification = verify(record, store)
        assert verification.state is RecordState.NOT_SIGNED
        assert verification.chain is (Chain.FIRST if number == "1" else Chain.LINKED)
    # An interrupted visit may be half written; the next one repairs it.
    life = [one.raw for one in store.records(1)]
    assert len(life) >= len(acknowledged)
    store.store_visit(1, life[-9:], port="p", boot_count=len(life) % 256, is_confirmed=True)
    assert [one.raw for one in store.records(1)] == life
    opened.database.close()
