"""A CiA 402 drive at a bus: its modes, its option codes, how fast and how far it may be moved."""

from contextlib import suppress

from gateway.conformance.suites.can.node import NodeTester
from gateway.conformance.suites.can.session import NodeSession
from gateway.conformance.suites.cia402.drive import CSP, DISPLAY, HM, MODE, MODE_SHOWN, MODES_OFFERED, PP, PROFILE_SPEED, PV, STEP
from gateway.conformance.suites.opening import Opened
from gateway.pure.conformance.verdict import Ended
from protocols.base.machine import Ns

OBJECTS = {
    "quick_option": (0x605A, 0),
    "shutdown_option": (0x605B, 0),
    "disable_option": (0x605C, 0),
    "halt_option": (0x605D, 0),
    "fault_option": (0x605E, 0),
    "abort_option": (0x6007, 0),
    "following": (0x6065, 0),
    "limits": (0x607D, 1),
    "period": (0x60C2, 1),
    "window": (0x6067, 0),
    "window_time": (0x6068, 0),
    "motor_speed": (0x6080, 0),
    "velocity": (0x606C, 0),
    "top_speed": (0x607F, 0),
    "modes": (0x6502, 0),
}
MODES = {"pp": PP, "pv": PV, "hm": HM, "csp": CSP}
SPEED, WAY = 80_000, 8_000  # where neither bench nor device states one
LOOKS = 20  # at the drive by SDO, on one way
FASTEST = 1 << 31


def slow_enough(way: object, took: Ns) -> int:
    """Units per second: a motion is judged by SDO reads during it, however slow they are."""
    return max(round(way * 1e9 / (LOOKS * took)), 1) if isinstance(way, (int, float)) and took else FASTEST


def _look_at_modes(t: NodeTester, pics: dict[str, object], assumed: list[str]) -> None:
    """From 6502h; without it each mode is tried by 6060h, without power, if the PICS does not state the modes."""
    offered = 0
    with suppress(Ended):
        offered = t.number(MODES_OFFERED)
    if not pics["modes"] and pics["may_move"] and not any(item in pics for item in MODES):
        offered = sum(1 << (mode - 1) for mode in MODES.values() if _takes(t, mode))
        names = ", ".join(item for item, mode in MODES.items() if offered >> (mode - 1) & 1)
        assumed.append(f"modes: {names or 'none'}, found by 6060h, because 6502h is missing")
    for item, mode in MODES.items():
        pics.setdefault(item, bool(offered >> (mode - 1) & 1))


def _takes(t: NodeTester, mode: int) -> bool:
    """6061h shows this mode once 6060h has it."""
    with suppress(Ended), t.kept(MODE):
        t.download(MODE, mode, 1)
        begin = t.now()
        while t.now() - begin < DISPLAY:
            if t.number(MODE_SHOWN, signed=True) == mode:
                return True
            t.pause(STEP)
    return False


def open_drive(opened: Opened) -> NodeSession:
    """The session of the suite."""
    link = opened.bench.link

    def look(t: NodeTester, pics: dict[str, object]) -> None:
        for item, key in OBJECTS.items():
            if item not in pics:
                pics[item] = t.exists(key)
        _look_at_modes(t, pics, session.assumed)
        pics["may_power"] = pics["may_move"]
        pics["fault_cause"] = bool(pics.get("consumer") and pics["abort_option"]) or bool(
            pics["csp"] and pics["following"] and pics["may_move"]
        )
        pics.setdefault("homing_moves", bool(pics["hm"]))
        own, begin = SPEED, t.now()
        with suppress(Ended):
            own = t.number(PROFILE_SPEED) // 2 or SPEED
        if own == SPEED:
            with suppress(Ended):
                own = min(own, t.number(OBJECTS["top_speed"]) // 2 or SPEED)
        t.setup.took = t.now() - begin
        way = link.get("way", max(own // 10, 100))
        pics["motion_way"] = way
        pics["motion_speed"] = link.get("speed", min(own, slow_enough(way, t.setup.took)))
        pics["way_stated"] = "way" in link

    session = NodeSession(opened, look, (*OBJECTS, *MODES, "may_power", "homing_moves", "fault_cause"))
    return session
