"""Base classes for mistakes of our callers; the partner's mistakes are events, never these."""


class ProtocolError(Exception):
    """Base of every exception a protocol package raises."""


class DecodeError(ProtocolError):
    """Bytes that do not fit the layout; the message holds the offending bytes."""


class EncodeError(ProtocolError):
    """Values that do not fit the layout; the message holds name, value, range and unit."""
