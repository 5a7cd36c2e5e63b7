"""Tests of ui/archive/."""
