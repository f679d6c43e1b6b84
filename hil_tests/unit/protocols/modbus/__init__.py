"""Modbus TCP, pure: framing, validation, answers."""
