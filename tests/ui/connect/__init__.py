"""Tests of ui/connect/."""
