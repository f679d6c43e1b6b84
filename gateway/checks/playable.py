"""Parts of a checked cell that this version cannot run."""

from collections.abc import Iterator

from gateway.pure.cell.cell import PLANNED_KINEMATICS, Cell
from gateway.registry import DRIVE_FAMILIES


def not_playable(cell: Cell) -> list[str]:
    """Each by its key; empty: all of it runs."""
    reasons = [f"{key} = {value}" for key, value, played in _choices(cell) if value not in played]
    reasons += [f"db.{db.number}[{entry.at}] = {entry.signal}" for db in cell.db for entry in db.entries if not _served(entry.signal)]
    unknown = [robot.kinematics for robot in cell.robot if cell.program and robot.kinematics not in PLANNED_KINEMATICS]
    reasons += [f"robot.kinematics = {kinematics}" for kinematics in unknown]  # no other part requires them
    return reasons


def _choices(cell: Cell) -> Iterator[tuple[str, str | int, tuple[str | int, ...]]]:
    """(key, chosen value, values this version plays) wherever the file's shape allows more than runs."""
    for line in cell.line:
        yield (
            f"line.{line.name}.port",
            line.port.split(":")[0],
            ("sim", "pty", "tcp", "rfc2217", line.port if line.port.startswith("/") else "sim"),
        )
    for axis in cell.axis:
        yield f"axis.{axis.name}.mode", axis.mode, ("csp",)
        contact = any(io.signal == f"axis.{axis.name}.brake" for io in cell.io)
        yield f"axis.{axis.name}.brake", axis.brake, ("drive", "none", *(("gateway",) if contact else ()))
        itself = ("drive",) if DRIVE_FAMILIES[axis.drive.type].homes else ()
        yield f"axis.{axis.name}.home.by", axis.home.by, ("gateway", "none", *itself)
        if axis.home.by == "gateway":
            yield f"axis.{axis.name}.home.mode", axis.home.mode, (0, 1, 2, 3)


def _served(signal: str) -> bool:
    """Names a data block may hold that this version does not serve yet: one axis' own reference, the safety contact."""
    one_axis = signal.startswith("axis.") and signal.endswith(".reference") and signal != "axis.*.reference"
    return not (one_axis or signal == "cell.safety_ok")
