"""Modbus TCP over real sockets."""
