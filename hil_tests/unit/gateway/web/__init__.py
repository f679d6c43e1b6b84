"""Pure parts of the page, and of its side in the services."""
