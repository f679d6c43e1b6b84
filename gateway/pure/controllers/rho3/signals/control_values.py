"""Values of a control other than signals, by name: integers, REAL channels, the PIC, boards and other wired values.  Pure."""

from gateway.pure.controllers.rho3.signals.fast_io import Channels
from gateway.pure.controllers.rho3.signals.pic import PicLink
from gateway.pure.controllers.rho3.signals.user import UserPorts

BOARD_IN, BOARD_OUT = 8, 5


class ControlValues:
    """`board_in`, `board_out`: bytes of the board in the rack of the bit coupling, filled in place."""

    def __init__(self, user: UserPorts, channels: Channels, pic: PicLink | None, *, board: bool) -> None:
        """`board`: there is one."""
        self._user, self._channels, self._pic = user, channels, pic
        self.board_in, self.board_out = bytearray(BOARD_IN), bytearray(BOARD_OUT)
        self.names = self._all_names(board)

    def _all_names(self, board: bool) -> tuple[str, ...]:
        integers = [f"rho3.integer.{channel}" for channel in range(401, 409)]
        boards = [f"rho3.board.input.{n}" for n in range(BOARD_IN)] + [f"rho3.board.output.{n}" for n in range(BOARD_OUT)]
        pic = self._pic.names() if self._pic is not None else []
        analog = self._channels.analog.names() if self._channels.analog is not None else ()
        return (*integers, *analog, *(boards if board else []), *pic, *self._channels.names())

    def value(self, name: str) -> float:
        """One of them; KeyError."""
        if name not in self.names:
            raise KeyError(name)
        analog = self._channels.analog
        if analog is not None and analog.has(name):
            return analog.value(name)
        _, kind, *rest = name.split(".")
        number = int(rest[-1])
        if kind == "integer":
            return float(self._user.integer(number))
        if kind == "pic" and self._pic is not None:
            return self._pic.value(name)
        if kind == "board":
            return float((self.board_in if rest[0] == "input" else self.board_out)[number])
        return self._channels.value(name)

    def put(self, name: str, value: float) -> None:
        """What is wired: inputs of boards, of the multi-function I/O, REAL inputs; KeyError for anything else, ValueError out of range."""
        if name not in self.names or not (".input." in name or ".fast." in name):
            raise KeyError(name)
        analog = self._channels.analog
        if analog is not None and analog.has(name):
            analog.wire(name, value)
            return
        most = 255 if ".board." in name else 1
        if not 0 <= value <= most:
            raise ValueError(f"{name}: 0..{most}")
        if most == 255:
            self.board_in[int(name.rpartition(".")[2])] = int(value)
        elif name.startswith("rho3.pic.") and self._pic is not None:
            self._pic.wire(name, bool(value))
        else:
            self._channels.wire(name, bool(value))
