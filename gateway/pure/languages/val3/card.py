"""The folder usr/configs of a flash card: sio.cfx, cell.cfx, arm.cfx, process data of field-bus boards.

Source: files of controllers s7.9 .. s8.20 (S8 note N01): `<String name="parity" value="none" />` and its like with Uint, Int, Float, Bool,
Inet, arrays of values with `index`.  A missing key has the controller's default; unknown keys and values are reported, never guessed.
"""

import math
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field

from gateway.pure.languages.val3.xmltree import Element, XmlFault, parse_xml

LAST_TAG = re.compile(rb"<(\w+)>\s*\Z")  # some cards end with <sio> in place of </sio>
PARITIES, FLOWS = ("none", "even", "odd"), ("none", "hardware")
UNLIMITED = 9_999.0  # a joint of +-99999 has no limit of its own
PORT = ("portNumber", "port", "portNo", "localPort")
LONGEST = 16 << 20


@dataclass(frozen=True, slots=True)
class CardChannel:
    """A row of sio.cfx, in the terms of [[val3.channel]]."""

    name: str
    kind: str
    description: str = ""
    address: str = "0.0.0.0"
    port: int = 0
    clients: int = 1
    end_of_string: int = 13
    timeout_s: float = 0.0
    nagle: bool = True
    with_port: bool = False  # sio.cfx has one, whether it is right or not
    baud_rate: int = 9600
    bits: int = 8
    parity: str = "none"
    stop_bits: int = 1
    flow_control: str = "none"


@dataclass(frozen=True, slots=True)
class CardSignal:
    """A named input or output of a field-bus board."""

    name: str
    board: str
    module: str
    output: bool
    analog: bool


@dataclass(slots=True)
class Card:
    """One card; `doubts`: what was not understood, a sentence each."""

    channels: list[CardChannel] = field(default_factory=list)
    signals: list[CardSignal] = field(default_factory=list)
    settings: dict[str, str] = field(default_factory=dict)  # of cell.cfx and controller.cfx
    start: str = ""  # application of autoStart
    arm: str = ""
    lower: dict[int, float] = field(default_factory=dict)  # axis from 0 -> lowest position
    upper: dict[int, float] = field(default_factory=dict)
    doubts: list[str] = field(default_factory=list)


def card_of(files: Mapping[str, bytes]) -> Card:
    """All files of usr/configs by their name; those of other kinds are left alone."""
    card = Card()
    for name, data in sorted(files.items()):
        base = name.rpartition("/")[2].lower()
        if not base.endswith((".cfx", ".xml")):
            continue
        root = _root(card, name, data)
        if root is None:
            continue
        if root.tag == "ProcessData":
            card.signals += _signals(root)
        elif base == "sio.cfx":
            card.channels += _channels(card, root)
        elif base in ("cell.cfx", "controller.cfx", "arm.cfx"):
            _settings(card, base, root)
    return card


def _root(card: Card, name: str, data: bytes) -> Element | None:
    if len(data) > LONGEST:
        card.doubts.append(f"{name}: {len(data)} bytes, {LONGEST} at most are read")
        return None
    try:
        root = parse_xml(data)
        card.doubts += [f"{name} line {line}: {doubt}" for line, doubt in root.doubts]
        return root
    except XmlFault as fault:
        unclosed = LAST_TAG.search(data)
        if unclosed is not None:
            try:
                root = parse_xml(data[: unclosed.start()] + b"</" + unclosed.group(1) + b">")
            except XmlFault:
                pass
            else:
                card.doubts.append(f"{name} line {fault.line}: <{unclosed.group(1).decode()}> was read as </{root.tag}>")
                return root
        card.doubts.append(f"{name} line {fault.line}: {fault.text}; the file is left out")
        return None


# ---- sio.cfx --------------------------------------------------------------------------------------------------------------------


def _channels(card: Card, root: Element) -> list[CardChannel]:
    made = list[CardChannel]()
    for row in root.children:
        tag, values = row.tag.lower(), {each.get("name").lower(): each.get("value") for each in row.children}
        name = values.get("name", "")
        if not name:
            card.doubts.append(f"sio.cfx line {row.line}: <{row.tag}> has no name and is left out")
            continue
        if "serial" in tag:
            made.append(_serial(card, row, values))
        elif "socket" in tag or "udp" in tag or "tcp" in tag:
            made.append(_socket(card, row, values))
        else:
            card.doubts.append(f"sio.cfx line {row.line}: <{row.tag}> is neither a serial line nor a socket; {name} is left out")
            continue
        if (twin := next((each for each in made[:-1] if each.name == made[-1].name), None)) is not None:  # their case counts
            made.pop()
            card.doubts.append(f"sio.cfx line {row.line}: {name} has the name of {twin.name} above and is left out")
    return made


def _serial(card: Card, row: Element, values: Mapping[str, str]) -> CardChannel:
    where = f"sio.cfx line {row.line}, {values['name']}"
    return CardChannel(
        f"Serial\\{values['name']}",
        "serial",
        values.get("desc", ""),
        end_of_string=_end(card, where, values),
        timeout_s=_timeout(card, where, values),
        baud_rate=_whole(card, where, values, ("baudRate",), 9600, 50, 4_000_000),
        bits=_whole(card, where, values, ("byteSize", "bits"), 8, 5, 8),
        parity=_word(card, where, values, ("parity",), PARITIES),
        stop_bits=_whole(card, where, values, ("nbStopBit", "stopBits"), 1, 1, 2),
        flow_control=_word(card, where, values, ("flowControl",), FLOWS),
    )


def _socket(card: Card, row: Element, values: Mapping[str, str]) -> CardChannel:
    tag, where = row.tag.lower(), f"sio.cfx line {row.line}, {values['name']}"
    kind = "udp" if "udp" in tag else "server" if "srv" in tag or "server" in tag else "client"
    address = next((each.get("value") for each in row.children if each.tag == "Inet"), "0.0.0.0") or "0.0.0.0"
    if kind == "udp" and values.get("broadcast", "").lower() == "true" and not address.endswith(".255.255"):
        address = ".".join([*address.split(".")[:2], "255", "255"])
    return CardChannel(
        f"{'UdpSocket' if kind == 'udp' else 'Socket'}\\{values['name']}",
        kind,
        values.get("desc", ""),
        address,
        _whole(card, where, values, PORT, 0, 1, 65535),
        _whole(card, where, values, ("nbClients", "maxClients", "clients", "nbClient", "maxConnections"), 1, 1, 64),
        _end(card, where, values),
        _timeout(card, where, values),
        values.get("nagle", "true").lower() != "false",
        with_port=any(each.lower() in values for each in PORT),
    )


def _end(card: Card, where: str, values: Mapping[str, str]) -> int:
    return _whole(card, where, values, ("endOfString",), 13, 0, 255)


def _timeout(card: Card, where: str, values: Mapping[str, str]) -> float:
    """Below 0: it does not wait (-0.001 as well as -1)."""
    value = _number(values.get("timeout", "0"))
    if value is None:
        card.doubts.append(f"{where}: timeOut {values['timeout']!r} is not a number; 0 is used")
        return 0.0
    return -1.0 if value < 0 else min(value, 1e6)


def _whole(card: Card, where: str, values: Mapping[str, str], names: Iterable[str], default: int, low: int, high: int) -> int:
    name = next((each for each in names if each.lower() in values), None)
    if name is None:
        return default
    text = values[name.lower()]
    value = _number(text)
    if value is None or value != int(value) or not low <= value <= high:
        card.doubts.append(f"{where}: {name} {text!r} is not a whole number {low}..{high}; {default} is used")
        return default
    return int(value)


def _word(card: Card, where: str, values: Mapping[str, str], names: Iterable[str], known: tuple[str, ...]) -> str:
    text = next((values[each.lower()] for each in names if each.lower() in values), known[0])
    if text.lower() in known:
        return text.lower()
    card.doubts.append(f"{where}: {text!r} is not one of {', '.join(known)}; {known[0]} is used")
    return known[0]


def _number(text: str) -> float | None:
    try:
        value = float(text)
    except ValueError:
        return None
    return value if math.isfinite(value) else None


# ---- cell.cfx, controller.cfx, arm.cfx ------------------------------------------------------------------------------------------


def _settings(card: Card, base: str, root: Element) -> None:
    for each in root.children:
        name = each.get("name")
        if each.tag == "autoStart":
            card.start = name
        elif each.tag == "FloatArray" and name.lower() in ("mincelljointpos", "minarmjointpos"):
            _limits(card.lower, each, max)
        elif each.tag == "FloatArray" and name.lower() in ("maxcelljointpos", "maxarmjointpos"):
            _limits(card.upper, each, min)
        elif each.tag.lower() in ("useriosresfresh", "useriosrefresh", "useriorefresh", "userioresfresh"):
            card.settings.update({f"{each.tag}.{key}": value for key, value in each.attributes.items()})
            card.settings.update({f"{each.tag}.{one.get('name')}": one.get("value") for one in each.children if one.get("name")})
        elif name and each.get("value") and base != "arm.cfx":
            card.settings[name] = each.get("value")
        elif base == "arm.cfx" and name == "arm":
            card.arm = each.get("value")


def _limits(found: dict[int, float], array: Element, narrower: Callable[[float, float], float]) -> None:
    for each in array.children:
        index, value = each.get("index"), _number(each.get("value"))
        if index.isdecimal() and value is not None and abs(value) < UNLIMITED:
            found[int(index)] = narrower(found[int(index)], value) if int(index) in found else value


# ---- process data of field-bus boards -------------------------------------------------------------------------------------------


def _signals(root: Element) -> list[CardSignal]:
    made = []
    for adapter in root.all("Adapter"):
        for module in adapter.all("Module"):
            for signal in module.all("Signal"):
                output = signal.get("signalType").lower() == "input"  # input of the master: output of the controller
                analog = signal.get("dataType").lower() != "bit"
                made.append(CardSignal(signal.get("displayName"), adapter.get("displayName"), module.get("displayName"), output, analog))
    return [each for each in made if each.name]
