"""How many of its faulty devices each suite finds, as last recorded by `axisgate conformance mutants SUITE`: (killed, mutants)."""

SCORES: dict[str, tuple[int, int]] = {
    "3964r": (97, 97),
    "rk512": (69, 69),
    "modbus-tcp": (82, 82),
    "modbus-rtu": (76, 76),
    "cia402": (86, 86),
    "canopen-301": (126, 126),
    "servodyn": (60, 60),
    "interop": (51, 51),
}
