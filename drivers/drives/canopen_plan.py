"""Which identifiers a bus carries and who sends them; two senders of one identifier are a fault before anything runs.

Source: CiA 301, 7.3.5 (predefined connection set); rho3 2.2 (SERVODYN: 100, 200+10n, 600+10n); can.md 0.2 (both on one bus).
"""

from collections.abc import Iterable
from typing import NamedTuple

from drivers.drives.cia402_boot import CONTROLWORD, Pdo, map_faults
from protocols.canopen import cob_id as cobid
from protocols.canopen.dictionary import ObjectDictionary
from protocols.canopen.pdo import RPDO_COMMUNICATION, RPDO_MAPPING, mapped


class Used(NamedTuple):
    """One identifier on a bus."""

    identifier: int
    who: str


def gateway_identifiers(gateway: int) -> list[Used]:
    """Frames that the master of a CANopen bus sends."""
    return [Used(cobid.NMT, "NMT"), Used(cobid.SYNC, "SYNC of CANopen"), Used(cobid.heartbeat(gateway), "the gateway's heartbeat")]


def node_identifiers(node: int, who: str, pdos: Iterable[Pdo]) -> list[Used]:
    """Identifiers of one node: services of the predefined connection set and its PDOs."""
    services = (
        (cobid.emcy(node), "EMCY"), (cobid.sdo_answer(node), "SDO answer"),
        (cobid.sdo_request(node), "SDO request"), (cobid.heartbeat(node), "heartbeat"),
    )  # fmt: skip
    return [Used(number, f"{what} of {who}") for number, what in services] + [Used(pdo.identifier, f"{pdo} of {who}") for pdo in pdos]


def io_pdos(node: int) -> tuple[Pdo, ...]:
    """Default PDOs of a CiA 401 coupler."""
    return (Pdo(True, 1, cobid.rpdo(1, node), 255, ()), Pdo(False, 1, cobid.tpdo(1, node), 255, ()))


def collisions(used: Iterable[Used]) -> list[str]:
    """One sentence for each identifier that has two senders or meanings."""
    seen: dict[int, list[str]] = {}
    for identifier, who in used:
        names = seen.setdefault(identifier, [])
        if who not in names:
            names.append(who)
    return [f"{number} ({number:X}h) is {' and '.join(names)}" for number, names in sorted(seen.items()) if len(names) > 1]


def restricted(used: Iterable[Used]) -> list[str]:
    """PDOs on identifiers that CANopen reserves."""
    return [f"{number:X}h is {who}: restricted in CANopen" for number, who in used if "PDO" in who and cobid.restricted(number)]


def dictionary_map_faults(dictionary: ObjectDictionary, node: int) -> list[str]:
    """RPDO maps that a DCF sets in the device: 6040h in two of them switches the drive off (can.md, p402)."""
    pdos = []
    for number in range(1, 513):
        words = []
        for entry in dictionary.subs(RPDO_MAPPING + number - 1):
            value = entry.parameter_of(node)
            if entry.sub and isinstance(value, int) and value:
                words.append(mapped(value))
        identifier = dictionary.entry(RPDO_COMMUNICATION + number - 1, 1)
        value = identifier.parameter_of(node) if identifier is not None else None
        valid = not (isinstance(value, int) and value & cobid.INVALID)
        if words and valid and any(word.index == CONTROLWORD.index for word in words):
            pdos.append(Pdo(True, number, 0, 0, tuple(words)))
    return map_faults(pdos)
