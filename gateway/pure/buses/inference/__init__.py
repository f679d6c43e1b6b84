"""Infers the layout of a drive bus from a recording: fields, their meaning, the confidence.  Pure."""
