"""For tests of the parts in C (AX-320): all of them as they were built, and values at which integers change their size."""

from hypothesis import strategies as st

from gateway.cycle.native.quick import NativeParts

ENDS = [0, 1, -1, 8191, 8192, 8193, 32768, 32769, 2**31 - 1, 2**31, -(2**31), -(2**31) - 1]
FLAG = st.booleans()


def native_parts() -> NativeParts:
    """None is missing: where it is, its twin would be compared with itself."""
    found = NativeParts(python=False)
    assert not found.missing
    return found
