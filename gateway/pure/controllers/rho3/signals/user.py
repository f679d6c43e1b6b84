"""User inputs and outputs of BAPS programs.  Source: rho3 0.3 (L7953-7967), 3.1 (L861-875), 3.3 P24 (L696), P27 (L5133-5141), AX-503."""

from gateway.pure.controllers.pic_image import Edge, PicImage
from gateway.pure.controllers.rho3.signals.numbers import AS_SHIPPED, Numbers

FIRST_INPUT, INPUTS, STATUSES = 464, 120, 99  # USER_1_RCI; channels 1..120, statuses 1..99
OUTPUTS = 120
INTEGER_CHANNEL, INTEGERS = 401, 8
EARLY = 1000  # the same inputs, read while the block is prepared


class ChannelFault(ValueError):
    """No such channel; the text of the manual."""


def input_bit(channel: int) -> int:
    """RC input of binary channel 1..120 (or 1001..1120); ChannelFault otherwise."""
    number = channel - EARLY if channel > EARLY else channel
    if not 1 <= number <= INPUTS:
        raise ChannelFault(f"inadmissable input: binary channel {channel}")
    return FIRST_INPUT + number - 1


class UserPorts:
    """What a program reads and writes by channel."""

    def __init__(self, image: PicImage, p24: int = OUTPUTS, p27: int = 0, numbers: Numbers = AS_SHIPPED) -> None:
        """`p24`: how many outputs a Control reset clears (default: all); `p27`: 0 INTEGER inputs with strobe, 1 without."""
        if not 0 <= p24 <= OUTPUTS or p27 not in (0, 1):
            raise ValueError(f"P24 = {p24} (0..{OUTPUTS}), P27 = {p27} (0 or 1)")
        self._image, self._p24, self._p27, self._numbers = image, p24, p27, numbers
        self._taken = bytearray(INTEGERS)
        self._strobes = [Edge(numbers.first_strobe + number) for number in range(INTEGERS)]

    def read(self, channel: int) -> bool:
        """Binary input 1..120."""
        return self._image.input(input_bit(channel))

    def statuses(self) -> tuple[int, ...]:
        """Return the active machine statuses 1..99: user input n is status n."""
        return tuple(number for number in range(1, STATUSES + 1) if self.read(number))

    def write(self, channel: int, value: bool) -> None:
        """User output 1..120; ChannelFault otherwise."""
        if not 1 <= channel <= OUTPUTS:
            raise ChannelFault(f"user output {channel}: 1..{OUTPUTS}")
        self._image.put(self._numbers.first_output + channel - 1, value)

    def control_reset(self) -> None:
        """Clears outputs 1..P24; the others stay."""
        for channel in range(1, self._p24 + 1):
            self.write(channel, False)

    def look(self) -> None:
        """Call once per cycle; reads the INTEGER inputs whose strobe has come."""
        for number, strobe in enumerate(self._strobes):
            if strobe.rises(self._image):
                self._taken[number] = self._image.inputs[self._numbers.first_integer // 8 + number]

    def integer(self, channel: int) -> int:
        """INTEGER input 401..408 (or 1401..1408): the value at its last strobe, with P27 = 1 the present one."""
        number = (channel - EARLY if channel > EARLY else channel) - INTEGER_CHANNEL
        if not 0 <= number < INTEGERS:
            raise ChannelFault(f"inadmissable input: INTEGER channel {channel}")
        return self._image.inputs[self._numbers.first_integer // 8 + number] if self._p27 else self._taken[number]
