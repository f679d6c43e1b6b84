"""[stimulus] kind = "modbus": a coil or register of some Modbus TCP server makes the device send."""

import socket
import struct
from collections.abc import Mapping
from typing import cast

from drivers.ports.open import tcp_address
from gateway.pure.conformance.verdict import Inconclusive

LIMIT_S = 3.0


def press(table: Mapping[str, object]) -> None:
    """Writes once; INCONC where the server does not take it."""
    unit, value = cast(int, table.get("unit", 1)), cast(int, table.get("value", 1))
    if "coil" in table:
        pdu = struct.pack(">BHH", 5, cast(int, table["coil"]), 0xFF00 if value else 0)
    else:
        pdu = struct.pack(">BHH", 6, cast(int, table.get("holding", 0)), value)
    try:
        host, port = tcp_address(str(table.get("url", "")))
        with socket.create_connection((host, port), LIMIT_S) as connection:
            connection.sendall(struct.pack(">HHHB", 1, 0, len(pdu) + 1, unit) + pdu)
            got = connection.recv(260)
    except (OSError, ValueError) as error:
        raise Inconclusive(f"the stimulus over Modbus: {error}", "the write is answered", str(error)) from error
    if got[7:] != pdu:
        raise Inconclusive("the stimulus over Modbus was refused", pdu.hex(" ").upper(), got.hex(" ").upper() or "nothing")
