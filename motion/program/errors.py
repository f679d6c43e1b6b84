"""What is wrong with a program: the block, the axis and the manual's number, before anything moves."""

from collections.abc import Sequence

from motion.errors import MotionError


class BlockError(MotionError):
    """One block that cannot be run.  code: the manual's number, 0 where none of the three manuals has one; block: its number,
    counted from 1; axis: its name or empty."""

    def __init__(self, what: str, *, code: int = 0, block: int = 0, axis: str = "", source: str = "") -> None:
        self.code, self.block, self.axis, self.what, self.source = code, block, axis, what, source
        where = ", ".join(part for part in (f"block {block}" if block else "", f"axis {axis}" if axis else "") if part)
        number = f" ({source} {code})".replace("( ", "(") if code else ""
        super().__init__(f"{where}: {what}{number}" if where else f"{what}{number}")


class TextError(MotionError):
    """One fault of a program text: line, key (empty: the entire line) and, where there is one, the range."""

    def __init__(self, line: int, key: str, what: str) -> None:
        self.line, self.key, self.what = line, key, what
        super().__init__(f"line {line}: {key}: {what}" if key else f"line {line}: {what}")


class TextFaults(MotionError):
    """All faults of a program text, in the order of its lines."""

    def __init__(self, faults: Sequence[TextError]) -> None:
        self.faults = tuple(faults)
        super().__init__("\n".join(map(str, faults)))
