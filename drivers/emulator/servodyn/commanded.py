"""The set values of one emulated booster: the last one, and the positions they lead it along."""

from protocols.servodyn.codec import SetValue

_AT_POWER_UP = SetValue(drive_on=True, limit_switch=True, fault_reset=True)  # a bit that is set at power-up is not an edge


def wrap(value: int) -> int:
    """As the int32 of a telegram."""
    return (value + 0x80000000 & 0xFFFFFFFF) - 0x80000000


class Commanded:
    """Positions in increments of the resolver, which are `scale` times fewer in the telegrams (parameter 21)."""

    def __init__(self) -> None:
        self.target = self._last_target = 0
        self.scale = 1
        self.restart()

    def restart(self) -> None:
        """Power-up: none has come."""
        self.value, self.may_switch_on = _AT_POWER_UP, False  # drive on counts once it was seen 0

    def take(self, value: SetValue) -> SetValue:
        """A new one; the one before."""
        before, self.value = self.value, value
        self.may_switch_on = self.may_switch_on or not value.drive_on
        return before

    def begin(self, counter: int) -> None:
        """Control begins here, at rest."""
        self.target = self._last_target = counter

    def stay(self) -> None:
        """Nothing new: where the last one pointed."""
        self._last_target = self.target

    def lead(self, position_inc: int, window: float) -> bool:
        """On to this position of a telegram, which counts on through its wrap; False: that is a jump of more than `window`."""
        last = self.target // self.scale
        target = (last + wrap(position_inc - last)) * self.scale
        predicted = 2 * self.target - self._last_target
        if abs(target - self.target) > window and abs(target - predicted) > window:
            return False
        self._last_target, self.target = self.target, target
        return True
