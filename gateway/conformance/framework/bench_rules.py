"""Dependencies and exclusions among keys of a bench file: a key without effect is refused."""

import difflib
import pathlib
import re
from collections.abc import Iterable, Mapping
from typing import cast

from protocols.p3964r.profiles import PROFILES

Table = Mapping[str, object]
CHOICES: Mapping[str, tuple[str, ...]] = {"profile": tuple(PROFILES), "priority": ("high", "low")}  # values of keys of the PICS
RANGES: Mapping[str, tuple[int, int]] = {  # integers of the PICS
    "node": (1, 127),
    "module": (1, 6),
    "most_registers": (1, 125),
    "most_bits": (1, 2000),
    "most_received": (1, 65535),
    "words": (1, 256),
}
ERRORS = (  # permitted names of own error numbers in the PICS: cases of the suite rk512
    *("missing_block", "missing_block_send", "behind_the_end", "wrong_command", "wrong_type", "wrong_byte_1", "follow_on_alone"),
    *("short_header", "data_behind_fetch", "amount_0", "send_too_short", "send_too_long", "send_odd", "send_no_data", "type"),
)
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


def near(name: str, names: Iterable[str]) -> str:
    found = difflib.get_close_matches(name, list(names), n=1, cutoff=0.5)
    return f"; did you mean {found[0]}?" if found else ""


def wanted_in_pics(key: str, kind: str, value: object) -> str:
    """The form expected for an item instead of this value; empty: any."""
    if kind == "bool":
        return "" if isinstance(value, bool) else "true or false"
    if kind == "whole":
        least, most = RANGES[key]
        good = isinstance(value, int) and not isinstance(value, bool) and least <= value <= most
        return "" if good else f"a whole number {least} to {most}"
    if kind == "text":
        wanted = f"one of {', '.join(CHOICES[key])}" if key in CHOICES else "a text"
        return "" if isinstance(value, str) and value in CHOICES.get(key, (value,)) else wanted
    return 'a table of error numbers such as { missing_block = "2A" }'


def error_faults(table: Mapping[str, object]) -> list[str]:
    """Check the table of own error numbers: an unknown name would have no effect."""
    faults = []
    for name, value in table.items():
        if name not in ERRORS:
            faults.append(f"pics.errors.{name}: no such error; there are {', '.join(ERRORS)}{near(name, ERRORS)}")
        elif not isinstance(value, str) or re.fullmatch(r"[0-9A-Fa-f]{1,2}", value) is None:
            faults.append(f'pics.errors.{name}: an error number in hexadecimal such as "2A" expected, found {value!r}')
    return faults


def missing_files(folder: pathlib.Path, found: Table) -> list[str]:
    """Missing files of [link]; the suite judges the content of readable ones."""
    link = found.get("link")
    named = {key: link.get(key) for key in ("eds", "layout")} if isinstance(link, dict) else {}
    paths = {key: (folder / name).resolve() for key, name in named.items() if isinstance(name, str) and name}
    return [f"link.{key}: {path} does not exist; the path begins at the bench file" for key, path in paths.items() if not path.is_file()]


def rule_faults(found: Table) -> list[str]:
    """Rules beyond single keys; a wrong value is not used for further conclusions."""
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
        f'stimulus.{key}: does not act with kind = "{kind}", only {", ".join(sorted(acting)) or "no key"}; remove it'
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
