"""What `check` says of [[io]] and [[route]]: overlaps, two writers, no type, overflow, unreachable ends, polling, rings (issue 6.5)."""

import pytest

from gateway.assembly.routes import routed_values
from gateway.cell_file.load import CellFaults, load_cell
from gateway.commands.run import why_not
from gateway.files.find import find_config, read_text

S5 = read_text(find_config("s5-rk512", "cells"))
BLOCK = """
[[db]]
number = 30
words  = 8
writer = "axisgate"
line   = "plc"
entries = [ { at = "DW 0", type = "KF", from = "cell.life" }, { at = "D 1.3", type = "bit", from = "cell.ready" } ]
"""


def faults(more: str, cell: str = S5) -> list[tuple[str, str]]:
    try:
        load_cell("c.toml", cell + BLOCK + more)
    except CellFaults as found:
        return [(fault.key, f"{fault.hint} {fault.range}") for fault in found.faults]
    return []


def route(name: str, **keys: object) -> str:
    lines = [f'name = "{name}"', *(f"{key.rstrip('_')} = {value!r}".replace("'", '"') for key, value in keys.items())]
    return "\n[[route]]\n" + "\n".join(lines) + "\n"


def io(name: str, device: str, signal: str, more: str = "") -> str:
    return f'\n[[io]]\nname = "{name}"\ndevice = {{ {device} }}\nsignal = "{signal}"\n{more}\n'


CLIENT = """
[[modbus]]
name = "coupler"
role = "client"
port = "tcp://10.0.0.7:502"
[[modbus.device]]
name = "tank"
[[modbus.value]]
device = "tank"
table = "holding"
at = 10
type = "REAL"
from = "tank.goal"
"""
CAN, TCP = 'type = "canopen-401", bus = "can0", node = 20', 'type = "modbus", url = "tcp://10.0.0.9:502"'
GOOD = (
    route("a", from_="DB10.DW2", type="KF", to="DB30.DW2", valid="DB30.D1.0", life="DB30.DW3", within_ms=600)
    + route("b", from_="axis.X.actual", to="DB30.DW4", to_type="KF", scale=10.0)
    + route("c", from_="E 8.0", to="A 90.0", edge="rising")
    + route("d", from_="io.safety_ok", to="io.lamp")
    + io("lamp", f"{CAN}, output = 3", "io.lamp")
    + io("dog", f"{TCP}, output = 0", "cell.watchdog")
    + io("feed", f"{TCP}, input = 4", "USER_1_RCI")
    + io("line", 'type = "gpiochip", chip = "/dev/gpiochip0", output = 4, active_low = true', "axis.Z.brake")
)


def test_routes_and_contacts_that_are_right_pass() -> None:
    assert [fault for fault in faults(GOOD) if fault[0] != "io.feed.signal"] == []


def test_routes_begin_and_end_in_registers_of_devices() -> None:
    """AX-407."""
    good = (
        CLIENT + route("r", from_="tank:30001", type="s16", to="DB30.DW2", to_type="KF") + route("w", from_="io.safety_ok", to="tank:00007")
    )
    assert faults(good) == []
    assert [value.name for value in routed_values(load_cell("c.toml", S5 + BLOCK + good))["coupler"]] == [
        "from coupler.tank.input.0.s16",
        "to coupler.tank.coil.6.bit",
    ]


@pytest.mark.parametrize(
    ("more", "key", "words"),
    [
        (CLIENT + route("r", from_="tonk:30001", type="s16", to="DB30.DW2"), "route.r", "[[modbus.device]] of a client"),
        (CLIENT + route("r", from_="DB10.DW2", type="KF", to="tank:30001"), "route.r.to", "can only be read"),
        (CLIENT + route("r", from_="DB10.DW2", type="KF", to="tank:40012"), "route.r.to", "two writers: [[modbus.value]] from tank.goal"),
        (CLIENT + route("r", from_="tank:30001", type="u16", to="DB30.DW2", to_type="KF"), "route.r.to", "overflow"),
        (CLIENT + route("r", from_="DB10.DW2", type="KF", to="tank:40001", to_type="u16"), "route.r.to", "overflow"),
        (CLIENT + route("r", from_="tank:10001", to="DB30.D1.0", within_ms=200), "route.r.within_ms", "polling does not fit"),
        (
            CLIENT
            + route("q", from_="DB10.DW2", type="KF", to="tank:40001", to_type="s32")
            + route("r", from_="DB10.DW3", type="KF", to="tank:40002"),
            "route.r.to",
            "route q writes it already",
        ),
        (route("r", from_="DB10.DW2", to="DB30.DW2"), "route.r", "the number format is missing"),
        (route("r", from_="DB10.DW2", type="KF", to="DB30.DW0"), "route.r.to", "overlaps the entry DW 0"),
        (route("r", from_="DB10.D0.9", to="DB30.D1.3"), "route.r.to", "overlaps the entry D 1.3"),
        (route("r", from_="DB10.DW2", type="KF", to="DB10.DW20"), "route.r.to", "two writers in one word"),
        (route("r", from_="DB10.DW2", type="KF", to="DB30.DW8"), "route.r.to", "beyond the block"),
        (route("r", from_="DB10.DW2", type="KF", to="DB99.DW0"), "route.r", "no [[db]] of this cell"),
        (route("r", from_="DB30.DW2", type="KF", to="AW 90"), "route.r.from", "written by axisgate itself"),
        (route("r", from_="DB10.DW2", type="KF", to="AB 90", to_type="u8"), "route.r.to", "overflow"),
        (route("r", from_="axis.X.actual", to="DB30.DW4", to_type="KF", scale=100.0), "route.r.to", "overflow"),
        (route("r", from_="DB10.D0.9", to="A 3.2"), "route.r.to", "two writers in RC input byte 3: plc"),
        (route("r", from_="DB10.D0.9", to="E 8.0"), "route.r.to", "only the cycle writes RC outputs"),
        (route("r", from_="DB10.D0.9", to="drives.on"), "route.r.to", "commands come from command sources"),
        (route("r", from_="axis.Q.actual", to="DB30.DW4", to_type="KF"), "route.r.from", "no such axis"),
        (route("r", from_="cell.redy", to="A 90.0"), "route.r.from", "cell.ready"),
        (route("r", from_="io.nobody", to="A 90.0"), "route.r.from", "no such contact"),
        (route("r", from_="DB10.D0.9", to="io.ready_contact"), "route.r.to", "two writers: the contact shows cell.ready"),
        (route("r", from_="DB10.DW2", type="KF", to="AW 90", within_ms=100), "route.r.within_ms", "polling does not fit"),
        (route("r", from_="DB10.D0.9", to="DB30.D1.0", edge="rising", pulse_ms=50), "route.r.pulse_ms", "between two of them unseen"),
        (route("r", from_="DB10.D0.9", to="A 90.0", scale=0.0), "route.r.scale", "never follows"),
        (route("r", from_="DB10.D0.9", to="A 90.0", on_loss="zero", loss_value=1.0), "route.r.loss_value", 'on_loss = "value"'),
        (route("r", from_="DB10.D0.9", to="A 90.0", valid="cell.ready"), "route.r.valid", "a mark must be in"),
        (
            route("r", from_="DB10.D0.9", to="A 90.0") + route("s", from_="DB10.D0.10", to="A 90.0"),
            "route.s.to",
            "routes that disagree: route r writes it already",
        ),
        (route("r", from_="DB10.D0.9", to="A 90.0", life="AW 90"), "route.r.to", "routes that disagree"),
        (route("r", from_="A 91.0", to="A 90.0") + route("s", from_="A 90.0", to="A 91.0"), "route.r.to", "routes in a ring"),
        (route("r", from_="A 91.0", to="A 90.0") + route("r", from_="A 91.1", to="A 90.1"), "route.r.name", "another route"),
        (route("r", from_="DB10.DW2", type="KF", to="6081h:00", to_type="u32"), "route.r", "AXIS:6081h:00"),
        (route("r", from_="DB10.D0.9", to="unknown:A 90.0"), "route.r", "before the colon"),
        (route("r", from_="unknown:E 8.0", to="A 90.0"), "route.r", "before the colon"),
        (route("r", from_="DB10.DW2", type="KF", to="other:DB30.DW2"), "route.r.to", "not served on line other"),
        (route("r", from_="DB10.D0.9", to="A 90.0", valid="unknown:A 91.0"), "route.r", "before the colon"),
        (route("r", from_="DB10.DW2", type="KF", to="Q:6072h:00", to_type="s32"), "route.r.to", "no axis Q"),
        (route("r", from_="DB10.DW2", type="KF", to="X:6072h:00", to_type="u16"), "route.r.to", "overflow"),
        (route("r", from_="DB10.DW2", type="KF", to="X:607Ah:00", to_type="s32"), "route.r.to", "sets this object"),
        (route("r", from_="DB10.DW2", type="KF", to="X:1017h:00", to_type="s32"), "route.r.to", "2000h..9FFFh"),
        (route("r", from_="X:6072h:00", type="u16", to="AW 90"), "route.r.from", "does not read them"),
        (io("x", f"{CAN}, output = 0", "cell.ready"), "io.x.device", "is already this contact"),
        (io("x", f"{CAN}, output = 64", "cell.ready"), "io.x.device", "0..63"),
        (io("x", 'type = "modbus", output = 0', "cell.ready"), "io.x.device.url", "needs it"),
        (io("x", f'{TCP}, bus = "can0", output = 0', "cell.ready"), "io.x.device.bus", "a modbus device has none"),
        (io("x", f"{TCP}, output = 0", "axis.X.brak"), "io.x.signal", "axis.X.brake"),
        (io("x", f"{TCP}, output = 0", "io.x"), "io.x.signal", "no route writes it"),
        (io("x", f"{TCP}, output = 0", "cell.watchdog", "toggle_ms = 2"), "io.x.toggle_ms", ">= 4"),
        (io("x", f"{TCP}, input = 0", "cell.ready"), "io.x.signal", "not a signal that an input may drive"),
        (io("x", f"{TCP}, input = 0", "cell.feed_allow"), "io.x.signal", "two writers in RC input byte 3"),
        (io("x", f"{TCP}, input = 0, poll_ms = 5", "cell.safety_ok") + io("y", f"{TCP}, output = 1", "cell.ready")
         + io("z", f"{TCP}, output = 2", "cell.error"), "io.x.device.poll_ms", "polling does not fit"),
        (io("x", f"{TCP}, active_low = true, input = 0", "cell.safety_ok"), "io.x.device.active_low", "only a gpiochip"),
    ],
)  # fmt: skip
def test_what_is_refused_and_why(more: str, key: str, words: str) -> None:
    found = faults(more)
    assert [fault[0] for fault in found] == [key], found
    assert words in found[0][1]


def test_a_brake_at_the_gateway_plays_only_with_a_contact_that_shows_it() -> None:
    cell = S5.replace('brake            = "drive"', 'brake            = "gateway"')
    assert "axis.Z.brake = gateway" in why_not(load_cell("c.toml", cell), p5=None)
    contacts = "".join(io(f"brake_{axis}", f"{CAN}, output = {n}", f"axis.{axis}.brake") for n, axis in enumerate("XYZ", 4))
    assert why_not(load_cell("c.toml", cell + contacts), p5=None) == ""


DEMO_402 = read_text(find_config("demo-402", "cells"))


@pytest.mark.parametrize(
    ("to", "to_type", "words"),
    [
        ("A1:6041h:00", "u16", "read-only according to axisgate_402.eds"),
        ("A1:6072h:00", "u32", "UNSIGNED16 in axisgate_402.eds; u32 has 4 bytes"),
        ("A1:5FFFh:00", "u16", "lists no object 5FFFh:00"),
        ("A1:6072h:01", "u16", "lists no object 6072h:01"),
        ("A1:6072h:00", "u16", ""),
    ],
)
def test_a_parameter_is_held_against_the_data_sheet_of_its_drive(to: str, to_type: str, words: str) -> None:
    """AX-680."""
    found = faults(route("r", from_="AB 91", type="u8", to=to, to_type=to_type), DEMO_402.replace("number = 30", "number = 31"))
    mine = [hint for key, hint in found if key.startswith("route.")]
    assert (mine == []) if not words else (len(mine) == 1 and words in mine[0]), found


def test_a_drive_that_is_not_on_canopen_has_no_parameters_a_route_writes() -> None:
    servodyn = read_text(find_config("demo", "cells"))
    found = faults(route("r", from_="AB 91", type="u8", to="A1:6072h:00", to_type="u16"), servodyn)
    assert [key for key, hint in found if "not on a CANopen bus" in hint] == ["route.r.to"]


def test_a_contact_shows_an_output_of_a_reis_where_the_cell_has_one() -> None:
    lamp = io("lamp", f"{CAN}, output = 3", "reis.output.3.7")
    reis = '\n[controller]\nkind = "reis"\n'
    assert ("io.lamp.signal" in dict(faults(lamp)), "io.lamp.signal" in dict(faults(lamp + reis))) == (True, False)
    assert "io.lamp.signal" in dict(faults(lamp.replace("3.7", "3.8") + reis)), "a byte has eight bits"
