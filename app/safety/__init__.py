"""What may be done: acts, permits, interlocks, consequences of values, the deploy ritual, the audit log."""
