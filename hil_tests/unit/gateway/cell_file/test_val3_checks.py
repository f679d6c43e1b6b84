"""[val3] judged before anything runs: application, its programs, its arm, links, channels (AX-930)."""

import pathlib
import shutil
from collections.abc import Callable

import pytest

import configs
from gateway.cell_file.load import CellFaults, load_cell

CELLS = pathlib.Path(configs.__file__).parent / "cells"
CHANNEL = '[[val3.channel]]\nname = "Socket\\\\cam"\nkind = "client"\n{}\n[controller]\n'


@pytest.fixture
def judged(tmp_path: pathlib.Path) -> Callable[..., list[str]]:
    """Faults of the shipped cell with other texts in the cell file or in a file of its application."""
    shutil.copytree(CELLS / "cs8", tmp_path / "cs8")
    cell = tmp_path / "cs8.toml"
    cell.write_text((CELLS / "cs8.toml").read_text())

    def judge(*edits: tuple[str, str, str]) -> list[str]:
        for name, old, new in edits:
            path = cell if name == "cell" else tmp_path / "cs8" / "usrapp" / "cycle" / name
            text = path.read_text()
            assert old in text, old
            path.write_text(text.replace(old, new, 1))
        try:
            load_cell(str(cell))
        except CellFaults as found:
            return [str(fault) for fault in found.faults]
        return []

    return judge


def test_the_shipped_cell_is_sound(judged: Callable[..., list[str]]) -> None:
    assert judged() == []


@pytest.mark.parametrize(
    ("edit", "words"),
    [
        (("cell", 'application = "cycle"', 'application = "other"'), "there is no such folder or file"),
        (("cell", 'disk        = "cs8/usrapp"', 'disk = "nowhere"'), "there is no such folder or file"),
        (("cell", 'mode        = "remote"', 'mode = "auto"'), "val3.mode"),
        (("cell", "[robot]", '[[robot]]\nkinematics = "scara"\nmodel = "sr60-like"\nname = "S"\n[[robot]]'), "one [robot], this one has 2"),
        (("cell", 'kind = "val3"', 'kind = "rho3"'), 'an application needs [controller] with kind = "val3"'),
        (("cell", 'name    = "valve1"', 'name    = "valve2"'), "cycle, tGripper: no [[controller.point]] is ValveIO\\valve1"),
        (("cell", "[controller]\n", CHANNEL.format("port = 0")), "port 0: 1..65535 expected"),
        (("start.pgx", "nDone=0", "nDone=jHome"), "(File start.pgx-line 2)"),
        (("start.pgx", "nDone=0", "call missing()"), "undefined program"),
        (("cycle.pjx", '<Program file="stop.pgx" />', ""), "cycle has no stop(): it serves as a library only"),
        (("cycle.dtx", 'type="joint" size="1"', 'type="jointRs" size="1"'), "made for an RS arm"),
    ],
)
def test_each_fault_is_one_sentence(judged: Callable[..., list[str]], edit: tuple[str, str, str], words: str) -> None:
    found = judged(edit)
    assert any(words in each for each in found), found
    assert all("\n" not in each and "Traceback" not in each for each in found)


def test_a_fault_of_a_program_hides_no_link(judged: Callable[..., list[str]]) -> None:
    judged(("cell", 'name    = "valve1"', 'name    = "valve2"'))
    found = judged(("start.pgx", "nDone=0", "call missing()"))
    assert len(found) == 2 and "undefined program" in found[0] and "tGripper: no [[controller.point]] is ValveIO\\valve1" in found[1]


def test_a_socket_of_the_application_has_its_channel(judged: Callable[..., list[str]]) -> None:
    sio = '<Data name="sCam" access="public" xsi:type="array" type="sio" size="1">\n<Value key="0" link="Socket\\cam" /></Data>\n  </Datas>'
    assert judged(("cycle.dtx", "  </Datas>", sio)) and "no [[val3.channel]] is Socket\\cam" in judged()[0]
    assert judged(("cell", "[controller]\n", CHANNEL.format('address = "127.0.0.1"\nport = 4000'))) == []
