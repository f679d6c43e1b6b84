"""A CANopen device whose only long object is one of its own EDS: transfers in segments and blocks read that one."""

from pathlib import Path

import pytest

from drivers.emulator.canopen.sdo import SdoServer
from drivers.emulator.cia402.slave import Cia402Slave
from drivers.emulator.servo.settings import BusSettings, DriveSettings
from gateway.conformance.peers.can_devices import CYCLE_MS, NODE, QUICK, Drive, put
from gateway.conformance.peers.canopen301 import MUTANTS
from gateway.conformance.peers.canopen301_servers import server
from gateway.conformance.peers.score import play
from gateway.conformance.peers.stations import Variant
from gateway.conformance.suites.registry import SUITES
from gateway.files.find import find_config
from protocols.canopen.eds import parse

TEXT = "a data sheet of more than sixteen segments, " * 4
ONLY = tuple(f"CO301_SDO_BV_0{number}" for number in (4, 6, 7, 8))


class FourBits(SdoServer):
    """Counts the segments of a block with four bits."""

    def _next_block(self) -> list[bytes]:
        return [bytes((one[0] & 0x8F,)) + one[1:] for one in super()._next_block()]


def sheet() -> str:
    """1008h to 100Ah are 2101h to 2103h; the first of them is long."""
    text = find_config("axisgate_402.eds", "drives").read_text(encoding="utf-8")
    for number, index in enumerate(("1008", "1009", "100A"), 1):
        text = text.replace(f"[{index}]", f"[210{number}]").replace(f"=0x{index}\n", f"=0x210{number}\n")
    return text.replace("DefaultValue=axisgate emulated CiA 402 servo drive", f"DefaultValue={TEXT}")


@pytest.mark.parametrize(("kind", "first"), [(SdoServer, "PASS"), (FourBits, "FAIL")])
def test_the_long_object_of_an_eds_is_read(tmp_path: Path, kind: type[SdoServer], first: str) -> None:
    (tmp_path / "device.eds").write_text(sheet(), encoding="utf-8")
    dictionary, faults = parse(sheet())
    assert not faults, faults

    def tune(drive: Drive) -> None:
        put(drive, slave=Cia402Slave(BusSettings(CYCLE_MS, 1, {}, {NODE: DriveSettings(QUICK)}), {NODE: dictionary}))
        server(kind)(drive)

    device = Variant("own-text", "", lambda: Drive(tune), {**MUTANTS[0].link, "eds": str(tmp_path / "device.eds")}, {})
    found = {result.purpose.id: result for result in play(SUITES["canopen-301"], device, ONLY)}
    assert found["CO301_SDO_BV_04"].verdict.value == "PASS"
    assert found["CO301_SDO_BV_06"].verdict.value == first
    assert any(piece.identifier == 0x600 + NODE and piece.data[:4].hex() == "a4012100" for piece in found["CO301_SDO_BV_06"].notes.trace)
