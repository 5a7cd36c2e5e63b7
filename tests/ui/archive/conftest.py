"""What needs a PostgreSQL server is collected only where one is installed; .ci/run says where none is."""

from tests.support.archive_server import server_programs

collect_ignore = [] if server_programs() is not None else ["test_archive_server.py"]
