"""The recorded sessions."""
