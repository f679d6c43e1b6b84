"""Sizes of objects whose upload does not announce one: a server may answer 42h, expedited without size (CiA 301, 7.2.4.3.5)."""

from protocols.canopen.dictionary import Key

BYTES = frozenset((0x1001, 0x100D, 0x1019, 0x6060, 0x6061, 0x6098))
WORDS = frozenset((0x100C, 0x1015, 0x1017, 0x6007, 0x603F, 0x6040, 0x6041, *range(0x605A, 0x605F), 0x6066, 0x6068, *range(0x6070, 0x6074)))
VARIABLES = frozenset((0x1000, 0x1002, 0x1005, 0x1006, 0x1007, 0x1008, 0x1009, 0x100A, 0x1012, 0x1013, 0x1014))
PARAMETERS = {1: 4, 2: 1, 3: 2, 5: 2, 6: 1}  # of a PDO: sub-index and bytes
NODE_BYTES = frozenset((0x1028, 0x1029))


def object_size(key: Key) -> int:
    """Bytes of an object of CiA 301 or CiA 402; 4 for any other."""
    index, sub = key
    if index in BYTES or index in NODE_BYTES:
        return 1
    if index in WORDS:
        return 2
    if 0x1400 <= index < 0x1600 or 0x1800 <= index < 0x1A00:
        return PARAMETERS.get(sub, 1)
    return 1 if sub == 0 and 0x1003 <= index < 0x2000 and index not in VARIABLES else 4
