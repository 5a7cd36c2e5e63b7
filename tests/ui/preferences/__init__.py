"""Tests of ui/preferences."""
