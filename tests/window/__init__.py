"""Tests of ui/, in its rooms."""
