"""Every threshold and flag: read, edit, write, verify."""
