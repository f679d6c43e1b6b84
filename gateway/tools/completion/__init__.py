"""Completion for shells, made of the commands' own parsers."""
