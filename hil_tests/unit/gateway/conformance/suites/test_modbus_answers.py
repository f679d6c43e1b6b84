"""Modbus TCP servers with one fault each in what few clients look at: the case whose text describes it fails, others start from it."""

from collections.abc import Callable

import pytest

from gateway.conformance.peers.modbus_devices import Answer, Device
from gateway.conformance.peers.score import fails, play
from gateway.conformance.peers.stations import Variant
from gateway.conformance.suites.registry import SUITES
from protocols.base.machine import Ns

OBJECTS = (b"\0\5Maker", b"\1\4Type", b"\2\x031.0")


def identified(conformity: int = 1, more: int = 0, objects: int = 3, mei: bool = False) -> Answer:
    """Answers FC 43/14 itself."""

    def said(device: Device, asked: bytes, right: bytes) -> bytes:
        if asked[:3] == b"\x2b\x0e\x01":
            return bytes((0x2B, 14, 1, conformity, more, 0, objects)) + b"".join(OBJECTS[:objects])
        return asked if mei and asked[0] == 0x2B and asked[1] != 14 else right

    return said


def no_top_bit(device: Device, asked: bytes, right: bytes) -> bytes:
    return bytes((right[0] & 0x7F,)) + right[1:]


class Silent(Device):
    """Refuses by silence."""

    def framed(self, said: bytes) -> bytes:
        return b"" if len(said) == 9 and said[7] & 0x80 else said


class ReadsOn(Device):
    """Takes a request for what its function needs, whatever length its header has."""

    def receive(self, data: bytes, now: Ns) -> list[object]:
        if len(data) == 12 and data[7] in (1, 2, 3, 4):
            data = data[:4] + b"\0\6" + data[6:]
        return list(super().receive(data, now))


@pytest.mark.parametrize(
    "make, case",
    [
        (lambda: Device(False, identified(objects=2)), "MBTCP_FUN_CA_43"),
        (lambda: Device(False, identified(conformity=0)), "MBTCP_FUN_CA_43"),
        (lambda: Device(False, identified(more=0xFF)), "MBTCP_FUN_CA_43"),
        (lambda: Device(False, identified(mei=True)), "MBTCP_FUN_CA_43"),
        (lambda: ReadsOn(False), "MBTCP_TCP_BI_04"),
    ],
)
def test_the_fault_is_found_by_its_case(make: Callable[[], Device], case: str) -> None:
    assert fails(play(SUITES["modbus-tcp"], Variant("judged", "", make, {}, {}), (case,))) == (case,)


def test_an_identification_that_is_whole_passes() -> None:
    right = Variant("judged", "", lambda: Device(False, identified(conformity=0x81)), {}, {})
    assert fails(play(SUITES["modbus-tcp"], right, ("MBTCP_FUN_CA_43",))) == ()


@pytest.mark.parametrize("make", [lambda: Device(False, no_top_bit), lambda: Silent(False)])
def test_refusals_without_the_form_of_exceptions_are_one_fail(make: Callable[[], Device]) -> None:
    """The other cases of refusals start from it; more than twenty were FAIL."""
    others = {f"MBTCP_FUN_BI_{number}" for number in (10, 13, 20, 30, 33, 43, 50, 70, 71)}
    found = fails(play(SUITES["modbus-tcp"], Variant("judged", "", make, {}, {}), ("MBTCP_FUN_BI_04", *others)))
    assert "MBTCP_FUN_BI_04" in found
    assert not others & set(found)


def test_a_refusal_of_one_function_without_the_top_bit_is_not_taken_for_an_answer() -> None:
    """Of FC 6 alone: FUN_BI_04 asks another function."""

    def said(device: Device, asked: bytes, right: bytes) -> bytes:
        return no_top_bit(device, asked, right) if asked[0] == 6 else right

    only = ("MBTCP_FUN_BI_60", "MBTCP_LEN_BI_02", "MBTCP_LEN_BI_04")
    device = Variant("no-bit", "", lambda: Device(False, said), {"unit": 1}, {})
    results = {result.purpose.id: result for result in play(SUITES["modbus-tcp"], device, only)}
    assert fails(list(results.values())) == ("MBTCP_FUN_BI_60", "MBTCP_LEN_BI_02")
    assert results["MBTCP_FUN_BI_60"].reason == "FC 6 with a byte too few is refused without the top bit"
