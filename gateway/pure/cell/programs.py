"""[[program]] of the cell file: motion programs that command sources order by their number."""

from dataclasses import dataclass
from typing import Annotated

from annotated_types import Ge, Le, MinLen


@dataclass(frozen=True, slots=True)
class Program:
    """[[program]]: a program in the documented text form (docs/guide/motion-programs.md)."""

    number: Annotated[int, Ge(1), Le(9999)]
    file: Annotated[str, MinLen(1)]  # next to the cell file, then in configs/programs
    kinematics: str = ""  # name of [robot]; empty: the only one there is

    @property
    def name(self) -> str:
        """As it is called in words: the file's stem."""
        base = self.file.rpartition("/")[2]
        return base.rpartition(".")[0] or base
