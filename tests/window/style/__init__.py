"""Tests of ui/style/."""
