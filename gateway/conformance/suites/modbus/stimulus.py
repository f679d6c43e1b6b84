"""[stimulus] kind = "modbus" or "output": a coil or register of some Modbus TCP server makes the device send."""

from collections.abc import Mapping

from gateway.conformance.framework.power import write_once


def press(table: Mapping[str, object]) -> None:
    """Write once; INCONC if the server refuses it."""
    chosen = table if "coil" in table or "holding" in table else {**table, "holding": 0}
    write_once(str(table.get("url", "")), chosen, "the stimulus over Modbus")
