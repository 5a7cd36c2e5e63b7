"""The window: PySide6 widgets over the layers ``app`` and ``protocol``."""
