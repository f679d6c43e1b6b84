"""The services' status as it fits its region: cut JSON would leave every reader with nothing."""

import json


def fitted(status: dict[str, object], size: int) -> bytes:
    """The status as JSON for a region of this size; if it is too long, the details of each Modbus device are left out and named."""
    left: list[str] = []
    found = json.dumps(status).encode()
    for part in ("modbus_clients", "modbus_couplers"):
        if len(found) > size and part in status:
            left.append(part)
            status = {name: value for name, value in status.items() if name != part} | {"too_long": left}
            found = json.dumps(status).encode()
    return found.ljust(size)[:size]
