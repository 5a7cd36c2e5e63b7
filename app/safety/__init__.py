"""What may be done: acts, permits, interlocks, the deploy ritual, the audit log."""
