"""What keys of a bench file need or exclude each other: a key that could not act is refused."""

from collections.abc import Mapping
from typing import cast

from protocols.p3964r.profiles import PROFILES

Table = Mapping[str, object]
CHOICES: Mapping[str, tuple[str, ...]] = {"profile": tuple(PROFILES), "priority": ("high", "low")}  # values of keys of the PICS
POWER = ("on", "off", "command", "relay", "prompt")
MODBUS = frozenset(("url", "unit", "coil", "holding", "value"))
NEEDED = {  # kind of [stimulus] -> keys that act with it
    "operator": frozenset(("prompt", "timeout_ms")),
    "periodic": frozenset(("period_ms", "timeout_ms")),
    "fetch": frozenset(("timeout_ms",)),
    "modbus": MODBUS | {"timeout_ms"},
    "output": MODBUS | {"command", "timeout_ms"},
    "command": frozenset(("command", "timeout_ms")),
    "none": frozenset[str](),
}


def rule_faults(found: Table) -> list[str]:
    """Beside those of single keys: of a value that is wrong nothing is concluded."""
    return [*_port(_table(found, "port")), *_stimulus(_table(found, "stimulus")), *_power(found)]


def _table(found: Table, name: str) -> Table:
    return cast(Table, found.get(name, {}))


def _port(port: Table) -> list[str]:
    if "marks" in port and not str(port.get("url", "pty:")).startswith(("pty:", "line:")):
        return ['port.marks: acts at a pty only (url = "pty:/path"); a serial interface marks by itself; remove it']
    return []


def _stimulus(table: Table) -> list[str]:
    kind = table.get("kind")
    if kind is None:
        return ["stimulus.kind: is missing; one of operator, periodic, fetch, modbus, output, command, none expected"] if table else []
    acting = NEEDED.get(str(kind))
    if acting is None:
        return []
    faults = [
        f'stimulus.{key}: does not act with kind = "{kind}"; {", ".join(sorted(acting)) or "no key"} does; remove it'
        for key in table
        if key != "kind" and key not in acting
    ]
    if kind == "command" and "command" not in table:
        faults.append('stimulus.command: is missing; such as command = ["python3", "send.py"]')
    if kind == "modbus" and "url" not in table:
        faults.append('stimulus.url: is missing; such as url = "tcp://10.0.0.5:502" with coil = 3')
    if kind == "output" and not {"command", "url"} & set(table):
        faults.append('stimulus.command: is missing; kind = "output" needs a command, or url and coil of a Modbus TCP output')
    if "coil" in table and "holding" in table:
        faults.append("stimulus.holding: there is a coil as well; only one is expected")
    return faults


def _power(found: Table) -> list[str]:
    table = _table(found, "power")
    if not table:
        return []
    kinds = [key for key in POWER if key in table]
    faults = []
    if not kinds:
        faults.append("power: on and off, command, relay or prompt expected: nothing switches the supply")
    elif kinds != ["on", "off"] and len(kinds) > 1:
        faults.append(f"power: {', '.join(kinds)}: one way to switch the supply expected (on and off, command, relay or prompt)")
    elif kinds in (["on"], ["off"]):
        faults.append(f"power.{'off' if kinds == ['on'] else 'on'}: is missing; on and off belong together")
    faults += [
        f"power.{key}: acts with relay only; remove it" for key in ("coil", "unit", "inverted") if key in table and "relay" not in table
    ]
    if "limit_ms" in table and "relay" in table:
        faults.append("power.limit_ms: acts with a command or a prompt only; remove it")
    if str(_table(found, "port").get("url", "")).startswith(("machine:", "sim")):
        faults.append("power: a machine in virtual time is switched by its own power(on, now); remove [power]")
    return faults
