"""SERVODYN: axisgate's emulated booster with one fault each, and correct boosters unlike it."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

from drivers.emulator.servo.settings import ServoSettings
from drivers.emulator.servodyn.axis import Fault, State
from gateway.conformance.peers import servodyn_phase as phase
from gateway.conformance.peers.boosters import CYCLE_MS, QUICK, ActualChange, Answered, Booster, Heard, Late, Raw, Tune, codec
from gateway.conformance.peers.stations import Mutant, Variant
from protocols.base.machine import Frame, Ns, ms
from protocols.servodyn.codec import ActualValue, SetValue
from protocols.servodyn.parameters import Answer, Status
from protocols.servodyn.plan import SYNC_ID

LINK: dict[str, object] = {"cycle_ms": CYCLE_MS}
CYCLE: Ns = ms(CYCLE_MS)
PAUSE: Ns = ms(20)
Row = tuple[str, str, tuple[str, ...], Callable[[], object]]
ACT, SET = codec().actual_id(1), codec().set_id(1)


def _row(name: str, what: str, expects: str, make: Callable[[], object]) -> Row:
    return name, what, tuple(f"SERVO_{one}" for one in expects.split()), make


def _reports(name: str, what: str, expects: str, change: ActualChange) -> Row:
    return _row(name, what, expects, lambda: Booster(change))


def _heard(name: str, what: str, expects: str, heard: Heard) -> Row:
    return _row(name, what, expects, lambda: Booster(sets=heard))


def _says(name: str, what: str, expects: str, says: Raw) -> Row:
    return _row(name, what, expects, lambda: Booster(out=says))


def _hears(name: str, what: str, expects: str, hears: Raw) -> Row:
    return _row(name, what, expects, lambda: Booster(into=hears))


def _answers(name: str, what: str, expects: str, answered: Answered) -> Row:
    return _row(name, what, expects, lambda: Booster(answered=answered))


def _tuned(name: str, what: str, expects: str, tune: Tune) -> Row:
    return _row(name, what, expects, lambda: Booster(tune=tune))


def _servo(**changes: Any) -> Callable[[], object]:
    settings: ServoSettings = replace(QUICK, **changes)
    return lambda: Booster(settings=settings)


def _always(**bits: Any) -> ActualChange:
    return lambda booster, value: value._replace(**bits)


def _only_actual(change: Callable[[Booster, Frame], Sequence[Frame]]) -> Raw:
    return lambda booster, frame: change(booster, frame) if frame.identifier == ACT else [frame]


# ---- parts
def _every(count: int) -> ActualChange:
    """One in so many actual values is lost."""

    def each(booster: Booster, value: ActualValue) -> ActualValue | None:
        booster.tally += 1
        return None if booster.tally % count == 0 else value

    return each


def _zero_at_control(booster: Booster, value: ActualValue) -> ActualValue:
    """It counts from where control began."""
    if value.enabled and not (booster.kept and booster.kept.enabled):
        booster.tally = value.position_inc
    booster.kept = value
    return value._replace(position_inc=value.position_inc - booster.tally)


def _not_by_itself(booster: Booster, frame: Frame) -> Sequence[Frame]:
    """A fault is reported with the next SYNC only."""
    return [frame] if booster.tally == booster.now else []


def _marks_sync(booster: Booster, frame: Frame) -> Sequence[Frame]:
    if frame.identifier == SYNC_ID:
        booster.tally = booster.now
    return [frame]


def _supervision(cycles: float) -> Tune:
    def tune(booster: Booster) -> None:
        booster.slave.supervision_ns = round(cycles * CYCLE)

    return tune


def _also_idle(booster: Booster, frame: Frame) -> Sequence[Frame]:
    """A set value is answered as well."""
    if frame.identifier == SET and len(frame.data) == 8:
        seat = booster.slave._seats[0]
        booster.slave._send(seat, seat.axis.actual())
    return [frame]


def _fills_up(booster: Booster, frame: Frame) -> Sequence[Frame]:
    return [frame._replace(data=frame.data.ljust(8, b"\0"))] if frame.identifier == SET else [frame]


def _any_module(booster: Booster, frame: Frame) -> Sequence[Frame]:
    return [frame._replace(identifier=SET)] if frame.identifier in range(210, 261, 10) else [frame]


def _enable_is_on(booster: Booster, value: SetValue) -> SetValue:
    return value._replace(drive_on=value.drive_on or value.enable)


def _on_is_enable(booster: Booster, value: SetValue) -> SetValue:
    return value._replace(enable=value.enable or value.drive_on)


def _latches(name: str) -> Heard:
    """A bit once set stays set."""

    def heard(booster: Booster, value: SetValue) -> SetValue:
        booster.tally = booster.tally or int(getattr(value, name))
        return value._replace(**{name: bool(booster.tally)})

    return heard


def _life_counts(booster: Booster, value: SetValue) -> SetValue:
    booster.tally += 1
    return value._replace(life=booster.tally & 0xFF)


def _half(booster: Booster, value: SetValue) -> SetValue:
    if booster.kept is None or not value.enable:
        booster.tally = value.position_inc
        booster.kept = None if not value.enable else booster.axis.actual()
    return value._replace(position_inc=booster.tally + (value.position_inc - booster.tally) // 2)


def _forwards_only(booster: Booster, value: SetValue) -> SetValue:
    if not value.enable:
        booster.tally = value.position_inc
    booster.tally = max(booster.tally, value.position_inc)
    return value._replace(position_inc=booster.tally)


def _no_jump(booster: Booster) -> None:
    """Goes wherever it is sent, with a window without end."""
    booster.axis.settings = booster.axis.parameters.factory = replace(booster.axis.settings, following_error_rad=9000.0)
    booster.axis.servo.retune(booster.axis.settings)


def _frozen(booster: Booster, value: ActualValue) -> ActualValue:
    booster.kept = booster.kept or value
    return value._replace(position_inc=booster.kept.position_inc)


def _drifts(booster: Booster, value: ActualValue) -> ActualValue:
    booster.tally += 3
    return value._replace(position_inc=value.position_inc + booster.tally)


def _reset_by_level(booster: Booster, value: SetValue) -> SetValue:
    if booster.axis.state is State.FAULT and value.fault_reset:
        booster.axis.commanded.value = booster.axis.commanded.value._replace(fault_reset=False)
    return value


def _reset_by_itself(booster: Booster, value: SetValue) -> SetValue:
    if booster.axis.state is State.FAULT:
        booster.axis._reset()
    return value


def _reset_by_off(booster: Booster, value: SetValue) -> SetValue:
    if booster.axis.state is State.FAULT and not value.drive_on:
        booster.axis._reset()
    return value


def _brake_by_request(booster: Booster, value: ActualValue) -> ActualValue:
    return value._replace(brake_open=value.brake_open or booster.axis.commanded.value.brake_open)


def _brake_in_fault(booster: Booster, value: ActualValue) -> ActualValue:
    return value._replace(brake_open=value.brake_open or value.fault)


def _own_codes(booster: Booster, value: ActualValue) -> ActualValue:
    return value._replace(fault_code=value.fault_code + 100 if value.fault_code else 0)


def _takes(status: Status) -> Answered:
    """Reports this status' refusal as accepted."""
    return lambda booster, answer: answer._replace(status=Status.TAKEN) if answer.status is status else answer


def _no_sequence(booster: Booster, answer: Answer) -> Answer:
    return answer._replace(sequence=answer.sequence if answer.number == 56 else 0)


def _restarts(booster: Booster, value: SetValue) -> SetValue:
    booster.axis.commanded.may_switch_on = True
    return value


def _never_resets(booster: Booster, value: SetValue) -> SetValue:
    return value._replace(fault_reset=False)


def _idle_is_fault(booster: Booster, frame: Frame) -> Sequence[Frame]:
    if frame.identifier == SYNC_ID:
        if booster.axis.state is State.READY and booster.now - booster.last_sync > 3 * CYCLE:
            booster.axis.fail(Fault.SYNC_LOST)
            booster.axis.faulted_at.clear()
        booster.last_sync = booster.now
    return [frame]


def _keeps_on(booster: Booster) -> None:
    """A lost SYNC does not stop it."""
    booster.slave.supervision_ns = 1 << 60


def _wrong_way(booster: Booster, value: SetValue) -> SetValue:
    if not value.enable:
        booster.tally = value.position_inc
    return value._replace(position_inc=2 * booster.tally - value.position_inc)


def _no_set_value(booster: Booster, frame: Frame) -> Sequence[Frame]:
    """A SYNC without a set value since the last one: enable counts as cleared."""
    if frame.identifier == SET:
        booster.tally = 1
    elif frame.identifier == SYNC_ID:
        if not booster.tally and booster.axis.state is State.ENABLED:
            booster.axis._stop()
        booster.tally = 0
    return [frame]


def _dead_after(count: int) -> Raw:
    def hears(booster: Booster, frame: Frame) -> Sequence[Frame]:
        if frame.identifier == SYNC_ID:
            booster.tally = booster.tally + 1 if booster.now - booster.last_sync < PAUSE else 1
            booster.last_sync = booster.now
        return [frame] if booster.tally < count else []

    return hears


class SelfStarting(Booster):
    """Drive on counts at once when its supply returns."""

    def power(self, on: bool, now: Ns) -> None:
        super().power(on, now)
        self.axis.commanded.may_switch_on = True
        self.axis.commanded.value = SetValue()


class ReportsLate(Booster):
    """A fault is reported with the next SYNC only."""

    def __init__(self) -> None:
        super().__init__(out=_only_actual(_not_by_itself), into=_marks_sync)


def _fifteen_bits(booster: Booster, value: ActualValue) -> ActualValue:
    return value._replace(position_inc=((value.position_inc + 0x8000) & 0xFFFF) - 0x8000)


class SpeaksWithoutSupply(Booster):
    """Its logic has another supply: it sends on."""

    def power(self, on: bool, now: Ns) -> None:
        """Nothing happens."""


ROWS: tuple[Row, ...] = (
    _hears("silent", "never answers", "CYC_BV_01", lambda booster, frame: []),
    _says("seven-bytes", "actual values of seven bytes", "CYC_BV_01", _only_actual(lambda b, f: [f._replace(data=f.data[:7])])),
    _says("twice", "two actual values for a SYNC", "CYC_BV_01", _only_actual(lambda booster, frame: [frame, frame])),
    _says("other-module", "sends as module 2", "CYC_BV_01", _only_actual(lambda b, f: [f._replace(identifier=f.identifier + 10)])),
    _reports("every-50th", "each 50th actual value is lost", "CYC_TI_01", _every(50)),
    _row("late", "its actual value comes 3.5 ms after SYNC", "CYC_TI_01 CYC_BV_01", lambda: Late(ms(3.5))),
    _hears("answers-set", "answers a set value", "CYC_BO_02", _also_idle),
    _hears("tires", "silent after 1900 SYNCs without pause", "CYC_ST_01", _dead_after(1900)),
    _says("strange", "something on 105", "CYC_BV_06", _only_actual(lambda b, f: [f, Frame(105, b"\1")])),
    _reports("never-ready", "ready is never set", "CYC_BV_04", _always(ready=False)),
    _reports("always-power", "power on is always set", "CYC_BV_04", _always(power_on=True)),
    _reports("brake-open", "the brake is always shown open", "CYC_BV_04", _always(brake_open=True)),
    _reports("always-enabled", "enabled is always set", "CYC_BV_04", _always(enabled=True)),
    _reports("always-code", "a fault code without fault", "CYC_BV_04", lambda b, v: v._replace(fault_code=v.fault_code or 7)),
    _reports("drifts", "its position drifts", "CYC_BV_05", _drifts),
    _hears("short-taken", "takes a set value of seven bytes", "CYC_BI_01", _fills_up),
    _hears("any-module", "takes the set values of all modules", "CYC_BI_02", _any_module),
    _heard("no-power", "drive on does nothing", "PWR_BV_01", lambda b, v: v._replace(drive_on=False)),
    _reports("power-hidden", "power on is never set", "PWR_BV_01", _always(power_on=False)),
    _heard("on-is-enable", "drive on is taken for enable as well", "PWR_BV_01", _on_is_enable),
    _heard("no-enable", "enable does nothing", "PWR_BV_02", lambda b, v: v._replace(enable=False)),
    _reports("brake-closed", "the brake is never shown open", "PWR_BV_02", _always(brake_open=False)),
    _heard("enable-stays", "enable cannot be taken back", "PWR_BV_03", _latches("enable")),
    _heard("on-stays", "drive on cannot be taken back", "PWR_BV_01", _latches("drive_on")),
    _reports("ready-goes", "ready goes with power on", "PWR_BV_01", lambda b, v: v._replace(ready=v.ready and not v.power_on)),
    _heard("enable-is-on", "enable is taken for drive on as well", "PWR_BI_01 PWR_BV_04", _enable_is_on),
    _reports(
        "brake-by-request",
        "the request opens the brake",
        "PWR_BI_02",
        _brake_by_request,
    ),
    _tuned("no-supervision", "does not watch SYNC and life counter", "FLT_BV_01 FLT_BV_02", _keeps_on),
    _tuned("supervision-early", "a fault after 1.4 cycles", "FLT_BV_01 FLT_BO_01 FLT_BO_02", _supervision(1.4)),
    _tuned("supervision-late", "a fault after 4 cycles", "FLT_BV_01", _supervision(4)),
    _row(
        "tells-late",
        "a fault is reported with the next SYNC",
        "FLT_BV_01",
        ReportsLate,
    ),
    _heard("life-ignored", "the life counter does not count", "FLT_BV_02", _life_counts),
    _reports("no-fault-bit", "the fault bit is never set", "FLT_BV_01", _always(fault=False)),
    _reports("ready-in-fault", "ready in fault", "FLT_BV_01", lambda b, v: v._replace(ready=v.ready or v.fault)),
    _tuned("jumps", "follows a set position that jumps", "FLT_BV_03", _no_jump),
    _heard("never-resets", "a fault cannot be reset", "FLT_BV_01", _never_resets),
    _heard("reset-by-itself", "a fault ends by itself", "FLT_BI_01", _reset_by_itself),
    _heard("reset-by-off", "drive on withdrawn ends the fault", "FLT_BI_01", _reset_by_off),
    _heard("reset-by-level", "a held reset ends the fault", "FLT_BI_02", _reset_by_level),
    _heard("restarts", "after a reset drive on counts at once", "FLT_BI_03", _restarts),
    _hears("idle-fault", "a lost SYNC without power is a fault", "FLT_BO_03", _idle_is_fault),
    _reports("brake-forgotten", "the brake is shown open after a fault", "FLT_BV_05", _brake_in_fault),
    _heard("half-way", "goes half the way", "MOV_BV_01", _half),
    _heard("forwards-only", "does not go backwards", "MOV_BV_02", _forwards_only),
    _heard("wrong-way", "goes the other way", "MOV_BV_01", _wrong_way),
    _reports("frozen", "its position never changes", "MOV_BV_01", _frozen),
    _hears("lets-go", "control ends where one set value is missing", "MOV_BV_04", _no_set_value),
    _answers(
        "par-next", "answers with the next sequence number", "PAR_BV_01 PAR_BI_01", lambda b, a: a._replace(sequence=a.sequence + 1 & 0xFF)
    ),
    _reports("zero-at-control", "its position is 0 when control begins", "MOV_BV_06", _zero_at_control),
    _reports(
        "ready-goes-at-control", "ready goes when control begins", "MOV_BV_06", lambda b, v: v._replace(ready=v.ready and not v.enabled)
    ),
    _reports("sixteen-bits", "its position has 16 bits", "MOV_BV_07", lambda b, v: v._replace(position_inc=v.position_inc & 0xFFFF)),
    _reports("sixteen-bits-signed", "its position has a sign and 15 bits", "MOV_BV_07", _fifteen_bits),
    _answers("par-silent", "does not answer known parameters", "PAR_BV_01", lambda b, a: a if a.number == 56 else None),
    _answers("par-sequence", "the sequence is always 0", "PAR_BV_01", _no_sequence),
    _answers("par-value", "answers with 0", "PAR_BV_01", lambda b, a: a._replace(value=0.0)),
    _answers(
        "par-any-number",
        "every number is known",
        "PAR_BI_01",
        _takes(Status.UNKNOWN),
    ),
    _answers(
        "par-any-value",
        "every value is taken",
        "PAR_BI_02",
        _takes(Status.RANGE),
    ),
    _answers(
        "par-with-power",
        "takes parameters with power on",
        "PAR_BO_01",
        _takes(Status.DRIVES_ON),
    ),
    _reports("each-700th", "each 700th actual value is missing", "CYC_ST_01", _every(700)),
    _says("twice-under-control", "two actual values for one SYNC under control", "MOV_BV_13", phase.twice),
    _reports("code-left", "the fault code is shown again with power", "FLT_BV_04", phase.code_left),
    _reports("power-dips", "power is shown off when control begins", "PWR_BV_02", phase.power_dips),
    _heard("jumps-back", "backward jumps are followed step by step", "FLT_BV_03", phase.jumps_back),
    _heard("acts-late", "a set position acts one SYNC late", "MOV_BV_12", phase.one_late),
    _reports("latches-late", "its position is that of the SYNC before", "MOV_BV_08", phase.one_before),
    _reports("own-timer", "its position is that of a timer of its own", "MOV_BV_08", phase.own_timer),
    _reports("as-sent", "its position is that of the moment of sending", "FLT_BV_06", phase.as_sent),
    _hears("at-once", "a set value acts when it comes", "MOV_BO_01", phase.at_once),
    _hears("first-counts", "of two set values the first counts", "MOV_BV_09", phase.first_counts),
    _row("ff-reversed", "the feed-forward is reversed", "MOV_BV_10", lambda: Booster(sets=phase.feed_forward(-1), settings=phase.FED)),
    _row("ff-unit", "the feed-forward is ten times as much", "MOV_BV_10", lambda: Booster(sets=phase.feed_forward(10), settings=phase.FED)),
    _reports("torque-reversed", "the torque has the other sign", "MOV_BV_11", phase.torque(lambda value: -value)),
    _reports("torque-absent", "the torque is always 0", "MOV_BV_11", phase.torque(lambda value: 0)),
    _reports("torque-unsigned", "the torque has no sign", "MOV_BV_11", phase.torque(abs)),
    _reports("torque-bytes", "the torque has its high byte first", "MOV_BV_11", phase.torque(phase.swapped)),
    _row("stops-slowly", "its ramps last seconds", "FLT_BV_06 PWR_BV_06 PWR_BV_07", _servo(quick_stop_rad_s2=1.0, stop_timeout_s=9.0)),
    _reports(
        "brake-first", "the brake closes with the fault", "FLT_BV_06", lambda b, v: v._replace(brake_open=v.brake_open and not v.fault)
    ),
    _reports("code-changes", "the fault code changes", "FLT_BV_06", phase.code_changes),
    _reports("code-once", "the fault code comes once", "FLT_BV_06", phase.code_once),
    _heard("enable-edge", "enable is an edge", "PWR_BV_08", phase.enable_edge),
    _heard("one-life", "one unchanged life counter is a fault", "FLT_BO_04", phase.one_life),
    _row("late-life", "an unchanged life counter is noticed three cycles later", "FLT_BV_02", phase.LateLife),
    _hears("sets-unwatched", "set values that stay away are not missed", "FLT_BV_07", phase.sets_unwatched),
    _heard("set-24", "set positions have 24 bits", "FLT_BV_08", phase.narrow(24)),
    _row("creeps", "goes to a set position far away when control begins", "FLT_BI_04", phase.Creeps),
    _tuned("zero-at-reset", "its position is 0 after a fault reset", "FLT_BV_09", phase.zero_at_reset),
    _row("starts-itself", "power is on again when its supply returns", "SUP_RC_01", SelfStarting),
    _row("speaks-without-supply", "sends on without supply", "SUP_RC_01", SpeaksWithoutSupply),
)
MUTANTS = tuple(Mutant(name, what, expects, make, {**LINK, "module": 1}, {}) for name, what, expects, make in ROWS)


def _good(name: str, what: str, make: Callable[[], object], link: dict[str, object] | None = None, **pics: object) -> Variant:
    return Variant(name, what, make, LINK if link is None else link, dict(pics))


def _chatty(booster: Booster, frame: Frame) -> Sequence[Frame]:
    """Another module answers as well."""
    return [frame, Frame(codec().actual_id(4), bytes(8))] if frame.identifier == ACT else [frame]


VARIANTS = (
    _good("plain", "as emulated", Booster),
    _good("late", "its actual value comes 1.5 ms after SYNC", lambda: Late(ms(1.5))),
    _good("chatty", "another module speaks as well", lambda: Booster(out=_chatty)),
    _good("module-3", "module 3", lambda: Booster(module=3)),
    _good("no-brake", "no brake", _servo(brake=False)),
    _good("heavy", "five times the load", _servo(load_inertia_kgm2=0.006)),
    _good("slow-charge", "power takes two seconds, booting one", _servo(charge_s=2.0, boot_s=1.0)),
    _good("gravity", "a vertical axis", _servo(gravity_nm=2.0)),
    _good("feed-forward", "with speed feed-forward", _servo(speed_feed_forward=1.0)),
    _good("stiff", "three times the gain", _servo(kv_per_s=240.0)),
    _good("soft", "a third of the gain", _servo(kv_per_s=27.0)),
    _good("high-friction", "three times the friction", _servo(coulomb_nm=0.9, stiction_nm=1.1)),
    _good("no-parameters", "no parameters over the bus", lambda: Booster(into=lambda b, f: [] if f.identifier == 310 else [f])),
    _good(
        "other-codes",
        "fault codes of its own",
        lambda: Booster(_own_codes),
    ),
    _good("warns", "the warning bit is always set", lambda: Booster(lambda b, v: v._replace(warning=True))),
)
