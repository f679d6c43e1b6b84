"""Cross checks of [northbound]: data that leave this computer are encrypted, unless the file allows plain text explicitly (AX-427)."""

import pathlib

from gateway.checks.context import Context
from gateway.pure.cell.northbound import LOOPBACK, place_of


def reachable(context: Context) -> None:
    """Binds and brokers beyond loopback; files that are not there."""
    north = context.cell.northbound
    if north is None:
        return
    for key, bind in (
        ("mqtt.broker", north.mqtt.broker if north.mqtt else ""),
        ("opcua.bind", north.opcua.bind if north.opcua else ""),
        ("metrics.bind", north.metrics.bind if north.metrics else ""),
    ):
        if bind and not 1 <= place_of(bind)[1] <= 65535:
            context.fault(f"northbound.{key}", bind, range_="port 1..65535")
        elif bind and place_of(bind)[0] not in LOOPBACK and not _allowed(context, key):
            hint = {
                "mqtt.broker": "a broker on another computer is reached by TLS: set tls_ca",
                "opcua.bind": "OPC UA is served unencrypted, so on loopback only",
                "metrics.bind": "reached from other computers, unencrypted: write open = true to permit this",
            }[key]
            context.fault(f"northbound.{key}", bind, hint)
    for key, name in (("password_file", north.mqtt.password_file), ("tls_ca", north.mqtt.tls_ca)) if north.mqtt else ():
        if name and not (pathlib.Path(context.cell.file).parent / name).is_file():
            context.fault(f"northbound.mqtt.{key}", name, "no such file (looked for in the folder of the cell file)")
    if not (north.mqtt or north.opcua or north.metrics or north.journald):
        context.fault("northbound", "", "contains nothing: add mqtt, opcua, metrics or journald")


def _allowed(context: Context, key: str) -> bool:
    north = context.cell.northbound
    assert north is not None
    if key == "mqtt.broker":
        return bool(north.mqtt and north.mqtt.tls_ca)
    return key == "metrics.bind" and bool(north.metrics and north.metrics.open)


CHECKS = (reachable,)
