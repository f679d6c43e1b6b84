"""Servo regulator errors 641..700 as markers and message, and what makes a robot asynchronous.  Source: robotstar 8.1 (L4669-4744)."""

from collections.abc import Mapping
from dataclasses import dataclass

from gateway.pure.controllers.reis.markers import ERROR_NUMBER, IN_ERROR, SYNCHRONOUS, Markers

FIRST, LAST = 641, 700
TEXTS: Mapping[int, str] = {
    643: "axis mode not admissible (SAB)",
    644: "axis mode not admissible (TMS)",
    645: "data change not admitted with drives active",
    646: "axis speed too high (FIPO)",
    647: "tracking distance too long",
    648: "monitoring of standstill",
    649: "maximum axis speed reached (FIPO)",
    650: "machine data exceeds value range",
    651: "disturbed communication to the ADSP",
    652: "new setup-data (node number/baudrate) are adjusted",
    653: "over- or undervoltage",
    654: "error of the power pack",
    656: "excess temperature power electronics",
    657: "I^2*t monitoring, motor overloaded in the cycle",
    658: "excess temperature motor",
    659: "ADSP recognised Reis processor failure",
    660: "ADSP-Firmware wrong",
    661: "ADSP-Parameter faulty",
    662: "Resolver signals faulty",
    663: "I_max not adjustable",
    664: "I_max <= 0",
    665: "I_rms not adjustable",
    666: "I_rms <= 0",
    667: "CAN-Watchdog",
    668: "TMS-Watchdog",
    669: "SAB-Watchdog",
    670: "ADSP-Watchdog",
    671: "ADSP overspeed",
    672: "nominal value filter not adjustable, clamped",
    673: "cable break in the motor phase",
    674: "nominal position left or not reached",
    675: "error in the filtered nominal value",
    676: "cycle relation IPO / position regulator has a rest",
    677: "reference point angle modified -> asynchronous",
    678: "offset angle modified -> asynchronous",
    679: "traversing direction changed -> asynchronous",
    680: "checksum error back-up data (AC-Fail) -> asynchronous",
    681: "ADSP revolution counter not zero after reset -> asynchronous",
    682: "resolver position out of tolerance -> asynchronous",
    683: "drives were not switched off -> asynchronous",
    684: "CU-firmware must be updated",
}
ASYNCHRONOUS = range(677, 684)


@dataclass(frozen=True, slots=True)
class Message:
    """What the panel shows."""

    number: int
    axis: int
    text: str


def regulator_error(markers: Markers, number: int, axis: int) -> Message:
    """A drive reports `number` 641..700: markers and message; the asynchronous ones reset M1020.6.  Raise ValueError otherwise."""
    if not FIRST <= number <= LAST:
        raise ValueError(f"{number}: regulator errors are {FIRST}..{LAST}")
    markers.set_number(ERROR_NUMBER, number)
    markers.set_bit(*IN_ERROR, True)
    if number in ASYNCHRONOUS:
        markers.set_bit(*SYNCHRONOUS, False)
    return Message(number, axis, f"Servoregulator error {number}: {TEXTS.get(number, 'unknown')}")


@dataclass(frozen=True, slots=True)
class Reference:
    """Machine data of an axis its synchronism depends on."""

    home: float  # RHOME_POS
    offset: int = 0  # IENC_OFFSET_HOME
    direction: int = 1  # IAXES_DIR


def start(markers: Markers, kept: Mapping[int, Reference], now: Mapping[int, Reference]) -> list[Message]:
    """Start of the control: `kept` is what each axis (1..) was synchronised with; a change makes it asynchronous (677, 678, 679).

    An axis without kept data was never synchronised: no message, and no M1020.6.
    """
    markers.set_bit(*SYNCHRONOUS, bool(now) and all(axis in kept for axis in now))
    messages: list[Message] = []
    for axis, data in now.items():
        before = kept.get(axis, data)
        for number, changed in (
            (677, data.home != before.home),
            (678, data.offset != before.offset),
            (679, data.direction != before.direction),
        ):
            if changed:
                messages.append(regulator_error(markers, number, axis))
    return messages
