"""How many of its faulty devices each suite finds, as last recorded by `axisgate conformance mutants SUITE`: (killed, mutants)."""

SCORES: dict[str, tuple[int, int]] = {
    "3964r": (117, 117),
    "rk512": (76, 76),
    "modbus-tcp": (97, 97),
    "modbus-rtu": (90, 90),
    "cia402": (110, 110),
    "canopen-301": (154, 154),
    "servodyn": (82, 82),
    "interop": (51, 51),
}
