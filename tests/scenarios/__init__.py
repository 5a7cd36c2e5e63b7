"""Whole conversations: stateful, random, hostile."""
