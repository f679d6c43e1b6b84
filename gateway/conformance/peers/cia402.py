"""CiA 402: axisgate's emulated drive with one fault each in its drive half, and correct drives unlike it."""

from collections.abc import Callable, Sequence

from drivers.emulator.cia402 import objects as od
from drivers.emulator.cia402.errors import Error
from drivers.emulator.cia402.states import BIT12, BIT13, TARGET, State
from drivers.emulator.servo.settings import DriveSettings, ServoSettings
from gateway.conformance.peers.can_devices import NODE, QUICK, Drive, Says, Tune, put
from gateway.conformance.peers.canopen301_frames import chatty, deaf, on
from gateway.conformance.peers.canopen301_parts import Late
from gateway.conformance.peers.canopen301_states import never_says_gone
from gateway.conformance.peers.cia402_effects import (
    STEEP,
    absolute_offset,
    coasts_in_position,
    each_7th_lost,
    halt_unheard_in_homing,
    halt_unshown,
    homing_by_itself,
    in_mode,
    mode_shown_only,
    motor_speed,
    moves_during_halt,
    old_statusword,
    one_sync_late,
    other_sign,
    own_period,
    register_stays,
    relative_queued_to_actual,
    relative_to_actual,
    set_point_by_level,
    steep_in_position,
    zero_at_reset,
)
from gateway.conformance.peers.cia402_states import (
    SLOW_BRAKE,
    SMALLEST,
    changes_later,
    display_frozen,
    has_reference,
    keeps_power,
    mode_fixed_at_work,
    no_limits_when_cyclic,
    no_lower_limit,
    no_search,
    no_top_velocity,
    other_code,
    own_units,
    resumes,
    shown_later,
    speed_reversed,
    stop_unheard,
)
from gateway.conformance.peers.stations import Mutant, Variant
from protocols.base.machine import Frame, Ns, ms
from protocols.canopen import cob_id as cobid
from protocols.canopen.dictionary import Key
from protocols.canopen.types import Value

LINK: dict[str, object] = {"node": NODE}
Row = tuple[str, str, tuple[str, ...], Callable[[], object]]


def _row(name: str, what: str, expects: str, tune: Tune | None = None, says: Says | None = None, hears: Says | None = None) -> Row:
    return name, what, tuple(f"CIA402_{one}" for one in expects.split()), lambda: Drive(tune, says, hears)


# ---- parts
def _status(change: Callable[[Drive, int], int]) -> Tune:
    """Another statusword."""

    def tune(drive: Drive) -> None:
        readers = drive.node.objects.readers
        before = readers[od.STATUSWORD]
        readers[od.STATUSWORD] = lambda: change(drive, int(before()))

    return tune


def _bit(mode: int, clear: int = 0, put_in: int = 0) -> Tune:
    """Bits of the statusword while this mode works."""

    def change(drive: Drive, word: int) -> int:
        works = drive.axis.state is State.ENABLED and drive.axis.mode.code == mode
        return word & ~clear | put_in if works else word

    return _status(change)


def _words(change: Callable[[Drive, int], int | None]) -> Tune:
    """The controlword it receives is another; None: not received."""

    def tune(drive: Drive) -> None:
        written = drive.node.objects.written
        act = written[od.CONTROLWORD]

        def heard(value: Value) -> None:
            found = change(drive, value if isinstance(value, int) else 0)
            if found is not None:
                act(found)

        written[od.CONTROLWORD] = heard

    return tune


def _deaf_in(state: State, word: int) -> Tune:
    """This controlword does nothing in this state."""
    return _words(lambda drive, heard: None if heard & 0xFF == word and drive.axis.state is state else heard)


def _jumps(state: State, word: int, to: State) -> Tune:
    """This controlword leads to a wrong state."""

    def change(drive: Drive, heard: int) -> int | None:
        if heard != word or drive.axis.state is not state:
            return heard
        drive.axis.state = to
        return None

    return _words(change)


def _mask(clear: int = 0, put_in: int = 0) -> Tune:
    return _words(lambda drive, heard: heard & ~clear | put_in if drive.axis.state is State.ENABLED else heard)


def _keeps_set_point(drive: Drive) -> None:
    """Bit 4 without power counts when the drive is enabled."""
    mode, kept = drive.axis.modes[1], list[int]()
    enter = mode.enter

    def remembers(drive: Drive, word: int) -> int:
        if word & 0x10 and drive.axis.state is State.ON:
            kept.append(word)
        return word

    def entered() -> None:
        enter()
        if kept:
            kept.clear()
            mode.control(0x1F, 0x0F)

    put(mode, enter=entered)
    _words(remembers)(drive)


def _value(key: Key, change: Callable[[int], int]) -> Tune:
    """The value of the object is interpreted differently."""

    def tune(drive: Drive) -> None:
        axis = drive.axis
        real = axis.value

        def value(asked: Key) -> int:
            return change(real(asked)) if asked == key else real(asked)

        put(axis, value=value)
        for mode in axis.modes.values():
            put(mode, value=value)

    return tune


def _as(key: Key, reported: int, acts: int) -> Tune:
    """An option code acts like another one."""
    return _value(key, lambda value: acts if value == reported else value)


def _level_reset(drive: Drive) -> None:
    """Bit 7 resets without an edge."""
    written = drive.node.objects.written
    act = written[od.CONTROLWORD]

    def heard(value: Value) -> None:
        if drive.axis.state is State.FAULT:
            drive.axis.controlword = 0
        act(value)

    written[od.CONTROLWORD] = heard


def _code_stays(drive: Drive) -> None:
    axis = drive.axis
    reset = axis._reset_fault

    def kept() -> None:
        code = axis.value(od.ERROR_CODE)
        reset()
        axis.objects.values[od.ERROR_CODE] = code

    put(axis, _reset_fault=kept)


def _any_mode(drive: Drive) -> None:
    drive.unchecked(od.MODE)
    drive.node.objects.readers[od.MODE_DISPLAY] = lambda: drive.axis.value(od.MODE)


def _no_edge(drive: Drive) -> None:
    """A new 607Ah moves at once in profile position."""

    def written(value: Value) -> None:
        if drive.axis.mode.code == 1:
            drive.axis.mode.control(0x3F, 0x0F)

    drive.node.objects.written[od.TARGET_POSITION] = written


def _no_clip(drive: Drive) -> None:
    put(drive.axis, clip=lambda position: position)


def _at_once(drive: Drive) -> None:
    """CSP: a set value acts when it comes, though its RPDO waits for SYNC."""
    for pdo in range(4):
        if (0x1400 + pdo, 2) in drive.node.objects.values:
            drive.node.objects.values[0x1400 + pdo, 2] = drive.node.objects.factory[0x1400 + pdo, 2] = 1

    def written(value: Value) -> None:
        if drive.axis.mode.code == 8 and isinstance(value, int):
            drive.axis.follow(float(value), 1_000_000, 0.0)

    drive.node.objects.written[od.TARGET_POSITION] = written


def _no_offset(drive: Drive) -> None:
    axis = drive.axis

    def home(counter: int) -> None:
        axis.place.shift, axis.place.homed = -counter, True

    put(axis, set_home=home)


def _no_window(drive: Drive) -> None:
    put(drive.axis, _window=lambda: None)


def _emcy_code(before: int, after: int) -> Says:
    def change(drive: Drive, frame: Frame) -> Sequence[Frame]:
        is_it = int.from_bytes(frame.data[:2], "little") == before
        return [frame._replace(data=after.to_bytes(2, "little") + frame.data[2:])] if is_it else [frame]

    return on(cobid.emcy(NODE), change)


class StartsItself(Drive):
    """Enabled again when its supply returns."""

    def power(self, on: bool, now: Ns) -> None:
        super().power(on, now)
        self.tally = 1


S = State
ROWS: tuple[Row, ...] = (
    (
        "starts-itself",
        "is enabled when its supply returns",
        ("CIA402_SUP_RC_01",),
        lambda: StartsItself(_status(lambda drive, word: 0x0637 if drive.tally and drive.axis.state is not State.ENABLED else word)),
    ),
    _row("never-boots", "never leaves not ready to switch on", "PWR_BV_01", _status(lambda drive, word: 0)),
    _row(
        "boots-ready",
        "is ready to switch on after boot-up",
        "PWR_BV_01",
        _status(lambda drive, word: 0x21 if word & 0x4F == 0x40 else word),
    ),
    _row("never-says-gone", "no EMCY 0000h", "FLT_BV_11", says=never_says_gone),
    _row("no-shutdown", "no transition 2", "PWR_BV_02", _deaf_in(S.DISABLED, 6)),
    _row("no-switch-on", "no transition 3", "PWR_BV_03", _deaf_in(S.READY, 7)),
    _row("no-enable", "no transition 4", "PWR_BV_04", _deaf_in(S.ON, 15)),
    _row("no-disable", "no transition 5", "PWR_BV_05", _deaf_in(S.ENABLED, 7)),
    _row("no-shutdown-from-on", "no transition 6", "PWR_BV_06", _deaf_in(S.ON, 6)),
    _row("no-voltage-ready", "disable voltage does nothing when ready", "PWR_BV_07", _deaf_in(S.READY, 0)),
    _row("no-quick-ready", "quick stop does nothing when ready", "PWR_BV_08", _deaf_in(S.READY, 2)),
    _row("no-shutdown-enabled", "no transition 8", "PWR_BV_09", _deaf_in(S.ENABLED, 6)),
    _row("no-voltage-enabled", "no transition 9", "PWR_BV_10", _deaf_in(S.ENABLED, 0)),
    _row("no-voltage-on", "disable voltage does nothing when switched on", "PWR_BV_11", _deaf_in(S.ON, 0)),
    _row("no-quick-on", "quick stop does nothing when switched on", "PWR_BV_12", _deaf_in(S.ON, 2)),
    _row("no-quick-stop", "no transition 11", "PWR_BV_13", _deaf_in(S.ENABLED, 2)),
    _row("switch-on-anywhere", "switch on acts in switch on disabled", "PWR_BI_01", _jumps(S.DISABLED, 7, S.ON)),
    _row("enable-anywhere", "enable operation acts in switch on disabled", "PWR_BI_02", _jumps(S.DISABLED, 15, S.READY)),
    _row("reset-disables", "a fault reset leads out of ready", "PWR_BI_03", _jumps(S.READY, 0x86, S.DISABLED)),
    _row("reset-disables-on", "a fault reset leads out of switched on", "PWR_BI_04", _jumps(S.ON, 0x87, S.READY)),
    _row("quick-stop-leaves", "605Ah = 6 acts like 2", "PWR_BV_14 PWR_BV_15", _as(od.QUICK_STOP_OPTION, 6, 2)),
    _row("no-way-back", "no transition 16", "PWR_BV_14", _deaf_in(S.QUICK_STOP, 15)),
    _row("no-way-out", "no transition 12", "PWR_BV_15", _deaf_in(S.QUICK_STOP, 0)),
    _row("not-supervised", "does not hear the master's heartbeat", "FLT_BV_01", hears=deaf(0x700 + 126)),
    _row("no-fault-emcy", "no emergency in fault", "FLT_BV_01", says=deaf(cobid.emcy(NODE))),
    _row("no-error-code", "603Fh is always 0", "FLT_BV_01", lambda drive: drive.fixed(od.ERROR_CODE, 0)),
    _row("no-reset", "a fault cannot be reset", "FLT_BV_02", _deaf_in(S.FAULT, 0x80)),
    _row("level-reset", "bit 7 resets without an edge", "FLT_BI_02", _level_reset),
    _row("any-command-resets", "disable voltage resets a fault", "FLT_BI_01", _jumps(S.FAULT, 0, S.DISABLED)),
    _row("code-stays", "603Fh stays after the reset", "FLT_BV_02", _code_stays),
    _row("always-fault", "6007h = 0 acts like 1", "FLT_BV_03", _as(od.ABORT_CONNECTION, 0, 1)),
    _row("no-disable-voltage", "6007h = 2 acts like 0", "FLT_BV_04", _as(od.ABORT_CONNECTION, 2, 0)),
    _row("no-abort-stop", "6007h = 3 acts like 1", "FLT_BV_05", _as(od.ABORT_CONNECTION, 3, 1)),
    _row("no-following-error", "no fault however far it lags", "FLT_BV_07", _no_window),
    _row("following-code", "another emergency for a following error", "FLT_BV_07", says=_emcy_code(Error.FOLLOWING, 0x8600)),
    _row("display-fixed", "6061h is always 8", "MOD_BV_01", lambda drive: drive.fixed(od.MODE_DISPLAY, 8)),
    _row("any-mode", "shows any mode", "MOD_BI_01", _any_mode),
    _row("no-acknowledge", "bit 12 never acknowledges a set-point", "POS_BV_01", _bit(1, clear=BIT12)),
    _row("acknowledge-stays", "bit 12 is always set", "POS_BV_01", _bit(1, put_in=BIT12)),
    _row("reached-always", "bit 10 is always set", "POS_BV_02", _bit(1, put_in=TARGET)),
    _row("reached-never", "bit 10 is never set", "POS_BV_02", _bit(1, clear=TARGET)),
    _row("relative-absolute", "bit 6 does not count", "POS_BV_03", _mask(clear=0x40)),
    _row("never-immediate", "bit 5 does not count", "POS_BV_04", _mask(clear=0x20)),
    _row("always-immediate", "every set-point counts at once", "POS_BV_05", _mask(put_in=0x20)),
    _row("halt-ignored", "bit 8 does not count", "POS_BV_06 OPT_BV_05", _mask(clear=0x100)),
    _row("no-edge", "a new target moves without bit 4", "POS_BI_01", _no_edge),
    _row("too-fast", "twice as fast as 6081h", "POS_BV_07", _value(od.PROFILE_SPEED, lambda value: 2 * value)),
    _row("too-slow", "a third of 6081h", "POS_BV_07", _value(od.PROFILE_SPEED, lambda value: value // 3)),
    _row("keeps-set-point", "a set-point without power is carried out when it is enabled", "POS_BO_02", _keeps_set_point),
    _row("no-limits", "607Dh does not count", "POS_BI_02", _no_clip),
    _row("slow-velocity", "four fifths of 60FFh", "VEL_BV_01", _value(od.TARGET_SPEED, lambda value: value * 4 // 5)),
    _row("no-reverse", "never turns backwards", "VEL_BV_01", _value(od.TARGET_SPEED, abs)),
    _row("speed-reached-never", "bit 10 is never set in profile velocity", "VEL_BV_01", _bit(3, clear=TARGET)),
    _row("no-ramps", "6083h does not count", "VEL_BV_02", _value(od.ACCELERATION, lambda value: 50_000_000)),
    _row("slow-ramps", "a third of 6084h", "VEL_BV_02 OPT_BV_01", _value(od.DECELERATION, lambda value: value // 3)),
    _row("still-never", "bit 12 never shows standstill", "VEL_BV_03", _bit(3, clear=BIT12)),
    _row("still-always", "bit 12 always shows standstill", "VEL_BV_03", _bit(3, put_in=BIT12)),
    _row("quick-1-as-2", "605Ah = 1 acts like 2", "OPT_BV_01", _as(od.QUICK_STOP_OPTION, 1, 2)),
    _row("quick-2-as-1", "605Ah = 2 acts like 1", "OPT_BV_02", _as(od.QUICK_STOP_OPTION, 2, 1)),
    _row("shutdown-1-as-0", "605Bh = 1 acts like 0", "OPT_BV_03", _as(od.SHUTDOWN_OPTION, 1, 0)),
    _row("disable-1-as-0", "605Ch = 1 acts like 0", "OPT_BV_04", _as(od.DISABLE_OPTION, 1, 0)),
    _row("halt-1-as-2", "605Dh = 1 acts like 2", "OPT_BV_05", _as(od.HALT_OPTION, 1, 2)),
    _row("halt-2-as-1", "605Dh = 2 acts like 1", "OPT_BV_06", _as(od.HALT_OPTION, 2, 1)),
    _row("quick-0-as-1", "605Ah = 0 waits for standstill", "OPT_BV_07", _value(od.QUICK_STOP_OPTION, lambda value: value or 1)),
    _row("fault-2-as-1", "605Eh = 2 acts like 1", "OPT_BV_08", _as(od.FAULT_OPTION, 2, 1)),
    _row("disable-0-as-1", "605Ch = 0 acts like 1", "OPT_BV_09", _as(od.DISABLE_OPTION, 0, 1)),
    _row("offset-ignored", "607Ch does not count", "HOM_BV_01", _no_offset),
    _row("never-attained", "bit 12 is never set by homing", "HOM_BV_01", _bit(6, clear=BIT12)),
    _row("always-attained", "bit 12 is always set in homing", "HOM_BV_02 HOM_BO_01", _bit(6, put_in=BIT12)),
    _row("no-homing-error", "bit 13 is never set", "HOM_BI_01", _bit(6, clear=BIT13)),
    _row("no-sync", "does not hear SYNC", "CSP_BV_01", hears=deaf(cobid.SYNC)),
    _row("at-once", "set values do not wait for SYNC", "CSP_BO_01", _at_once),
    _row("half-way", "goes half the way in CSP", "CSP_BV_01", _value(od.TARGET_POSITION, lambda value: value // 2)),
    _row("quick-5-as-1", "605Ah = 5 acts like 1", "PWR_BV_16", _as(od.QUICK_STOP_OPTION, 5, 1)),
    _row("deaf-rpdo", "does not hear RPDO 1", "PWR_BV_17", hears=deaf(cobid.rpdo(1, NODE))),
    _row("keeps-power", "reset node leaves operation enabled", "PWR_BV_18", keeps_power),
    _row("stop-unheard", "NMT stop does not concern the drive", "FLT_BV_08", stop_unheard),
    _row("other-code", "603Fh is not the code of the emergency", "FLT_BV_09", other_code),
    _row("reset-makes-ready", "a fault reset with 008Fh makes ready as well", "FLT_BI_03", _jumps(S.FAULT, 0x8F, S.READY)),
    _row("display-frozen", "6061h does not change while enabled", "MOD_BV_02", display_frozen),
    _row("no-top-speed", "607Fh does not count", "POS_BV_08", _value(od.MAX_PROFILE_SPEED, lambda value: 2**31 - 1)),
    _row("resumes", "goes on when enabled again", "POS_BO_01", resumes),
    (
        "no-halt-in-velocity",
        "bit 8 does not count in profile velocity, 605Dh is missing",
        ("CIA402_VEL_BV_04",),
        lambda: Drive(_words(lambda drive, word: word & ~0x100 if drive.axis.mode.code == 3 else word), lacks=(0x605D,)),
    ),
    _row("speed-reversed", "606Ch counts against 6064h", "VEL_BV_05", speed_reversed),
    _row("speed-reached-always", "bit 10 is always set in profile velocity", "VEL_BV_06", _bit(3, put_in=TARGET)),
    _row("no-search", "attains homing without a search", "HOM_BV_03", no_search),
    _row("no-limits-when-cyclic", "607Dh does not count in CSP", "CSP_BI_01", no_limits_when_cyclic),
    _row("no-follow-bit", "bit 12 is clear in CSP", "CSP_BV_02", _bit(8, clear=BIT12)),
    _row("no-lower-limit", "607Dh:01 does not count", "POS_BI_03 CSP_BI_02", no_lower_limit),
    _row("fast-velocity", "607Fh does not count in profile velocity", "VEL_BV_07", no_top_velocity),
    _row("quick-5-as-6", "605Ah = 5 acts like 6", "OPT_BV_10", _as(od.QUICK_STOP_OPTION, 5, 6)),
    _row("quick-6-as-5", "605Ah = 6 acts like 5", "OPT_BV_11", _as(od.QUICK_STOP_OPTION, 6, 5)),
    _row("lag-at-once", "6066h does not count", "FLT_BI_04", _value(od.FOLLOWING_TIME, lambda value: 0)),
    _row("no-ramp-up", "6083h does not count in profile position", "POS_BV_09", in_mode(1, od.ACCELERATION, lambda value: STEEP)),
    _row("no-ramp-down", "6084h does not count in profile position", "POS_BV_10", in_mode(1, od.DECELERATION, lambda value: STEEP)),
    _row("relative-to-actual", "relative set-points count from the actual position", "POS_BV_11", relative_to_actual),
    _row("relative-queued", "waiting relative set-points count from the actual position", "POS_BV_11", relative_queued_to_actual),
    _row("halt-unshown", "bit 10 is clear during halt", "POS_BV_12", halt_unshown),
    _row("moves-during-halt", "a set-point ends halt", "POS_BO_03", moves_during_halt),
    _row("set-point-by-level", "bit 4 that stays set counts again", "POS_BI_04", set_point_by_level),
    _row("no-window-time", "6068h does not count", "POS_BV_13", in_mode(1, od.POSITION_TIME, lambda value: 0)),
    _row("mode-shown-only", "6061h shows a mode that is not in force", "MOD_BV_03", mode_shown_only),
    _row("zero-at-reset", "6064h is 0 after a fault reset", "FLT_BV_10", zero_at_reset),
    _row("window-fixed", "6065h does not count", "FLT_BI_05", _value(od.FOLLOWING_WINDOW, lambda value: 400)),
    _row("no-motor-speed", "6080h may be written and does not count", "VEL_BV_08", motor_speed(False)),
    _row("shutdown-0-as-1", "605Bh = 0 acts like 1", "OPT_BV_12", _as(od.SHUTDOWN_OPTION, 0, 1)),
    _row("fault-1-as-2", "605Eh = 1 acts like 2", "OPT_BV_13", _as(od.FAULT_OPTION, 1, 2)),
    _row("fault-0-as-1", "605Eh = 0 acts like 1", "OPT_BV_14", _as(od.FAULT_OPTION, 0, 1)),
    _row("offset-reversed", "607Ch counts with the other sign", "HOM_BV_01", other_sign),
    _row("offset-unsigned", "607Ch has no sign", "HOM_BV_01", absolute_offset),
    (
        "no-speed-of-a-position",
        "offers profile position without 6081h",
        ("CIA402_MOD_BV_04",),
        lambda: Drive(lacks=(0x6081,)),
    ),
    (
        "fault-reset-by-level",
        "bit 7 counts as a level, and 6007h and 6066h are missing",
        ("CIA402_FLT_BI_02",),
        lambda: Drive(_level_reset, lacks=(0x6007, 0x6066)),
    ),
    _row("homing-by-itself", "homing starts without bit 4", "HOM_BO_03", homing_by_itself),
    _row("one-sync-late", "set values act one SYNC late in CSP", "CSP_BV_03", one_sync_late),
    _row("each-7th-lost", "each seventh set value is lost in CSP", "CSP_BV_04", each_7th_lost),
    _row("register-stays", "1001h stays set after a fault reset", "FLT_BV_11", register_stays),
    _row("coasts-in-position", "605Ch does not count in profile position", "OPT_BV_16", coasts_in_position),
    _row("steep-in-position", "605Ah = 2 acts like 1 in profile position", "OPT_BV_15", steep_in_position),
    _row("old-statusword", "the statusword in TPDO 1 never changes", "PWR_BV_19", says=old_statusword),
    _row(
        "no-stop-in-homing",
        "quick stop does nothing in homing",
        "HOM_BO_04",
        _words(lambda drive, word: None if drive.axis.mode.code == 6 and word & 7 == 2 else word),
    ),
    _row("own-period", "60C2h may be written and does not count", "CSP_BV_04", own_period),
    _row("homing-goes-on", "bit 8 does not count in homing", "HOM_BO_02", halt_unheard_in_homing),
)
MUTANTS = tuple(Mutant(name, what, expects, make, LINK, {}) for name, what, expects, make in ROWS)


def _good(name: str, what: str, make: Callable[[], object], **pics: object) -> Variant:
    return Variant(name, what, make, LINK, dict(pics))


VARIANTS = (
    _good("plain", "offers everything", Drive),
    _good("slow", "SDO answers after 5 ms", lambda: Late(ms(5))),
    _good("chatty", "another node speaks as well", lambda: Drive(says=chatty)),
    _good("slow-boot", "needs a second to boot", lambda: Drive(settings=DriveSettings(ServoSettings(boot_s=1.0, charge_s=0.3)))),
    _good("no-brake", "no brake", lambda: Drive(settings=DriveSettings(ServoSettings(boot_s=0.01, charge_s=0.0, brake=False)))),
    _good("no-options", "no option codes", lambda: Drive(lacks=(0x605A, 0x605B, 0x605C, 0x605D, 0x605E, 0x6007))),
    _good("no-6066", "no 6066h, 607Ch, 6085h", lambda: Drive(lacks=(0x6066, 0x607C, 0x6085))),
    _good("no-limits", "no software limits", lambda: Drive(lacks=(0x607D,))),
    _good("positions-only", "declares profile position only", Drive, pv=False, hm=False, csp=False),
    _good("elsewhere", "begins at 40 rad", lambda: Drive(settings=DriveSettings(ServoSettings(boot_s=0.01, start_rad=40.0)))),
    _good("smallest", "profile position with what it needs, no 606Ch", lambda: Drive(lacks=SMALLEST), pp=True),
    Variant("own-units", "speeds in another unit than positions", lambda: Drive(own_units), LINK | {"way": 8000}, {}),
    _good("shown-later", "6061h follows after 80 ms", lambda: Drive(shown_later)),
    _good("changes-later", "6061h and what acts follow 6060h after 300 ms", changes_later),
    _good("busy", "SDO answers after 30 ms", lambda: Late(ms(30))),
    _good("has-reference", "an absolute encoder", lambda: Drive(has_reference)),
    _good("slow-brake", "its brake needs 0.8 s", lambda: Drive(settings=SLOW_BRAKE)),
    _good("no-6502", "6502h is missing", lambda: Drive(lacks=(0x6502,)), pp=True, pv=True, hm=True, csp=True),
    _good("motor-speed", "6080h may be written", lambda: Drive(motor_speed(True))),
    _good("mode-fixed-at-work", "no other mode while enabled", lambda: Drive(mode_fixed_at_work)),
    _good("heavy", "five times the load", lambda: Drive(settings=DriveSettings(QUICK.__class__(boot_s=0.01, load_inertia_kgm2=0.006)))),
)
