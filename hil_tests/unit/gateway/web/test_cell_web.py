"""[web] of a cell (AX-470): off unless asked for, on loopback unless encrypted."""

import tomllib

import pytest

from gateway.assembly.run import page_of
from gateway.cell_file.load import CellFaults, load_cell, load_tables
from gateway.files.find import find_config
from gateway.pure.cell.web import Web


def with_web(**web: object) -> object:
    raw = tomllib.loads(find_config("demo", "cells").read_text())
    return load_tables("cell.toml", {**raw, "web": web}).web


def test_without_the_table_and_without_an_order_nothing_is_served() -> None:
    cell = load_cell("demo")
    assert cell.web is None
    assert page_of(cell, None, simulated=True) is None
    assert page_of(cell, 9000, simulated=False) == Web(bind="127.0.0.1:9000")


def test_the_defaults_are_loopback_and_may_be_changed() -> None:
    assert with_web() == Web(bind="127.0.0.1:8480", read_only=False)
    assert Web().local
    assert not Web(bind="10.0.0.7:8480").local


@pytest.mark.parametrize(
    "table, words",
    [
        ({"bind": "0.0.0.0:8480"}, "set tls_certificate and tls_key, or bind 127.0.0.1"),
        ({"bind": "10.0.0.7:8480"}, "reached from other computers"),
        ({"tls_certificate": "a.pem"}, "belong together"),
        ({"tls_certificate": "a.pem", "tls_key": "a.key"}, "no such file"),
        ({"bind": "127.0.0.1:0"}, "port 1..65535"),
        ({"bnd": "x"}, "bind"),
    ],
)
def test_what_would_be_reached_in_the_clear_is_a_fault(table: dict[str, object], words: str) -> None:
    with pytest.raises(CellFaults) as faults:
        with_web(**table)
    assert words in str(faults.value)
