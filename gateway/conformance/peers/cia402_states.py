"""CiA 402: parts that err between two states or modes, and correct drives of unusual kinds (used by peers.cia402)."""

from collections.abc import Sequence

from drivers.emulator.cia402 import objects as od
from drivers.emulator.cia402.homing import TO_INDEX
from drivers.emulator.cia402.modes import START, ProfilePosition
from drivers.emulator.cia402.states import BIT12, BIT13, TARGET, State
from drivers.emulator.servo.settings import DriveSettings, ServoSettings
from gateway.conformance.peers.can_devices import Drive, put
from protocols.base.machine import Frame, Ns, ms
from protocols.canopen.dictionary import Key
from protocols.canopen.nmt import State as NmtState
from protocols.canopen.sdo import Abort
from protocols.canopen.types import Value

SEARCH, SHOWN, CHANGES = ms(20), ms(80), ms(300)
SPEEDS: tuple[Key, ...] = (od.PROFILE_SPEED, od.TARGET_SPEED, od.ACCELERATION, od.DECELERATION, od.QUICK_STOP_DECELERATION)
COARSE = 100  # increments a second in one unit of speed


def _enabled(drive: Drive, mode: int) -> bool:
    return drive.axis.state is State.ENABLED and drive.axis.mode.code == mode


def no_search(drive: Drive) -> None:
    """Homing to the index is attained after a while, without a motion."""
    mode, readers = drive.axis.modes[6], drive.node.objects.readers
    control, word = mode.control, readers[od.STATUSWORD]

    def heard(now: int, before: int) -> None:
        if drive.axis.value(od.HOMING_METHOD) not in TO_INDEX:
            control(now, before)
        elif now & START and not before & START:
            drive.tally = drive.now

    def shown() -> int:
        found = int(word())
        if not _enabled(drive, 6) or not drive.tally or drive.axis.value(od.HOMING_METHOD) not in TO_INDEX:
            return found
        found &= ~(BIT12 | BIT13 | TARGET)
        return found | (BIT12 | TARGET if drive.now - drive.tally > SEARCH and drive.axis.controlword & START else 0)

    put(mode, control=heard)
    readers[od.STATUSWORD] = shown


def display_frozen(drive: Drive) -> None:
    """6061h does not change while operation is enabled."""
    readers = drive.node.objects.readers
    real = readers[od.MODE_DISPLAY]

    def shown() -> Value:
        if drive.axis.state is not State.ENABLED:
            drive.tally = int(real()) & 0xFF
        return drive.tally if drive.axis.state is State.ENABLED else real()

    readers[od.MODE_DISPLAY] = shown


def stop_unheard(drive: Drive) -> None:
    """NMT stop does not concern the drive."""
    node, axis = drive.node, drive.axis
    enter, lost = node._enter, axis.connection_lost

    def entered(state: NmtState, now: Ns) -> None:
        put(axis, connection_lost=lambda now: None)
        enter(state, now)
        put(axis, connection_lost=lost)

    put(node, _enter=entered)


def keeps_power(drive: Drive) -> None:
    """Reset node leaves operation enabled."""
    reset = drive.axis.reset
    put(drive.axis, reset=lambda now: None if drive.axis.state is State.ENABLED else reset(now))


def speed_reversed(drive: Drive) -> None:
    """606Ch and 60FFh count against 6064h in profile velocity."""
    readers, mode = drive.node.objects.readers, drive.axis.modes[3]
    real, value = readers[od.SPEED], mode.value
    readers[od.SPEED] = lambda: -int(real()) if _enabled(drive, 3) else real()
    put(mode, value=lambda key: -value(key) if key == od.TARGET_SPEED else value(key))


def other_code(drive: Drive) -> None:
    """603Fh is not the code of the emergency message."""
    readers, values = drive.node.objects.readers, drive.node.objects.values
    readers[od.ERROR_CODE] = lambda: 0x1000 if values[od.ERROR_CODE] else 0


def resumes(drive: Drive) -> None:
    """Profile position: an interrupted move continues when operation is enabled again."""
    mode = drive.axis.modes[1]
    assert isinstance(mode, ProfilePosition)
    enter = mode.enter

    def entered() -> None:
        under_way = hasattr(mode, "_reached") and not mode._reached
        enter()
        if under_way:
            mode._take(0x20)
            mode._acknowledged = False

    put(mode, enter=entered)


def no_limits_when_cyclic(drive: Drive) -> None:
    clip = drive.axis.clip
    put(drive.axis, clip=lambda position: position if drive.axis.mode.code == 8 else clip(position))


def no_lower_limit(drive: Drive) -> None:
    """Only the upper limit of 607Dh counts."""
    clip = drive.axis.clip
    put(drive.axis, clip=lambda position: position if position < drive.axis.position else clip(position))


def no_top_velocity(drive: Drive) -> None:
    """607Fh does not count in profile velocity."""
    mode = drive.axis.modes[3]
    real = mode.value
    put(mode, value=lambda key: 2**31 - 1 if key == od.MAX_PROFILE_SPEED else real(key))


# ---- correct drives
def own_units(drive: Drive) -> None:
    """Speeds and accelerations in another unit than 6064h a second."""
    axis, objects = drive.axis, drive.node.objects
    real, speed = axis.value, objects.readers[od.SPEED]
    objects.readers[od.SPEED] = lambda: round(int(speed()) / COARSE)
    for key in SPEEDS:
        objects.factory[key] = objects.whole(key) // COARSE
        objects.values[key] = objects.factory[key]

    def value(key: Key) -> int:
        return real(key) * COARSE if key in SPEEDS else real(key)

    put(axis, value=value)
    for mode in axis.modes.values():
        put(mode, value=value)


def shown_later(drive: Drive) -> None:
    """6061h follows 6060h after 80 ms."""
    objects = drive.node.objects
    real, act = objects.readers[od.MODE_DISPLAY], objects.written[od.MODE]
    before = [0]

    def written(value: Value) -> None:
        before[0], drive.tally = int(shown()), drive.now + SHOWN
        act(value)

    def shown() -> int:
        return before[0] if drive.now < drive.tally else int(real())

    objects.written[od.MODE] = written
    objects.readers[od.MODE_DISPLAY] = shown


def has_reference(drive: Drive) -> None:
    """An absolute encoder: homing is attained from the beginning."""
    drive.axis.place.homed = True


def changes_later() -> Drive:
    """6060h acts after 300 ms, and 6061h shows it then; a value already shown does not change."""

    def hears(drive: Drive, frame: Frame) -> Sequence[Frame]:
        if drive.tally and drive.now >= drive.tally:
            drive.tally = 0
            drive.axis._mode_written(drive.axis.value(od.MODE))
        return [frame]

    def tune(drive: Drive) -> None:
        axis, objects = drive.axis, drive.node.objects
        shown, choose = objects.readers[od.MODE_DISPLAY], axis._choose_mode

        def written(value: Value) -> None:
            drive.tally = 0 if value == shown() else drive.now + CHANGES

        objects.written[od.MODE] = written
        put(axis, _choose_mode=lambda: None if drive.tally else choose())

    return Drive(tune, hears=hears)


def mode_fixed_at_work(drive: Drive) -> None:
    """6060h is refused while operation is enabled."""
    objects = drive.node.objects
    check = objects.checks[od.MODE]
    objects.checks[od.MODE] = lambda value: Abort.DEVICE_STATE if drive.axis.state is State.ENABLED else check(value)


SLOW_BRAKE = DriveSettings(ServoSettings(boot_s=0.01, charge_s=0.0, brake_open_s=0.8, brake_close_s=0.4))
SMALLEST = (
    *(0x6007, 0x605A, 0x605B, 0x605C, 0x605D, 0x605E, 0x6062, 0x6063, 0x6065, 0x6066, 0x6067, 0x6068, 0x606B, 0x606C, 0x606D, 0x606E),
    *(0x606F, 0x6070, 0x6071, 0x607C, 0x607D, 0x607F, 0x6080, 0x6084, 0x6085, 0x6098, 0x6099, 0x609A, 0x60C1, 0x60C2, 0x60FF, 0x6502),
)
