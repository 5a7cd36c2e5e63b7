"""What needs a PostgreSQL server is collected only where one is installed; the summary says where none is."""

from tests.support.records.archive_server import left_out

collect_ignore = left_out("tests/ui/archive")
