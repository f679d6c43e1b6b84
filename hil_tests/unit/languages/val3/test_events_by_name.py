"""Events of --at name an input or a channel as its board does, or as the application does: by the variable."""

import pytest

from hil_tests.unit.languages.val3.apps import App, datum, run, value

DATA = (
    datum("diStart", "dio", "1", value(link="UserIO\\in\\%I7"))
    + datum("diPart", "dio", "2", value("0", link="UserIO\\in\\%I8") + value("1", link="UserIO\\in\\%I9"))
    + datum("aiForce", "aio", "1", value(link="UserIO\\in\\%IW2"))
    + datum("siScan", "sio", "1", value(link="Serial\\COM1"))
    + datum("sCode", "string")
    + datum("nForce", "num")
    + datum("nStatus", "num")
)
CODE = """wait(diStart)
wait(diPart[1])
nForce=aioGet(aiForce)
sioCtrl(siScan,"timeout",3)
sCode=siScan
wait(ioStatus(diStart)==1)
nStatus=1"""


@pytest.mark.parametrize(
    ("start", "part", "force", "scan"),
    [("diStart", "diPart[1]", "aiForce", "siScan"), ("%I7", "UserIO\\in\\%I9", "%iw2", "COM1"), ("%i7", "%I9", "aiForce", "Serial\\COM1")],
)
def test_a_variable_refers_to_what_it_is_linked_to(start: str, part: str, force: str, scan: str) -> None:
    at = [
        (0.1, f"aio.{force}=4.5"),
        (0.2, f"dio.{start}=1"),
        (0.3, f"dio.{part}=1"),
        (0.5, f"sio.{scan}=A17\\r"),
        (0.7, f"io.{start}=locked"),
    ]
    result = run(App(data=DATA, programs={"start": CODE}), at=at)
    found = result["globals"]
    assert isinstance(found, dict)
    assert (found["nForce"], found["sCode"], found["nStatus"]) == (4.5, "A17", 1)
    assert result["log"] == []


def test_a_name_that_nothing_is_linked_to_is_in_the_log() -> None:
    result = run(App(data=DATA, programs={"start": "delay(1)"}), at=[(0.1, "dio.diStrat=1")])
    assert result["log"] == ["[01/01/20 00:00:00]: <0x0001> SYS:dio.diStrat: no data are linked to diStrat so far"]
