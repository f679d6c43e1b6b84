"""How many of its faulty devices each suite finds, as last recorded by `axisgate conformance mutants SUITE`: (killed, mutants)."""

SCORES: dict[str, tuple[int, int]] = {
    "3964r": (98, 98),
    "rk512": (71, 71),
    "modbus-tcp": (82, 82),
    "modbus-rtu": (76, 76),
    "cia402": (86, 86),
    "canopen-301": (126, 126),
    "servodyn": (60, 60),
    "interop": (51, 51),
}
