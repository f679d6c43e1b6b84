"""The supply of a Modbus server fails and returns: it is served again, soon enough."""

from gateway.conformance.framework.causes import PREPARING
from gateway.conformance.suites.modbus.framing import readable_request
from gateway.conformance.suites.modbus.tester import ModbusTester
from gateway.pure.conformance.purpose import Purposes
from gateway.pure.conformance.verdict import Ended, Fail
from protocols.base.machine import ms


def supply_cases(prefix: str) -> Purposes[ModbusTester]:
    """For TCP or RTU."""
    found = Purposes[ModbusTester](f"{prefix}_SUP", "server", "power failure", condition=("power",), preamble=(f"{prefix}_FUN_BV_01",))

    @found.case("RC_01", "the supply fails while it is idle: it serves again", "Netzausfall in Ruhe: er bedient wieder")
    def idle(t: ModbusTester) -> None:
        t.power.cycle()
        _serves(t, "a power failure")

    @found.case(
        "RC_02",
        "the supply fails during a request: it serves again",
        "Netzausfall mitten in einer Anfrage: er bedient wieder",
    )
    def asking(t: ModbusTester) -> None:
        t.quiet()
        t.send(t.frame(readable_request(t))[:6])
        t.power.cycle()
        _serves(t, "a power failure during a request")

    return found


def _serves(t: ModbusTester, what: str) -> None:
    until = t.now() + t.power.back
    while True:
        try:
            t.normal(readable_request(t), f"a request after {what}")
            return
        except Ended as failed:
            if t.now() > until:
                raise Fail(
                    f"it does not serve again: {failed.reason.removeprefix(PREPARING)}", "an answer", failed.got or "nothing"
                ) from failed
            t.power.pause(ms(200))


TCP_SUP, RTU_SUP = supply_cases("MBTCP"), supply_cases("MBRTU")
