"""A booster as AX-001 tells it, small and without dynamics: the other side for tests of drivers/drives alone."""

from protocols.servodyn.codec import ActualValue, SetValue


class Booster:
    """Bits follow one step after what asks for them; the position follows the set one while enabled."""

    def __init__(self, position_inc: int = 1000) -> None:
        self.actual = ActualValue(ready=True, position_inc=position_inc)
        self.brake_delay = 3
        self.deaf = False  # hears nothing and stays as it is
        self._since_enabled = 0
        self._reset_before = True

    def hear(self, value: SetValue) -> ActualValue:
        """Activated at the next SYNC; the actual value latched there."""
        old = self.actual
        if self.deaf:
            return old
        reset = value.fault_reset and not self._reset_before
        self._reset_before = value.fault_reset
        fault = old.fault and not reset
        enabled = value.enable and old.power_on and not fault
        self._since_enabled = self._since_enabled + 1 if enabled else 0
        self.actual = old._replace(
            fault=fault,
            fault_code=old.fault_code if fault else 0,
            power_on=value.drive_on and not fault,
            enabled=enabled,
            brake_open=self._since_enabled > self.brake_delay,
            position_inc=value.position_inc if old.enabled and enabled else old.position_inc,
        )
        return self.actual

    def trip(self, code: int) -> None:
        self.actual = self.actual._replace(fault=True, fault_code=code, enabled=False, power_on=False, brake_open=False)
