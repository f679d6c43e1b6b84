"""The pendant and the variables of a rho 3 in the services; loaded only where the control is one."""

from gateway.pure.arbitration.command_block import Code, Command
from gateway.pure.arbitration.dispatcher import CommandDispatcher
from gateway.pure.controllers.rho3.pendant.modes import RESET
from gateway.pure.controllers.rho3.pendant.unit import BACKUP, UNIT
from gateway.pure.controllers.rho3.signals.control import RhoControl
from gateway.pure.controllers.rho3.signals.coupling import Coupled
from gateway.pure.image.reasons import CommandState, text
from protocols.base.machine import Ns
from protocols.telegrams.fields import Value

USED_NS = 2_000_000_000  # the panel counts as used for so long after a key


class Rho3Panel:
    """Keys in, screen out; a reset chosen at the panel is a fault reset of the command source that pressed."""

    def __init__(self, rho: RhoControl, dispatcher: CommandDispatcher) -> None:
        self.rho = rho
        self._dispatcher = dispatcher
        self._pressed: Ns = 0
        self._source = 0  # who pressed last

    @property
    def halted(self) -> bool:
        """The PIC has stopped (AX-478)."""
        return self.rho.halted

    @property
    def coupled(self) -> Coupled | None:
        """Its bit coupling."""
        return self.rho.coupled

    def look(self, now: Ns) -> None:
        """Before a step of the control."""
        self.rho.pendant.used = bool(self._pressed) and now - self._pressed < USED_NS

    def judge_reset(self, now: Ns) -> str:
        """Mode 11.1 was chosen at the panel: a fault reset like that of a command source; returns why it is refused."""
        panel = self.rho.panel
        if not panel.reset_wanted:
            return ""
        panel.reset_wanted = False
        job = self._dispatcher.command(self._source, Command(Code.FAULT_RESET), now)
        if job.state is CommandState.REFUSED:
            why = text(job.reason, "en", job.detail)
            panel.refuse(why)
            return why
        panel.enter(RESET)
        return ""

    def answer(self, request: dict[str, object], source: int, now: Ns) -> dict[str, object]:
        """Its screen; with `key` after a key, with `mode` in another mode.  Mode 11.1 resets, and needs control for it."""
        functions = self.rho.functions
        if "key" in request:
            self._pressed, self._source = now, source
            key = self.rho.memory.keys.named(str(request["key"]), functions.phg.mode)
            if key == BACKUP:
                self._back_up()
            elif key is not None:
                functions.press(key)
        if "mode" in request:
            self._pressed, self._source = now, source
            self.rho.panel.go(f"0.{request['mode']}".removesuffix(".0"))
            refused = self.judge_reset(now)
            if refused:
                return {"error": f"mode {request['mode']}: {refused}"}
        display = functions.display
        shown = {"screen": list(display.screen()), "mode": functions.phg.mode, "lost_keys": display.lost_keys, "unit": UNIT.facts()}
        return shown | {"graphic": self.rho.screen.shown()}

    def _back_up(self) -> None:
        why = self.rho.pendant.view.order_memory("backup")
        if why:
            self.rho.panel.refuse(why)

    # ---- variables of the PHG 2000 -----------------------------------------------------------------------------------
    def read(self, name: str) -> Value:
        """KeyError, VariableError."""
        return self.rho.pendant.phg.read(name)

    def number(self, name: str) -> float:
        """KeyError, VariableError; ValueError: a text."""
        return self.rho.pendant.phg.number(name)

    def write(self, name: str, value: Value) -> None:
        """KeyError, VariableError; ValueError: a row of values."""
        if isinstance(value, tuple):
            raise ValueError(f"{name}: one value is expected")
        self.rho.pendant.phg.write(name, int(value) if isinstance(value, bool) else value)
