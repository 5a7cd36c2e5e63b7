"""The decoded trigger history."""
