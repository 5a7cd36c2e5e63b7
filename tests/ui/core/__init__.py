"""Tests of ui/core/."""
