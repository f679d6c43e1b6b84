"""The cycle process itself on a bus."""
