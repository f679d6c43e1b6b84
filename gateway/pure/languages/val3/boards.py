"""Boards of user inputs and outputs and how often they are refreshed.  Source: VAL 3 reference 5.7, L3399-3491; AX-1060."""

from dataclasses import dataclass, field

from gateway.pure.languages.base.requests import Ns

SYSTEM_BOARDS = frozenset("cpio dsio fastio powersupplyio rsi9io starcio".split())  # refreshed in every system cycle
CYCLE: Ns = 4_000_000


def board_of(path: str) -> str:
    """The board a path begins with; "" for a bare name."""
    board, separator, _ = path.replace("/", "\\").partition("\\")
    return board.lower() if separator else ""


@dataclass(slots=True)
class UserBoards:
    """times: of one refresh of each board.  ratio: system cycles from one refresh to the next."""

    no_jitter: bool = False
    ratio: int = 1
    times: dict[str, Ns] = field(default_factory=dict)
    _cycles: int = 0  # system cycles so far

    @property
    def overrun(self) -> bool:
        """Return whether a refresh exceeds its period or, in the synchro task, the system cycle."""
        return sum(self.times.values()) > (CYCLE if self.no_jitter else CYCLE * self.ratio)

    def due(self) -> bool:
        """Once a system cycle: whether the boards are refreshed in it."""
        due = self._cycles % self.ratio == 0
        self._cycles += 1
        return due


def user_boards(mode: str, ratio: int, times_us: dict[str, float]) -> UserBoards:
    """As cell.cfx has them: ratio -1 is 1."""
    return UserBoards(mode == "noJitter", 1 if ratio == -1 else ratio, {name.lower(): round(us * 1000) for name, us in times_us.items()})
