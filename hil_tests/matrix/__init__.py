"""Which demand of the manuals is proved by which test, and whether that test would notice its function breaking."""
