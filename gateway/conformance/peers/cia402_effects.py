"""CiA 402: drives whose ramps, references, modes and windows are shown or accepted, but not in force (used by peers.cia402)."""

import itertools
from collections.abc import Callable, Sequence
from dataclasses import replace

from drivers.emulator.cia402 import objects as od
from drivers.emulator.cia402.modes import IMMEDIATELY, NEW_SET_POINT, RELATIVE, CyclicPosition, HomingMode, ProfilePosition
from drivers.emulator.cia402.states import TARGET, State
from gateway.conformance.peers.can_devices import NODE, Drive, Tune, put
from protocols.base.machine import Frame, ms
from protocols.canopen import cob_id as cobid
from protocols.canopen.dictionary import Access, Key

STEEP = 50_000_000  # inc/s2
INC_PER_TURN = 16_384
ERROR_REGISTER: Key = (0x1001, 0)


def in_mode(mode: int, key: Key, change: Callable[[int], int]) -> Tune:
    """The value of the object is interpreted differently in this mode."""

    def tune(drive: Drive) -> None:
        found = drive.axis.modes[mode]
        real = found.value
        put(found, value=lambda asked: change(real(asked)) if asked == key else real(asked))

    return tune


def relative_to_actual(drive: Drive) -> None:
    """A relative set-point counts from where the axis is."""
    mode = drive.axis.modes[1]
    assert isinstance(mode, ProfilePosition)
    take = mode._take

    def taken(word: int) -> None:
        if word & RELATIVE:
            mode._goal, mode._next = drive.axis.position, None
        take(word)

    put(mode, _take=taken)


def relative_queued_to_actual(drive: Drive) -> None:
    """The same for one that waits for the target under way."""
    mode = drive.axis.modes[1]
    assert isinstance(mode, ProfilePosition)
    take = mode._take

    def taken(word: int) -> None:
        goal = mode._goal
        if word & RELATIVE and not word & IMMEDIATELY:
            mode._goal = drive.axis.position
        take(word)
        if word & RELATIVE and not word & IMMEDIATELY and mode._next is not None:
            mode._goal = goal

    put(mode, _take=taken)


def set_point_by_level(drive: Drive) -> None:
    """Bit 4 that is written again counts again."""
    mode = drive.axis.modes[1]
    assert isinstance(mode, ProfilePosition)
    control = mode.control

    def heard(word: int, before: int) -> None:
        if word & NEW_SET_POINT:
            mode._acknowledged = False
        control(word, before & ~NEW_SET_POINT)

    put(mode, control=heard)


def moves_during_halt(drive: Drive) -> None:
    """A set-point ends halt."""
    axis = drive.axis
    halt = axis._halt

    def heard(word: int) -> None:
        halt(word & ~0x100 if word & NEW_SET_POINT and axis.mode.code == 1 else word)

    put(axis, _halt=heard)


def halt_unshown(drive: Drive) -> None:
    """Bit 10 stays clear during halt in profile position."""
    readers = drive.node.objects.readers
    word = readers[od.STATUSWORD]

    def shown() -> int:
        halted = drive.axis.state is State.ENABLED and drive.axis.mode.code == 1 and drive.axis.mode.halted
        return int(word()) & ~TARGET if halted else int(word())

    readers[od.STATUSWORD] = shown


def halt_unheard_in_homing(drive: Drive) -> None:
    axis = drive.axis
    halt = axis._halt
    put(axis, _halt=lambda word: halt(word & ~0x100 if axis.mode.code == 6 else word))


def mode_shown_only(drive: Drive) -> None:
    """6061h repeats 6060h, the mode changes without power only."""
    axis = drive.axis
    written = drive.node.objects.written
    change = written[od.MODE]
    written[od.MODE] = lambda value: None if axis.state is State.ENABLED else change(value)
    drive.node.objects.readers[od.MODE_DISPLAY] = lambda: axis.value(od.MODE)


def zero_at_reset(drive: Drive) -> None:
    """The position is 0 after a fault reset."""
    axis = drive.axis
    reset = axis._reset_fault

    def begun() -> None:
        reset()
        if axis.state is State.DISABLED:
            axis.place.shift = -int(axis.servo.counter_inc // 1.0)

    put(axis, _reset_fault=begun)


def other_sign(drive: Drive) -> None:
    """607Ch with the other sign."""
    axis = drive.axis

    def home(counter: int) -> None:
        axis.place.shift, axis.place.homed = -axis.value(od.HOME_OFFSET) - counter, True

    put(axis, set_home=home)


def absolute_offset(drive: Drive) -> None:
    """607Ch without its sign."""
    axis = drive.axis

    def home(counter: int) -> None:
        axis.place.shift, axis.place.homed = abs(axis.value(od.HOME_OFFSET)) - counter, True

    put(axis, set_home=home)


def homing_by_itself(drive: Drive) -> None:
    """Homing starts with operation enabled, without bit 4."""
    mode = drive.axis.modes[6]
    assert isinstance(mode, HomingMode)
    enter = mode.enter

    def entered() -> None:
        enter()
        mode._begin()

    put(mode, enter=entered)


def one_sync_late(drive: Drive) -> None:
    """In CSP a set value acts with the SYNC after the next one."""
    mode = drive.axis.modes[8]
    assert isinstance(mode, CyclicPosition)
    real, enter, sync = mode.value, mode.enter, mode.sync
    held: list[int] = []

    def entered() -> None:
        enter()
        held[:] = [int(drive.axis.position)]

    def synced(new: bool) -> None:
        acts, held[0] = held[0], real(od.TARGET_POSITION)
        put(mode, value=lambda key: acts if key == od.TARGET_POSITION else real(key))
        sync(new)

    put(mode, enter=entered, sync=synced)


def each_7th_lost(drive: Drive) -> None:
    """In CSP each seventh set value is lost."""
    mode, tally = drive.axis.modes[8], itertools.count(1)
    sync = mode.sync
    put(mode, sync=lambda new: sync(new) if next(tally) % 7 else None)


def register_stays(drive: Drive) -> None:
    """1001h keeps each error that it has shown."""
    readers, values = drive.node.objects.readers, drive.node.objects.values
    real = readers.get(ERROR_REGISTER, lambda: values[ERROR_REGISTER])

    def shown() -> int:
        drive.tally |= int(real())
        return drive.tally

    readers[ERROR_REGISTER] = shown


def coasts_in_position(drive: Drive) -> None:
    """605Ch counts as 0 in profile position."""
    axis = drive.axis
    leave = axis._leave
    put(axis, _leave=lambda option, state: leave(0 if axis.mode.code == 1 else option, state))


def steep_in_position(drive: Drive) -> None:
    """605Ah = 2 counts as 1 in profile position."""
    axis = drive.axis
    slope = axis._slope
    put(axis, _slope=lambda option: slope(1 if axis.mode.code == 1 and option == 2 else option))


def old_statusword(drive: Drive, frame: Frame) -> Sequence[Frame]:
    """TPDO 1 always holds the statusword of its first telegram."""
    if frame.identifier != cobid.tpdo(1, NODE):
        return [frame]
    drive.tally = drive.tally or int.from_bytes(frame.data[:2], "little")
    return [frame._replace(data=drive.tally.to_bytes(2, "little") + frame.data[2:])]


def own_period(drive: Drive) -> None:
    """60C2h may be written; in CSP a way takes 4 ms whatever it holds."""
    axis = drive.axis
    follow = axis.follow
    put(axis, follow=lambda position, time, speed: follow(position, ms(4) if axis.mode.code == 8 else time, speed))


def motor_speed(in_force: bool) -> Tune:
    """6080h may be written; correct where it is in force as well."""

    def tune(drive: Drive) -> None:
        objects = drive.node.objects
        sheet = objects.dictionary
        entry = replace(sheet.entries[od.MAX_MOTOR_RPM], access=Access.RW)
        objects.dictionary = replace(sheet, entries={**sheet.entries, od.MAX_MOTOR_RPM: entry})
        for number in (1, 3, 9) if in_force else ():
            mode = drive.axis.modes[number]
            put(mode, value=_bounded(drive, mode.value))

    return tune


def _bounded(drive: Drive, real: Callable[[Key], int]) -> Callable[[Key], int]:
    def value(key: Key) -> int:
        if key != od.MAX_PROFILE_SPEED:
            return real(key)
        return min(real(key), real(od.MAX_MOTOR_RPM) * INC_PER_TURN // 60)

    return value
