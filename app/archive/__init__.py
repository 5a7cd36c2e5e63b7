"""The records of all stations as signed facts that are only ever added, exchanged through a server or a file."""
