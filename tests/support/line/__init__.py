"""Lines, links and reference decoders for tests."""
