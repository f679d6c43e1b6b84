"""Emergency messages: form, error register, meaning of the codes.

Source: CiA 301, 7.2.7 and object 1001h; CiA 402-2 (IEC 61800-7-201), object 603Fh error code.
"""

import struct
from collections.abc import Mapping
from dataclasses import dataclass
from enum import IntFlag

from protocols.base.errors import DecodeError
from protocols.base.machine import Frame

_FORM = struct.Struct("<HB5s")


class Register(IntFlag):
    """Object 1001h."""

    GENERIC = 1
    CURRENT = 2
    VOLTAGE = 4
    TEMPERATURE = 8
    COMMUNICATION = 16
    PROFILE = 32
    MANUFACTURER = 128


@dataclass(frozen=True, slots=True)
class Emergency:
    """code 0: the error reported before is gone."""

    code: int
    register: int = 0
    detail: bytes = bytes(5)

    @property
    def text(self) -> str:
        return meaning(self.code)


def encode(identifier: int, emergency: Emergency) -> Frame:
    return Frame(identifier, _FORM.pack(emergency.code, emergency.register, emergency.detail))


def decode(data: bytes) -> Emergency:
    """Raises DecodeError when it has not 8 bytes."""
    if len(data) != _FORM.size:
        raise DecodeError(f"an emergency has 8 bytes, {len(data)} received: {data.hex(' ')}")
    return Emergency(*_FORM.unpack(data))


MEANINGS: Mapping[int, str] = {
    0x0000: "no error, or error gone",
    0x1000: "generic error",
    0x2000: "current",
    0x2100: "current on the device's input side",
    0x2200: "internal current",
    0x2300: "current on the device's output side",
    0x2310: "continuous over-current",
    0x2311: "continuous over-current no. 1",
    0x2320: "short circuit or earth leakage",
    0x2330: "earth leakage",
    0x2340: "short circuit",
    0x2350: "load level fault (I2t, thermal state)",
    0x2351: "load level warning (I2t, thermal state)",
    0x3000: "voltage",
    0x3100: "mains voltage",
    0x3110: "mains over-voltage",
    0x3120: "mains under-voltage",
    0x3130: "phase failure",
    0x3200: "voltage inside the device",
    0x3210: "DC link over-voltage",
    0x3220: "DC link under-voltage",
    0x3300: "output voltage",
    0x3331: "field circuit interrupted",
    0x4000: "temperature",
    0x4100: "ambient temperature",
    0x4110: "excess ambient temperature",
    0x4200: "device temperature",
    0x4210: "excess temperature of the device",
    0x4300: "drive temperature",
    0x4310: "excess temperature of the drive",
    0x4400: "supply temperature",
    0x5000: "device hardware",
    0x5100: "supply",
    0x5200: "control",
    0x5300: "operating unit",
    0x5400: "power section",
    0x5440: "contacts",
    0x5441: "contact 1 (manufacturer specific)",
    0x5500: "data storage",
    0x5530: "non-volatile data memory",
    0x6000: "device software",
    0x6100: "internal software (firmware)",
    0x6200: "user software",
    0x6300: "data record",
    0x6320: "parameter error",
    0x7000: "additional modules",
    0x7100: "power",
    0x7110: "brake chopper",
    0x7120: "motor",
    0x7121: "motor blocked",
    0x7122: "motor error or commutation malfunction",
    0x7200: "measurement circuit",
    0x7300: "sensor",
    0x7303: "resolver 1 fault",
    0x7305: "incremental sensor 1 fault",
    0x7310: "speed",
    0x7320: "position",
    0x7380: "position sensor (manufacturer specific)",
    0x7500: "communication",
    0x8000: "monitoring",
    0x8100: "communication",
    0x8110: "CAN overrun (objects lost)",
    0x8120: "CAN in error passive mode",
    0x8130: "life guard or heartbeat error",
    0x8140: "recovered from bus-off",
    0x8150: "CAN identifier collision",
    0x8200: "protocol error",
    0x8210: "PDO not processed because of its length",
    0x8220: "PDO length exceeded",
    0x8230: "multiplexed PDO: destination not available",
    0x8240: "SYNC with unexpected data length",
    0x8250: "RPDO time-out",
    0x8300: "torque control",
    0x8311: "excess torque",
    0x8400: "velocity speed controller",
    0x8500: "position controller",
    0x8600: "positioning controller",
    0x8611: "following error",
    0x8612: "reference limit",
    0x8613: "homing error",
    0x8700: "sync controller",
    0x8800: "winding controller",
    0x8900: "process data monitoring",
    0x8A00: "control",
    0x9000: "external error",
    0xF000: "additional functions",
    0xF001: "deceleration",
    0xFF00: "manufacturer specific",
}


def meaning(code: int) -> str:
    """The most exact entry there is: the code itself, its tens, its group, its class."""
    for mask in (0xFFFF, 0xFFF0, 0xFF00, 0xF000):
        if code & mask in MEANINGS and (code & mask or not code):
            text = MEANINGS[code & mask]
            return text if mask == 0xFFFF else f"{text} ({code:04X}h)"
    return f"unknown error ({code:04X}h)"
