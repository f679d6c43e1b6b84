"""How many of its faulty devices each suite finds, as last recorded by `axisgate conformance mutants SUITE`: (killed, mutants)."""

SCORES: dict[str, tuple[int, int]] = {
    "3964r": (122, 122),
    "rk512": (85, 85),
    "modbus-tcp": (103, 103),
    "modbus-rtu": (99, 99),
    "cia402": (122, 122),
    "canopen-301": (156, 156),
    "servodyn": (88, 88),
    "interop": (51, 51),
}
