"""Identifiers and their meaning.  Source: CiA 301 (4.2), 7.3.5 predefined connection set and restricted CAN-IDs; CiA 305 for LSS."""

NMT, SYNC, TIME = 0x000, 0x080, 0x100
LSS_MASTER, LSS_SLAVE = 0x7E5, 0x7E4  # requests of the LSS master, answers of the slaves
MAX_NODE = 127

# Bits of a COB-ID entry of the object dictionary (32 bits)
INVALID = 1 << 31  # PDO, SDO, EMCY: does not exist
NO_RTR = 1 << 30  # TPDO: a remote frame must not request it
PRODUCER = 1 << 30  # 1005h: this device makes SYNC
EXTENDED = 1 << 29  # 29-bit identifier
ID_BITS = 0x7FF

REMOTE = 1 << 30  # mark on Frame.identifier of a remote frame, as in struct can_frame; ports that pass remote frames set it

RESTRICTED = ((0x000, 0x07F), (0x101, 0x180), (0x581, 0x5FF), (0x601, 0x67F), (0x6E0, 0x6FF), (0x701, 0x77F), (0x780, 0x7FF))


def emcy(node: int) -> int:
    return 0x080 + node


def tpdo(number: int, node: int) -> int:
    """Default of TPDO 1..4 of a node."""
    return 0x080 + 0x100 * number + node


def rpdo(number: int, node: int) -> int:
    """Default of RPDO 1..4 of a node."""
    return 0x100 + 0x100 * number + node


def sdo_answer(node: int) -> int:
    """Server to client."""
    return 0x580 + node


def sdo_request(node: int) -> int:
    """Client to server."""
    return 0x600 + node


def heartbeat(node: int) -> int:
    """Heartbeat, boot-up and node guarding."""
    return 0x700 + node


def restricted(identifier: int) -> bool:
    """True where no PDO, SYNC or EMCY may be put."""
    return any(low <= identifier <= high for low, high in RESTRICTED)


def describe(identifier: int) -> str:
    """Meaning of an identifier in the predefined connection set, for logs: "TPDO2 of node 5"."""
    fixed = {NMT: "NMT", SYNC: "SYNC", TIME: "TIME", LSS_MASTER: "LSS master", LSS_SLAVE: "LSS slave"}
    if identifier in fixed:
        return fixed[identifier]
    function, node = identifier & 0x780, identifier & 0x7F
    names = {0x080: "EMCY", 0x580: "SDO answer", 0x600: "SDO request", 0x700: "heartbeat"}
    if node and function in names:
        return f"{names[function]} of node {node}"
    if node and 0x180 <= function <= 0x500:
        number = (function - 0x080) // 0x100
        return f"{'TPDO' if function & 0x80 else 'RPDO'}{number} of node {node}"
    return f"{identifier:#05x}"
