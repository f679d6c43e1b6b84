"""Analog inputs and outputs as markers, and in volts.  Source: robotstar 4.2 (L574-588, L2983-2984)."""

from gateway.pure.controllers.reis.binary import IoFault
from gateway.pure.controllers.reis.markers import ANALOG_INPUTS, ANALOG_OUTPUTS, Markers

CHANNELS = 24
FULL, VOLTS = 32767, 10.0  # volts = marker * 10.0 / (2^15 - 1)


def volts_of(marker: int) -> float:
    """Volts of a signed 16-bit marker."""
    return marker * VOLTS / FULL


def ana_inp(markers: Markers, channel: int) -> float:
    """ANA_INP channel: volts at input 1..24."""
    return volts_of(markers.number(_at(ANALOG_INPUTS, channel), 2))


def output_volts(markers: Markers, channel: int) -> float:
    """What output 1..24 carries."""
    return volts_of(markers.number(_at(ANALOG_OUTPUTS, channel), 2))


def _at(first: int, channel: int) -> int:
    if not 1 <= channel <= CHANNELS:
        raise IoFault(f"analog channel {channel}: 1..{CHANNELS}")
    return first + 2 * (channel - 1)
