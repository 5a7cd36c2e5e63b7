"""Tests of LOCK above everything that is open."""
