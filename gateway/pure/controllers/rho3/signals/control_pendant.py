"""The pendant of a control: its panel, the text that programs write on it, the variables it knows by number.  Pure."""

from gateway.pure.controllers.rho3.functions.plc import Functions
from gateway.pure.controllers.rho3.pendant.panel import Panel
from gateway.pure.controllers.rho3.signals.control_state import ControlState
from gateway.pure.controllers.rho3.signals.panel_view import PanelView
from gateway.pure.controllers.rho3.signals.phg_values import PhgValues
from gateway.pure.controllers.rho3.signals.written_text import WrittenText
from protocols.base.machine import Ns


class ControlPendant:
    """`used`: keys of the panel are pressed."""

    def __init__(self, control: ControlState, functions: Functions) -> None:
        self.view = PanelView(control)
        self.panel = Panel(functions.display, functions.phg, functions.statuses, self.view, control.setup.functions.language)
        self.written = WrittenText(functions.display)
        self.phg = PhgValues(control)
        self.used = False

    def step(self, now: Ns) -> None:
        """Once per cycle."""
        self.panel.step(now)
        self.written.echo()
