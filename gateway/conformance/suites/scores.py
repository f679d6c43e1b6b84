"""How many of its faulty devices each suite finds, as last recorded by `axisgate conformance mutants SUITE`: (killed, mutants)."""

SCORES: dict[str, tuple[int, int]] = {
    "3964r": (72, 72),
    "rk512": (56, 56),
    "modbus-tcp": (56, 56),
    "modbus-rtu": (53, 53),
    "cia402": (71, 71),
    "canopen-301": (93, 93),
}
