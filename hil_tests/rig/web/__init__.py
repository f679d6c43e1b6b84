"""The page of a really running cell, seen through a real browser."""
