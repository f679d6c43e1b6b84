"""Numbers of the rho 3 system errors at its interface: groups 14 and 15 of the coded errors.  Source: L3007-3017, L7485-7500 (9.1)."""

SYSTEM_BASE = 3583  # coded error = base + system error number
MOST_SYSTEM = 4095 - SYSTEM_BASE


def system_code(number: int) -> int:
    """Code at the interface of system error `number`: 133 is 3716.  ValueError outside 1..512."""
    if not 1 <= number <= MOST_SYSTEM:
        raise ValueError(f"system error {number}: 1..{MOST_SYSTEM} have a code")
    return SYSTEM_BASE + number


def system_number(code: int) -> int:
    """The reverse of system_code; ValueError for a code that is none of a system error."""
    if not 1 <= code - SYSTEM_BASE <= MOST_SYSTEM:
        raise ValueError(f"code {code}: system errors are {SYSTEM_BASE + 1}..4095")
    return code - SYSTEM_BASE
