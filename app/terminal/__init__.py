"""What the commands share: arguments, output, exit codes, interruption, the connection."""
