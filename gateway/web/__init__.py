"""The page: a process of its own that reads the shared regions and acts through the services' command source 91 (AX-470)."""
