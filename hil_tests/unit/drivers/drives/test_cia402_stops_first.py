"""A drive that seems lost, or is to be started up while it is on, is told to stop before anything else."""

from drivers.drives.canopen_steps import Nmt, Write
from drivers.drives.cia402_boot import boot
from drivers.drives.cia402_family import STOP_CYCLES
from drivers.drives.family import Demand
from drivers.emulator.cia402.states import State
from hil_tests.lab.virtual.one_node import NODE, OneNode, one_plan
from protocols.base.machine import Frame
from protocols.canopen import cob_id as cobid

QUICK_STOP = b"\x02\x00"


def moving() -> OneNode:
    rig = OneNode().start()
    rig.on()
    assert rig.slave.axis(NODE).state is State.ENABLED
    return rig


def told(rig: OneNode) -> list[bytes]:
    """RPDO1 of one cycle, in which the cell still wants the drive on."""
    rig.cycle(Demand(on=True, position_inc=rig.drive.set_inc))
    return [frame.data for frame in rig.frames if frame.identifier == cobid.rpdo(1, NODE)]


def test_a_spoofed_boot_up_makes_the_drive_brake_at_once() -> None:
    rig = moving()
    rig.family.hear(Frame(cobid.heartbeat(NODE), b"\0"))
    told(rig)  # made before
    for _ in range(STOP_CYCLES):
        (data,) = told(rig)
        assert data[:2] == QUICK_STOP
    assert told(rig) == [], "then it is left to the start-up"
    assert rig.slave.axis(NODE).state is not State.ENABLED


def test_a_node_the_master_holds_is_ordered_to_stop_and_one_it_released_again_is_not() -> None:
    rig = moving()
    rig.family.hold(NODE)
    told(rig)
    assert told(rig)[0][:2] == QUICK_STOP
    rig.family.release(NODE, 8)
    told(rig)
    assert all(len(told(rig)) == 1 for _ in range(2 * STOP_CYCLES)), "its set values again, one a cycle"


def test_a_node_nobody_had_started_gets_nothing() -> None:
    rig = OneNode()
    rig.family.hear(Frame(cobid.heartbeat(NODE), b"\0"))
    assert told(rig) == []


def test_the_start_up_of_a_drive_that_is_on_stops_it_before_nmt() -> None:
    rig = moving()
    dialogue = rig.dialogue()
    plan = boot(one_plan())
    step, before = next(plan), []
    while not isinstance(step, Nmt):
        before.append(step)
        step = plan.send(dialogue.answer(step))
    assert Write(0x6040, 0, QUICK_STOP) in before
    assert rig.slave.axis(NODE).state in (State.DISABLED, State.QUICK_STOP) and abs(rig.slave.axis(NODE).servo.speed_rad_s) < 0.5


def test_the_start_up_of_a_drive_that_is_off_writes_nothing_before_nmt() -> None:
    rig = OneNode()
    rig.cycles(100)
    dialogue = rig.dialogue()
    plan = boot(one_plan())
    step = next(plan)
    while not isinstance(step, Nmt):
        assert not isinstance(step, Write)
        step = plan.send(dialogue.answer(step))
