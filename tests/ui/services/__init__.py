"""Tests of ui/services/."""
