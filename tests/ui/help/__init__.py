"""Tests of ui/help/."""
