"""Error codes the emulated drive raises.  Source: CiA 402-2, object 603Fh; CiA 301, emergency error codes."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import IntEnum

from protocols.canopen.emcy import Register


class Error(IntEnum):
    GENERIC = 0x1000
    SHORT_CIRCUIT = 0x2340
    I2T = 0x2350
    PHASE = 0x3130
    OVERVOLTAGE = 0x3210
    UNDERVOLTAGE = 0x3220
    DEVICE_HOT = 0x4210
    WINDING = 0x4310
    BLOCKED = 0x7121
    RESOLVER = 0x7303
    OVERSPEED = 0x7310
    CONNECTION = 0x8130
    FOLLOWING = 0x8611
    HOMING = 0x8613
    SYNC = 0x8700
    STOP_TIME_OUT = 0xF001


KINDS: Mapping[int, Register] = {
    Error.GENERIC: Register.GENERIC,
    Error.SHORT_CIRCUIT: Register.CURRENT,
    Error.I2T: Register.CURRENT,
    Error.PHASE: Register.VOLTAGE,
    Error.OVERVOLTAGE: Register.VOLTAGE,
    Error.UNDERVOLTAGE: Register.VOLTAGE,
    Error.DEVICE_HOT: Register.TEMPERATURE,
    Error.WINDING: Register.TEMPERATURE,
    Error.BLOCKED: Register.PROFILE,
    Error.RESOLVER: Register.PROFILE,
    Error.OVERSPEED: Register.PROFILE,
    Error.CONNECTION: Register.COMMUNICATION,
    Error.FOLLOWING: Register.PROFILE,
    Error.HOMING: Register.PROFILE,
    Error.SYNC: Register.PROFILE,
    Error.STOP_TIME_OUT: Register.PROFILE,
}

BLIND = frozenset((Error.FOLLOWING, Error.OVERSPEED, Error.RESOLVER, Error.STOP_TIME_OUT))  # feedback is not to be trusted: torque off
RAMPLESS = frozenset((Error.SHORT_CIRCUIT, Error.OVERVOLTAGE, Error.UNDERVOLTAGE))  # no power to brake with
CAUSES: Mapping[str, Error] = {
    "undervoltage": Error.UNDERVOLTAGE,
    "overvoltage": Error.OVERVOLTAGE,
    "phase_loss": Error.PHASE,
    "over_temperature": Error.DEVICE_HOT,
    "motor_over_temperature": Error.WINDING,
    "encoder_fault": Error.RESOLVER,
    "short_circuit": Error.SHORT_CIRCUIT,
    "motor_blocked": Error.BLOCKED,
}


@dataclass(slots=True)
class Surroundings:
    """Conditions outside the drive: operation at its own panel (`local`), faults whose cause is present."""

    local: bool = False
    causes: set[Error] = field(default_factory=set)

    @property
    def no_power(self) -> bool:
        return Error.UNDERVOLTAGE in self.causes
