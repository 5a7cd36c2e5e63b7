"""For Windows: the installer, and building and testing under Wine."""
