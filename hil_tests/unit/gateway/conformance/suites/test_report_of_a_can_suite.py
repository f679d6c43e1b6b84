"""Page 1 of the report: a CAN bus has no character format, and an item that is not stated is named so; a hint for [touch]."""

import struct

import pytest

from gateway.conformance.reporting.page import to_html
from gateway.conformance.suites.modbus.content import kept
from gateway.conformance.suites.modbus.tester import ModbusTester
from gateway.pure.conformance.verdict import Fail, Inconclusive

PORT = {"url": "socketcan:can0", "format": "9600 8E1"}


def page(suite: str, language: str = "en") -> str:
    found = {"suite": {"name": suite, "version": "1.0", "killed": 1, "mutants": 1}, "counts": {}, "bench": {"port": PORT}, "seed": None}
    return to_html(found | {"versions": {}, "sha256": "0" * 64, "interrupted": False, "at": "2026-11-28", "cases": []}, language)


def test_the_port_of_a_can_bus_has_no_character_format() -> None:
    assert "9600 8E1" not in page("cia402") and "socketcan:can0" in page("cia402")
    assert "socketcan:can0, 9600 8E1" in page("3964r")


def test_an_item_that_is_not_stated_is_named_so() -> None:
    assert "not stated: [device] of the bench" in page("cia402")
    assert "nicht angegeben: [device]" in page("cia402", "de")


def test_an_address_of_touch_that_the_device_lacks_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    def refused(self: ModbusTester, function: int, address: int, count: int) -> list[int]:
        raise Fail(f"FC {function}: exception 02h", "values", struct.pack(">B", 2).hex())

    monkeypatch.setattr(ModbusTester, "read", refused)
    tester = ModbusTester.__new__(ModbusTester)
    tester._preparing = 0
    with (
        pytest.raises(Inconclusive, match=r"\[touch\] names holding 20 to 21: state only addresses that the device has"),
        kept(tester, 3, 20, 2),
    ):
        pass
