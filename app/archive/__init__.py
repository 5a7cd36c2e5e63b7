"""The facts of all stations, exchanged through a server or a file; reports and histories of modules."""
