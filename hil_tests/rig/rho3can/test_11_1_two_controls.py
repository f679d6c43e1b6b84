"""rho 3 Releases part 8, 11.1, and part 5, 6.11: two real cycle processes coupled over one bus; I/O modules by hand on another."""

import contextlib
import pathlib
import select
import time
from collections.abc import Callable, Iterator

import pytest

from gateway.files.find import find_config, read_text
from gateway.pure.image.records.cell import InputImage, Quality, pack_inputs
from gateway.runtime.regions import RegionReader, RegionWriter
from hil_tests.lab.running.bus_running import Bus, running_bus
from hil_tests.lab.running.cycle_running import P5_MS, CycleRun, running_cycle
from protocols.base.machine import Frame

IO_BUS = """
[rho3]
P30 = [ {{ inputs = 0, outputs = 0, baud = 0 }}, {{ inputs = {count}, outputs = {count}, baud = 1 }} ]
P31 = [ {inputs} ]
P32 = [ {outputs} ]
[[bus]]
name     = "io"
port     = "sim"
protocol = "rho3-io"
"""  # beside the six axes of the demo cell, whose bus is not there: what happens here must not depend on it
LIMIT_S = 20.0  # a process starts within it, on a crowded machine too


def cell(folder: pathlib.Path, name: str, inputs: list[tuple[int, int, int]], outputs: list[tuple[int, int, int]]) -> pathlib.Path:
    """Blocks as (start, length, identifier)."""

    def blocks(rows: list[tuple[int, int, int]]) -> str:
        return ", ".join(f"{{ bus = 2, start = {start}, length = {length}, id = {number} }}" for start, length, number in rows)

    path = folder / f"{name}.toml"
    path.write_text(
        read_text(find_config("demo", "cells")) + IO_BUS.format(count=len(inputs), inputs=blocks(inputs), outputs=blocks(outputs))
    )
    return path


@pytest.fixture
def bus(tmp_path: pathlib.Path) -> Iterator[Bus]:
    with running_bus(tmp_path) as bus:
        yield bus


class Control:
    """PIC outputs into and PIC inputs out of one cycle process."""

    def __init__(self, run: CycleRun) -> None:
        self.run = run
        self._outputs, self._inputs = RegionWriter(run.fds["rc_in"], "rc_in"), RegionReader(run.fds["rc_out"], "rc_out")

    def put(self, first: int, data: bytes) -> None:
        image = InputImage()
        image.values[first : first + len(data)] = data
        image.quality[first : first + len(data)] = bytes([Quality.GOOD]) * len(data)
        self._outputs.write(pack_inputs(image), time.monotonic_ns())

    def get(self, first: int, last: int) -> bytes:
        payload = self._inputs.read()
        return bytes(payload[first : last + 1]) if payload else b""


def until(condition: Callable[[], bool], limit_s: float = LIMIT_S) -> bool:
    end = time.monotonic() + limit_s
    while not condition():
        if time.monotonic() > end:
            return False
        time.sleep(0.002)
    return True


@pytest.mark.requirement(
    "RHO-CAN-13",
    by=("gateway.pure.controllers.rho3.can.family:RhoFamily.exchange", "gateway.pure.controllers.rho3.can.family:RhoFamily.burst"),
)
def test_two_cells_exchange_bytes_92_to_95_and_neither_sends_sync(bus: Bus, tmp_path: pathlib.Path) -> None:
    one_file = cell(tmp_path, "one", [(92, 4, 471)], [(92, 4, 472)])
    two_file = cell(tmp_path, "two", [(92, 4, 472)], [(92, 4, 471)])
    url = {"io": f"broker:{bus.name}"}
    with contextlib.ExitStack() as stack:
        ear = bus.port()
        one, two = (Control(stack.enter_context(running_cycle(file, url))) for file in (one_file, two_file))
        one.put(92, b"\x12\x34\x56\x78")
        two.put(92, b"\x9a\xbc\xde\xf0")
        arrived = until(lambda: two.get(92, 95) == b"\x12\x34\x56\x78" and one.get(92, 95) == b"\x9a\xbc\xde\xf0")
        one.put(92, b"\x12\x34\x56\x79")
        changed = arrived and until(lambda: two.get(92, 95) == b"\x12\x34\x56\x79")
        heard = {frame.identifier for frame in ear.receive()}
    assert arrived and changed
    assert heard == {471, 472}


@pytest.mark.requirement("RHO-CAN-14", by="gateway.pure.controllers.rho3.can.family:RhoFamily.exchange")
def test_a_partner_that_dies_is_noticed_300_ms_later_and_is_good_again_when_it_is_back(bus: Bus, tmp_path: pathlib.Path) -> None:
    """The partner is written by hand; inputs of a lost one read 0."""
    with running_cycle(cell(tmp_path, "one", [(92, 4, 471)], [(92, 4, 472)]), {"io": f"broker:{bus.name}"}) as run:
        control, partner = Control(run), bus.port()
        control.put(92, bytes(4))

        def speak() -> bool:
            partner.send([Frame(471, b"\xa5\x5a\xa5\x5a")])
            time.sleep(0.01)
            return control.get(92, 95) == b"\xa5\x5a\xa5\x5a"

        alive = until(speak)
        for _ in range(30 * alive):
            speak()
        last = time.monotonic()
        gone = alive and until(lambda: control.get(92, 95) == bytes(4))
        took = time.monotonic() - last
        back = gone and until(speak)
    assert alive and gone and back
    assert 0.25 < took < 0.3 + 6 * P5_MS / 1000, took


@pytest.mark.requirement(
    "RHO-CAN-08",
    "RHO-CAN-09",
    by=("gateway.pure.controllers.rho3.can.family:RhoFamily.hear", "gateway.pure.controllers.rho3.can.family:RhoFamily.burst"),
)
def test_modules_answer_sync_and_bytes_of_the_image_follow_both_ways(bus: Bus, tmp_path: pathlib.Path) -> None:
    """Modules by hand: each SYNC is answered with 541; 471 carries O92..O95."""
    with running_cycle(cell(tmp_path, "one", [(88, 4, 541)], [(92, 4, 471)]), {"io": f"broker:{bus.name}"}) as run:
        control, modules = Control(run), bus.port()
        control.put(92, b"\x01\x02\x03\x04")
        frames: list[Frame] = []

        def answer() -> bool:
            select.select([modules], (), (), 0.1)
            for frame in modules.receive():
                frames.append(frame)
                if frame.identifier == 100:
                    modules.send([Frame(541, b"\x80\x00\x00\x01")])
            carried = Frame(471, b"\x01\x02\x03\x04") in [frame._replace(stamp_ns=0) for frame in frames[-8:]]
            return carried and control.get(88, 91) == b"\x80\x00\x00\x01"

        followed = until(answer)
        lost = followed and until(lambda: control.get(88, 91) == bytes(4))  # nobody answers any more
        back = lost and until(answer)
    assert followed and lost and back


def test_the_emulated_modules_of_a_simulated_run_show_the_outputs_as_inputs(tmp_path: pathlib.Path) -> None:
    from drivers.emulator.io.modules import IoModules

    modules = IoModules({541: 4, 471: 2}, [472, 473])
    assert modules.receive([Frame(100)]) == [Frame(541, bytes(4))]
    assert modules.receive([Frame(472, b"\x01\x02\x03\x04"), Frame(473, b"\x05")]) == [Frame(471, b"\x05\x00")]
    assert modules.receive([Frame(100), Frame(610, bytes(8))]) == [Frame(541, b"\x01\x02\x03\x04")]
