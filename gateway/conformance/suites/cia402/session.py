"""A CiA 402 drive at a bus: its modes, its option codes, how fast and how far it may be moved."""

from contextlib import suppress

from gateway.conformance.suites.can.node import NodeTester
from gateway.conformance.suites.can.session import NodeSession
from gateway.conformance.suites.cia402.drive import CSP, HM, MODES_OFFERED, PP, PROFILE_SPEED, PV
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
    """Units a second: a motion is judged by what SDOs read meanwhile, however slow they are."""
    return max(round(way * 1e9 / (LOOKS * took)), 1) if isinstance(way, (int, float)) and took else FASTEST


def open_drive(opened: Opened) -> NodeSession:
    """The session of the suite."""
    link = opened.bench.link

    def look(t: NodeTester, pics: dict[str, object]) -> None:
        offered = 0
        with suppress(Ended):
            offered = t.number(MODES_OFFERED)
        for item, mode in MODES.items():
            pics.setdefault(item, bool(offered >> (mode - 1) & 1))
        for item, key in OBJECTS.items():
            if item not in pics:
                pics[item] = t.exists(key)
        pics["may_power"] = pics["may_move"]
        pics.setdefault("homing_moves", bool(pics["hm"]))
        own, begin = SPEED, t.now()
        with suppress(Ended):
            own = t.number(PROFILE_SPEED) // 2 or SPEED
        t.setup.took = t.now() - begin
        way = link.get("way", max(own // 10, 100))
        pics["motion_way"] = way
        pics["motion_speed"] = link.get("speed", min(own, slow_enough(way, t.setup.took)))
        pics["way_stated"] = "way" in link

    return NodeSession(opened, look, (*OBJECTS, *MODES, "may_power", "homing_moves"))
