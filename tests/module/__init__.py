"""An independent DPS-S module, with a codec of its own: it imports nothing of the product, and its log is the judge."""
