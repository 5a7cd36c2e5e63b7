"""Long runs in virtual time against independent modules: exchanges at every moment, and lines of every kind."""
