"""How many of its faulty devices each suite finds, as last recorded by `axisgate conformance mutants SUITE`: (killed, mutants)."""

SCORES: dict[str, tuple[int, int]] = {
    "3964r": (120, 120),
    "rk512": (84, 84),
    "modbus-tcp": (101, 101),
    "modbus-rtu": (96, 96),
    "cia402": (112, 112),
    "canopen-301": (154, 154),
    "servodyn": (82, 82),
    "interop": (51, 51),
}
