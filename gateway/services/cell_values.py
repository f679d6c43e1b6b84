"""Values of the cell by name: cell.*, axis.*, error.first.code, and move.* of the command source that reads them."""

from collections.abc import Iterable

from gateway.assembly.lanes import robot_axes
from gateway.pure.cell.cell import Cell
from gateway.pure.image.records.cell import AxisFlag
from gateway.services.shared_image import SharedImage
from gateway.services.value_directory import Reader, ValueDirectory
from protocols.base.machine import Ns
from protocols.telegrams.fields import Value


class CellValues:
    """The only place that defines every `from` name of the cell; a provider of the value directory."""

    def __init__(self, cell: Cell, image: SharedImage, directory: ValueDirectory) -> None:
        self._image, self._directory = image, directory
        self._axes = {axis.name: (n, 1000.0 if axis.unit == "mm" else 57.29577951308232) for n, axis in enumerate(cell.axis)}
        self._count, self._robots = len(cell.axis), robot_axes(cell)
        self.life = 0
        self.refusals: dict[int, tuple[int, str, int]] = {}  # command source -> reason, words, stamp of its last refusal

    def names(self) -> Iterable[str]:
        """Every name that can be read."""
        single = ["ready", "drives_on", "emergency_stop", "error", "life", "override", "motion"]
        fields = ["actual", "set", "lag", "speed", "torque", "enabled", "referenced", "in_position", "fault"]
        axes = [f"axis.{name}.{field}" for name in (*self._axes, "*") for field in fields if name != "*" or field in _FLAGS]
        return [f"cell.{name}" for name in single] + ["error.first.code"] + axes + [f"robot.{name}.override" for name in self._robots]

    def read(self, name: str, reader: Reader | None) -> Value:
        return self.get(name, reader)

    def valid(self, name: str) -> bool:
        return self._image.cycle_lives()

    def write(self, name: str, value: Value, now: Ns, by: str) -> None:
        raise KeyError(f"{name}: the cell's own values are read only")

    def get(self, name: str, reader: Reader | None = None) -> float:
        """Value in the unit of the name; KeyError: unknown name."""
        match name.split("."):
            case ["cell", key]:
                return self._cell(key, reader)
            case ["error", "first", "code"]:
                return float(next((code for code, *_ in self._seen_by(reader)), 0))
            case ["axis", "*", key]:
                flag = _FLAGS[key]
                return float(all(axis.flags & flag for axis in self._image.state.axes[: self._count]))
            case ["axis", axis, key]:
                return self._axis(axis, key)
            case ["robot", robot, "override"] if robot in self._robots:
                return self._image.state.override_of(self._robots[robot]) * 100.0
            case ["move", key] if reader is not None:
                return float(reader.move_bit(key))
        raise KeyError(name)

    def _cell(self, key: str, reader: Reader | None) -> float:
        state = self._image.state
        match key:
            case "ready":
                return float(state.ready)
            case "drives_on":
                return float(all(axis.flags & AxisFlag.ENABLED for axis in state.axes[: self._count]))
            case "emergency_stop":
                return float(state.emergency)
            case "error":
                return float(bool(self._seen_by(reader)))
            case "life":
                return float(self.life & 0x7FFF)
            case "override":
                return state.override * 100.0
            case "motion":
                return float(state.motion)
            case "control" if reader is not None:
                return float(reader.in_control)
        raise KeyError(f"cell.{key}")

    def _seen_by(self, reader: Reader | None) -> list[tuple[int, str]]:
        """Active errors, and the last refusal of this very command source; it does not see those of others."""
        own = self.refusals.get(reader.number) if reader is not None else None
        return self._directory.errors + ([own[:2]] if own is not None else [])

    def _axis(self, name: str, key: str) -> float:
        if name not in self._axes:
            raise KeyError(f"axis.{name}.{key}; axes are {', '.join(self._axes)}")
        n, factor = self._axes[name]
        axis = self._image.state.axes[n]
        match key:
            case "actual":
                return axis.actual * factor
            case "set":
                return axis.set * factor
            case "lag":
                return axis.lag * factor
            case "speed":
                return axis.speed * factor
            case "torque":
                return axis.torque * 100.0
        return float(bool(axis.flags & _FLAGS[key]))


_FLAGS = {
    "enabled": AxisFlag.ENABLED,
    "referenced": AxisFlag.REFERENCED,
    "in_position": AxisFlag.IN_POSITION,
    "fault": AxisFlag.FAULT | AxisFlag.LOST,
}
