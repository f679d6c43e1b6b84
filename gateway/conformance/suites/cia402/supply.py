"""The supply of a drive fails while it is enabled: it must not switch on automatically when the supply returns."""

from gateway.conformance.suites.can.node import NodeTester
from gateway.conformance.suites.cia402.drive import DISABLED, ENABLED, brought_to, reaches, stays
from gateway.pure.conformance.purpose import Purposes
from protocols.base.machine import ms

NEEDS = ("CIA402_PWR_BV_01", "CIA402_PWR_BV_02", "CIA402_PWR_BV_03", "CIA402_PWR_BV_04")
SUP = Purposes[NodeTester]("CIA402_SUP", "drive", "CiA 402-2, power states", condition=("power", "may_power"), preamble=NEEDS)


@SUP.case(
    "RC_01",
    "the supply fails in operation enabled: afterwards it is switch on disabled, and stays so",
    "Netzausfall in Operation Enabled: danach ist er in Einschaltsperre und bleibt es",
)
def not_by_itself(t: NodeTester) -> None:
    with brought_to(t, ENABLED):
        t.power.cycle()
        t.boot_up(max(t.setup.boot, t.power.back))
        t.ready()
        reaches(t, DISABLED, "after a power failure", t.setup.boot)
        stays(t, DISABLED, "after a power failure", ms(500))
