"""users.md 3.5 on a real pty: the host sends ORDER, the cell's values and signal follow, the cell answers DONE.  Bytes by hand."""

import time
from collections.abc import Callable

from hil_tests.rig.telegrams.conftest import HostRun, host_cell

ORDER = bytes.fromhex("00 00 4f 52  39 30 00 00  07 00 00 00  00 00 c0 3f  41 31")  # 12345, 7, 1.5 mm, "A1"
DONE = bytes.fromhex("00 00 44 4e  39 30 00 00  00 00 00 00")  # 12345, no error


def test_the_order_of_users_md_becomes_values_and_done_goes_back(start: Callable[[str], HostRun]) -> None:
    run = start(host_cell())
    assert run.var("order.number")["quality"] == "BAD"
    assert run.gives(ORDER)
    new = run.until("order.new", "value", 1)
    assert (new["value"], new["quality"], new["source"]) == (1, "GOOD", "V24_1/ORDER")
    values = {name: run.var(f"order.{name}")["value"] for name in ("number", "pallet", "height", "pattern")}
    assert values == {"number": 12345, "pallet": 7, "height": 1.5, "pattern": "A1"}
    assert run.var("order.height")["age_ms"] < 5000

    assert run.var("order.done", "0")["value"] == 0
    assert run.var("order.done", "1")["value"] == 1
    assert run.got(1) == [DONE]
    assert run.until("telegram.DONE.sent", "value", 1)["value"] == 1
    run.var("order.done", "1")  # a standing value is no edge
    assert run.got(2, 1.0) == [DONE]

    # ---- what is no ORDER changes nothing and is counted; 3964R itself acknowledged it, it was a good block
    assert run.gives(ORDER[:-1]) and run.gives(b"\0\0XX") and run.gives(ORDER[:12] + bytes.fromhex("0000c07f") + b"A1")
    assert run.until("telegram.ORDER.refused", "value", 2)["value"] == 2
    assert run.var("order.new")["value"] == 1 and run.var("order.height")["value"] == 1.5

    # ---- a number that does not fit is not sent
    run.var("order.number", str(2**31))
    run.var("order.done", "0")
    run.var("order.done", "1")
    assert run.until("telegram.DONE.failed", "value", 1)["value"] == 1
    assert run.got(2, 0.5) == [DONE]

    # ---- the host's cable is gone: DONE is given up after six attempts, and goes again when the host is back
    run.var("order.number", "5")
    run.line.close()
    for value in ("0", "1"):
        run.var("order.done", value)
    end = time.monotonic() + 15.0
    while run.var("telegram.DONE.failed")["value"] != 2 and time.monotonic() < end:
        time.sleep(0.1)
    assert run.var("telegram.DONE.failed")["value"] == 2
    run.line = HostRun(run.name, run.record).line
    assert run.var("order.number")["value"] == 5
    for value in ("0", "1"):
        run.var("order.done", value)
    assert run.got(1) == [DONE[:4] + b"\x05\0\0\0" + DONE[8:]]
