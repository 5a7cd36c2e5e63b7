"""The module's trigger records: read, merged, kept, judged, exported."""
