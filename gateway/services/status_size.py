"""The services' status as it fits its region: cut JSON would leave every reader with nothing."""

import json


def fitted(status: dict[str, object], size: int) -> bytes:
    """As JSON for a region of this size; where it is too long, what is said of each Modbus device is left out and named."""
    left: list[str] = []
    found = json.dumps(status).encode()
    for part in ("modbus_clients", "modbus_couplers"):
        if len(found) > size and part in status:
            left.append(part)
            status = {name: value for name, value in status.items() if name != part} | {"too_long": left}
            found = json.dumps(status).encode()
    return found.ljust(size)[:size]
