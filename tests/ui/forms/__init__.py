"""Tests of ui/forms/."""
