"""AX-680: a PLC writes a parameter of a CiA 402 drive through a route, over 3964R/RK512; the drive itself is asked what it has."""

from drivers.ports.base import runtime_dir
from gateway.simulation.drives.control import EmulatorControl
from gateway.tools.client import running
from hil_tests.lab.partners.plc1 import S5Plc
from hil_tests.lab.running.cell_running import P5_MS
from hil_tests.lab.running.joined_running import cell_copy, running_joined

ROUTES = """
[[route]]
name    = "profile_velocity"
from    = "DB10.DW7"
type    = "KF"
to      = "X:6081h:00"
to_type = "u32"
scale   = 10.0
offset  = 400000.0
"""
UP_S = 25.0
VELOCITY = 0x6081


def test_a_plc_writes_a_drive_parameter_and_a_drive_that_was_reset_is_given_it_again() -> None:
    with running_joined(lambda folder: cell_copy("s5-rk512", folder, more=ROUTES), "s5p", p5_ms=P5_MS) as run:
        plc = S5Plc(str(runtime_dir() / "s5p-plc-a"), ["X", "Y", "Z"])
        plc.word(7, 1200)
        plc.start()
        try:
            with running("s5p") as client:

                def has(value: int) -> bool:
                    return int.from_bytes(client.sdo("X", VELOCITY), "little") == value

                client.wait_ready(UP_S)
                run.until(lambda: has(412_000), "the first value of the PLC")
                plc.word(7, -5)
                run.until(lambda: has(399_950), "a changed one")
                assert int.from_bytes(client.sdo("Y", VELOCITY), "little") != 399_950, "the other drives keep theirs"
                client.sdo("X", VELOCITY, 0, (7).to_bytes(4, "little"))
                assert has(7)
                EmulatorControl("s5p-can0").ask("reset_node", node=1)
                client.wait_ready(UP_S)
                run.until(lambda: has(399_950), "once more after its start-up", UP_S)
        finally:
            plc.stop()
