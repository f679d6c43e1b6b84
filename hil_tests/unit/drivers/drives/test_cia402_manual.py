"""PP, PV, HM and IP by SDO alone against the emulated drive: it goes where it was sent, is off afterwards, and refusals are named."""

import pytest

from drivers.drives.canopen_steps import Answer, Write
from drivers.drives.cia402_boot import Parameter, boot
from drivers.drives.cia402_manual import Manual, ManualError, Moved, homing, interpolated, profile_position, profile_velocity
from drivers.emulator.cia402.states import State
from hil_tests.lab.virtual.cell_402_bench import Dialogue
from hil_tests.lab.virtual.one_node import NODE, OneNode, one_plan

HOME = (
    Parameter(0x6098, 0, b"\x21", "next index pulse, negative"),
    Parameter(0x6099, 1, (40_000).to_bytes(4, "little"), "fast"),
    Parameter(0x6099, 2, (8_000).to_bytes(4, "little"), "slow"),
)


def ready(*parameters: Parameter) -> tuple[OneNode, Dialogue]:
    rig = OneNode()
    dialogue = rig.dialogue()
    dialogue.carry(boot(one_plan(*parameters)))
    return rig, dialogue


def carried(plan: Manual, *parameters: Parameter) -> tuple[Moved, OneNode, Dialogue]:
    rig, dialogue = ready(*parameters)
    return dialogue.carry(plan), rig, dialogue


def off(rig: OneNode) -> bool:
    axis = rig.slave.axis(NODE)
    return axis.state is State.DISABLED and axis.mode.code == 8


@pytest.mark.parametrize("way", [16_384, -40_000])
def test_profile_position_goes_the_way_and_switches_off(way: int) -> None:
    moved, rig, _ = carried(profile_position(way, 100_000, 400_000))
    assert abs(moved.end_inc - moved.start_inc - way) <= 30 and off(rig)


def test_profile_velocity_runs_and_comes_to_rest() -> None:
    moved, rig, _ = carried(profile_velocity(-50_000, 500_000, 500))
    assert -32_000 < moved.end_inc - moved.start_inc < -18_000
    assert abs(rig.slave.axis(NODE).servo.speed_rad_s) < 0.5 and off(rig)


def test_homing_ends_at_the_index_pulse() -> None:
    moved, rig, _ = carried(homing(20_000), *HOME)
    assert abs(moved.end_inc) < 400 and rig.slave.axis(NODE).place.homed and off(rig)


def test_interpolated_points_are_followed_with_each_sync() -> None:
    points = [round(10_000 * n / 100) for n in range(1, 101)]
    moved, rig, _ = carried(interpolated(points, 4))
    assert abs(moved.end_inc - moved.start_inc - 10_000) <= 200 and off(rig)


def test_a_time_out_is_kept_though_every_answer_takes_its_time() -> None:
    """A home that is never found: an SDO answer costs 20 ms here, as on a busy bus."""
    creep = (1).to_bytes(4, "little")
    never = [Parameter(0x6098, 0, b"\x21", "index pulse"), Parameter(0x6099, 1, creep, "fast"), Parameter(0x6099, 2, creep, "slow")]
    _, dialogue = ready(*never)
    upload = dialogue.upload

    def slow(index: int, sub: int) -> Answer:
        dialogue.wait(20)
        return upload(index, sub)

    dialogue.upload = slow  # type: ignore[method-assign]  # a slow drive in its place
    start = dialogue.now
    with pytest.raises(ManualError, match="did not find its home"):
        dialogue.carry(homing(3_000))
    assert 3.0 <= (dialogue.now - start) / 1e9 < 4.0


def test_a_drive_that_waits_for_its_first_controlword_gets_one() -> None:
    _, dialogue = ready()
    answer, woken = dialogue.upload, False

    def asleep(index: int, sub: int) -> Answer:
        nonlocal woken
        woken = woken or any(isinstance(step, Write) and step.index == 0x6040 and step.data != b"\0\0" for step in dialogue.steps)
        return bytes(2) if index == 0x6041 and not woken else answer(index, sub)

    dialogue.upload = asleep  # type: ignore[method-assign]  # a slow drive in its place
    moved = dialogue.carry(profile_position(4_000, 100_000, 400_000))
    assert abs(moved.end_inc - moved.start_inc - 4_000) <= 30


def test_a_refused_object_is_named_and_a_fault_on_the_way_too() -> None:
    rig, dialogue = ready()
    dialogue.refuse[0x6081, 0] = 0x06090031
    with pytest.raises(ManualError, match=r"6081h:00: value of parameter written too high"):
        dialogue.carry(profile_position(1000, 1000, 1000))
    rig, dialogue = ready()
    rig.slave.cause(NODE, "motor_blocked", True)
    with pytest.raises(ManualError, match="did not reach enabled"):
        dialogue.carry(profile_position(1000, 1000, 1000))
