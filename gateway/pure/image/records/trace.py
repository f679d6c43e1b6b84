"""Times of one cycle, as its own clock saw them."""

from dataclasses import dataclass

from gateway.pure.image.records.layout import I64, U64, Layout


@dataclass(frozen=True, slots=True)
class Trace:
    """One cycle as its own clock saw it; ns."""

    cycle: U64
    due: I64
    sent: I64  # SYNC handed to the bus
    answered: I64  # last actual value in, or patience over
    ready: I64  # set values for the next SYNC prepared
    missing: I64  # telegrams


_TRACE = Layout(Trace, "cycle-trace/1")
TRACE_BYTES, TRACE_RECORDS, TRACE_LAYOUT = _TRACE.size, 8192, _TRACE.text
pack_trace = _TRACE.struct.pack  # of the fields themselves: it is called in every cycle
unpack_trace = _TRACE.unpack
