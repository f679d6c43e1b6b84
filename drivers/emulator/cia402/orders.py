"""Interventions of a tester at one emulated CiA 402 drive: causes of faults, encoder, brake, supply."""

from drivers.emulator.cia402.axis import Cia402Axis
from drivers.emulator.cia402.errors import Error
from drivers.emulator.servo.model import NEVER


class OrderedAxis(Cia402Axis):
    """The drive that sits on a bus.  After an order its bus looks at it again (`reschedule`)."""

    def cause(self, error: Error, present: bool) -> None:
        """A fault whose cause remains until it is removed."""
        if present:
            self.site.causes.add(error)
            self.fail(error)
        else:
            self.site.causes.discard(error)

    def reschedule(self) -> None:
        """After something was done from outside."""
        self._schedule()

    def encoder(self, factor: int) -> None:
        """1 true, -1 counts backwards, 0 stuck."""
        self.servo.encoder(factor)
        self.place.look_again()
        self.watch_switches()

    def jump_encoder(self, increments: int) -> None:
        self.servo.jump(increments)
        self.place.look_again()
        self.watch_switches()

    def stick_brake(self, stuck: bool) -> None:
        """The brake does not open (mechanically), whatever is commanded."""
        self.brake.stuck = stuck
        if stuck:
            self.servo.close_brake()
        elif self.brake.is_open:
            self.servo.open_brake()

    def power_off(self) -> None:
        self.reset(self.now)
        self._boot_due = NEVER
        self._schedule()

    def power_on(self) -> None:
        """The counter shows what its encoder stores; homing is lost unless the encoder keeps its turns."""
        self.servo.power_up()
        if not self.settings.multiturn_turns:
            self.place.forget()
        self.reset(self.now)
