"""How many of its faulty devices each suite finds, as last recorded by `axisgate conformance mutants SUITE`: (killed, mutants)."""

SCORES: dict[str, tuple[int, int]] = {
    "3964r": (110, 110),
    "rk512": (74, 74),
    "modbus-tcp": (85, 85),
    "modbus-rtu": (76, 76),
    "cia402": (92, 92),
    "canopen-301": (143, 143),
    "servodyn": (60, 60),
    "interop": (51, 51),
}
