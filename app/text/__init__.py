"""What people read: translation, messages with their arguments, durations, CSV cells."""
