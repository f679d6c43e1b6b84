"""A shadow beside a running control that moves its axes: line tapped, Modbus captured, bus listened to.  It finds what is different in its
cell and nothing else, and nothing of it leaves.
"""

import json
import pathlib
import time
from dataclasses import dataclass
from typing import Any

import pytest

from gateway.commands.run import main
from gateway.files.find import find_config
from hil_tests.lab.judges.bus_log import Logged
from hil_tests.lab.partners.plc2 import PTP
from hil_tests.lab.running.shadow_running import LINE, SERVER, Old, Shadow, old_control, until

pytestmark = pytest.mark.timeout(300)
CONTROL = '{ at = "D 0.4",  type = "bit", from = "cell.control" },'
PLACE = '{ at = "DW 2",   type = "KF",  from = "axis.A1.actual", unit = "0.1 mm" },'
SLOWER = "limits          = { min = -5.0, max = 1000.0, speed = 800.0, accel = 3000.0, jerk = 30000.0 }"  # of A2
TOLERANCE = 2.0  # mm, deg
A1, A2 = 1, 2
FAR = (150.0, 150.0, 5.0, 0.0, 0.0, 0.0)
CHANGED = {
    SLOWER: SLOWER.replace("speed = 800.0", "speed = 200.0"),
    CONTROL: CONTROL.replace("D 0.4", "D 0.5"),
    PLACE: PLACE.replace("0.1 mm", "1 mm"),
}
AGAIN_S = 5.0
LATER_S = 3.0  # more than the horizon of a comparison


@dataclass
class Seen:
    """What came of it."""

    code: int
    report: dict[str, Any]
    folder: pathlib.Path
    frames: list[Logged]  # of the shadow on the bus
    characters: bytes  # of the shadow on the line
    text: str
    page: str


def by_kind(seen: "Seen", kind: str) -> dict[str, Any]:
    """The line, or the Modbus server."""
    found = [line for line in seen.report["lines"] if line["kind"] == kind]
    assert len(found) == 1, seen.report["lines"]
    return dict(found[0])


@pytest.fixture(scope="module")
def seen() -> Seen:
    """The shadow's cell has "this command source has control" at another bit than the old controller, a position in another unit, and a
    slower A2."""
    with old_control() as old:
        cell = old.run.folder / "changed.toml"
        text = pathlib.Path(find_config("demo", "cells")).read_text()
        for there, here in CHANGED.items():
            assert there in text
            text = text.replace(there, here)
        cell.write_text(text)
        shadow = Shadow(old, cell, "beside", "--tolerance", str(TOLERANCE))

        def line(number: int = 0) -> dict[str, Any]:
            lines = shadow.kept("shadow-lines.json").get("lines")
            return lines[number] if isinstance(lines, list) and lines else {}

        def differences() -> dict[str, int]:
            return {place["place"]: place["different"] for block in line().get("blocks", ()) for place in block["places"]}

        asked = 0.0

        def controls() -> bool:
            """The PLC asks for control by the rising edge of drives-on; again when a busy machine cost one of the two its edge."""
            nonlocal asked
            if time.monotonic() - asked > AGAIN_S:
                old.plc.bit(0, 0, False)
                old.plc.wait_cycles(2)
                old.plc.bit(0, 0, True)
                asked = time.monotonic()
            found = differences()
            return found.get("D 0.5", 0) >= 5 and found.get("DW 0, other bits", 0) + found.get("D 0.4", 0) >= 5

        until(lambda: line(0).get("comparing") and line(1).get("comparing"), "the shadow compares")
        until(controls, "both have taken the PLC's wish for control, and five answers with it have been judged")
        old.plc.bit(0, 0, False)
        old.run.plc.wait(lambda status: status.owner == 0, 60.0)
        moved(old)
        moment = syncs(shadow)
        until(lambda: syncs(shadow) - moment > LATER_S * 1000 / old.run.p5_ms, "all of the move was judged")
        pid = shadow.kept("shadow-buses.json")["pid"]
        assert isinstance(pid, int)
        code, report = shadow.end()
        files = [(old.run.folder / f"beside.{ending}").read_text() for ending in ("txt", "html", "json")]
        assert json.loads(files[2]) == report
        return Seen(code, report, old.run.folder, old.frames_of(pid), bytes(old.wire.said_by_shadow), files[0], files[1])


def syncs(shadow: Shadow) -> int:
    """Heard and kept so far."""
    found = shadow.kept("shadow-buses.json").get("syncs", 0)
    assert isinstance(found, int)
    return found


def moved(old: Old) -> None:
    """By PLC 2: referenced, A1 alone, A2 alone.  Again when the machine took the drives off."""

    def body(number: int) -> None:
        for mask in (A1, A2):
            old.run.command(PTP, mask, 1.0, FAR)

    old.run.ready()
    old.run.repeat(1, body, old.run.ready)


def places(seen: Seen) -> dict[str, dict[str, Any]]:
    (block,) = by_kind(seen, "line")["blocks"]
    return {place["place"]: place for place in block["places"]}


def test_what_is_different_is_found_with_its_place_and_its_first_moment(seen: Seen) -> None:
    found = places(seen)
    assert seen.code == 1 and seen.report["equal"] is False and seen.report["compared"] is True
    here, there, place = found["D 0.5"], found["DW 0, other bits"], found["DW 2"]
    assert here["name"] == "cell.control" and (here["first"]["there"], here["first"]["here"]) == (0, 1), (
        "it followed the PLC as the old one"
    )
    assert (there["first"]["there"], there["first"]["here"]) == (1 << 4, 0) and there["never"] > 0
    assert place["name"] == "axis.A1.actual" and place["never"] > 0 and place["equal_percent"] < 20.0
    assert (place["first"]["there"], place["first"]["here"]) == (100, 10), "10.0 mm, the one in 0.1 mm, the other in 1 mm"
    assert "D 0.5 cell.control: equal in " in seen.text and "D 0.5 cell.control" in seen.page


def test_all_of_the_block_was_compared_and_what_is_equal_is_not_reported(seen: Seen) -> None:
    (block,) = by_kind(seen, "line")["blocks"]
    assert block["block"] == "DB 11" and block["answers"] >= 5 and block["compared"] > 35, "every bit of 32 words is in one place"
    quiet = {f"DW {word}" for word in range(9, 31)}
    assert not quiet & set(places(seen)), "words both leave at 0"
    assert "DW 31" not in places(seen), "both count their life word"
    assert by_kind(seen, "line")["telegrams"]["other_number"] == 0


def test_the_captured_modbus_was_answered_as_the_old_control_did(seen: Seen) -> None:
    modbus = by_kind(seen, "modbus")
    assert modbus["connected"] and modbus["telegrams"]["answered"] > 100 and modbus["telegrams"]["other_number"] == 0, modbus
    (block,) = [block for block in modbus["blocks"] if block["block"] == "modbus plc2, unit 1, input registers 1000..1057"]
    assert block["answers"] > 50
    reals = {place["name"]: place["equal_percent"] for place in block["places"] if place["name"].endswith(".actual")}
    assert all(equal > 60.0 for equal in reals.values()), f"both know where the drives stand: {reals}"
    assert not any(place["name"].endswith(".lag") for place in block["places"])
    assert "modbus plc2: " in seen.text and "<h2>Modbus plc2</h2>" in seen.page


def test_the_bus_was_heard_and_the_commands_to_the_drives_compared(seen: Seen) -> None:
    buses = seen.report["buses"]
    assert buses["syncs"] > 50
    names = [block["block"] for block in buses["telegrams"]]
    assert len(names) == 6 and names[0].endswith("telegram 210 (set value)") and names[-1].endswith("telegram 260 (set value)")
    assert all(block["compared"] == 6 for block in buses["telegrams"]), "five commands and the position"


def test_set_positions_are_equal_within_the_tolerance_but_for_the_axis_that_plans_otherwise(seen: Seen) -> None:
    """A2 has a quarter of the speed there: in the middle of its way it is far behind, at its end it is where the other is."""
    found = {
        place["name"]: place for block in seen.report["buses"]["telegrams"] for place in block["places"] if place["place"] == "position"
    }
    slow = found["A2"]
    assert slow["largest"] > 10 * TOLERANCE and slow["later_ms"] > 100.0 and slow["equal_percent"] > 80.0, slow
    others = {name: place["equal_percent"] for name, place in found.items() if name != "A2"}
    assert all(equal > 80.0 for equal in others.values()), found


def test_nothing_of_the_shadow_left(seen: Seen) -> None:
    """The broker's log knows it as a client that sent nothing; nothing came out of the ports that hear the line."""
    assert seen.frames == []
    assert seen.characters == b""


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("demo", "--shadow", "--bus", "broker:x"), f"--tap {LINE}=FROM_PLC,FROM_CONTROLLER"),
        (("demo", "--shadow", "--tap", f"{LINE}=a,b"), "name the bus of the old controller"),
        (("demo", "--shadow", "--tap", "plc9=a,b", "--bus", "broker:x"), "the cell's lines are plc1"),
        (("demo", "--shadow", "--tap", f"{LINE}=a", "--bus", "broker:x"), "LINE=FROM_PLC,FROM_CONTROLLER expected"),
        (
            ("demo", "--shadow", "--tap", f"{SERVER}=a,b", "--bus", "broker:x"),
            "the old controller's address and port expected, e.g. 10.0.0.7:502",
        ),
        (("demo", "--shadow", "--tap", f"{LINE}=a,b", "--bus", "broker:x", "--tolerance", "-1"), "--tolerance -1: 0 or more"),
        (("host-telegrams", "--shadow", "--tap", "V24_1=a,b", "--bus", "broker:x"), "a shadow understands rk512 on 3964R"),
    ],
)
def test_what_has_no_shadow_is_reported_with_what_to_do(options: tuple[str, ...], words: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(list(options)) == 2
    assert words in capsys.readouterr().err


@pytest.mark.parametrize(
    "options", [("demo", "--tap", "plc1=a,b"), ("demo", "--shadow", "--sim"), ("demo", "--seconds", "3"), ("demo", "--tolerance", "1")]
)
def test_options_of_the_other_kind_of_run_are_refused(options: tuple[str, ...]) -> None:
    with pytest.raises(SystemExit) as refused:
        main(["demo", *options])
    assert refused.value.code == 2
