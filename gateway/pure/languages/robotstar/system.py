"""System variables: names, types, who may read and write, what they mean.  Source: robotstar 2.8, 3.4, 3.6, 4.1, 5.6."""

from collections.abc import Callable
from dataclasses import dataclass, field

from gateway.pure.languages.robotstar.machine import Machine, Surroundings
from gateway.pure.languages.robotstar.path import ACC_MAX, RANGES, Defaults
from gateway.pure.languages.robotstar.values import Array, Cell, Scalar, Structure, SystemCell, Variable

PATH_VARIABLES = (
    "_IV_FLYBY_S", "_IV_FLYBY_O", "_IV_CIRCHP_O", "_ISPL_TENS", "_IORI_TENS", "_IORI_WEIGHT", "_IORI_CIRCHP", "_IACC_TIME",
)  # fmt: skip
# default variable -> parameter (L2043-2067)
DEFAULTS = {
    "_IDEF_MOVMOD": "MOVE_MODE", "_IDEF_FLYFLG": "FLYBY", "_RDEF_VEL_CP": "PATH_SPEED", "_IDEF_ACC_CP": "PATH_ACCEL",
    "_IDEF_VELPTP": "PTP_SPEED", "_IDEF_ACCPTP": "PTP_ACCEL", "_RDEF_PATH_R": "PATH_RADIUS", "_RDEF_PATH_D": "PATH_DISTANCE",
    "_RDEF_PATH_T": "PATH_TIME", "_IDEF_VFLY_S": "_IV_FLYBY_S", "_IDEF_VFLY_O": "_IV_FLYBY_O", "_IDEF_VCRC_O": "_IV_CIRCHP_O",
    "_IDEF_SPLTEN": "_ISPL_TENS", "_IDEF_ORITEN": "_IORI_TENS", "_IDEF_ORIWGT": "_IORI_WEIGHT", "_IDEF_ORICRC": "_IORI_CIRCHP",
    "_IDEF_ACCTIM": "_IACC_TIME",
}  # fmt: skip
KEPT: dict[str, int | float | str] = {  # plain values of the control, kept over power-off
    "_SSTARTPLC": " " * 16, "_SPLC_PATH": "S:/PLC", "_SNMIPRG": "", "_ITIME_PLC": 30, "_RVEL_KART": 250.0, "_RVEL_ORI": 45.0, "_IFILTER": 0,
}  # fmt: skip
ALIASES = {
    "_RVEL_CART": "_RVEL_KART",
    "_FILTER": "_IFILTER",
    "_IDEF_VFLYÖ": "_IDEF_VFLY_O",
    "_ORI_WEIGHT": "_IORI_WEIGHT",
}  # D-9, D-11, D-41


NAMES = frozenset(
    (
        *PATH_VARIABLES, *DEFAULTS, *KEPT, *ALIASES, "_IBIN_IN", "_IBIN_OUT", "_SPS", "_ISYS_IN", "_ISYS_OUT", "_VNULL", "_RACC_MAX",
        "_RPATH_DIST", "_RTIME_DIST", "_VERFAHR", "_RMOUSE_T", "_RMOUSE_R", "_IMOUSE",
    )
)  # fmt: skip


@dataclass(slots=True)
class System:
    """The system variables of one control."""

    world: Surroundings
    machine: Machine | None = None  # set once the machine is made
    defaults: dict[str, float] = field(default_factory=lambda: dict(Defaults().values))
    path_left: Callable[[int], float] = lambda number: 0.0  # _RPATH_DIST 1, 2 and _RTIME_DIST 3, 4

    def names(self) -> dict[str, Variable]:
        """All system variables by name."""
        found: dict[str, Variable] = {
            "_IBIN_IN": self._words("INPUT", 10, writable=False),
            "_IBIN_OUT": self._words("OUTPUT", 10, writable=True),
            "_SPS": self._words("MARKER", 512, writable=True),
            "_ISYS_IN": Array([self._word("MARKER", place, False) for place in (1008, 1000)]),
            "_ISYS_OUT": Array([self._word("MARKER", place, False) for place in (1012, 1004)]),
            "_VNULL": Structure("V", dict.fromkeys(("FRAME", "X", "Y", "Z", "A", "B", "C"), 0.0), writable=False),
            "_RACC_MAX": SystemCell("R", lambda: ACC_MAX, None),
            "_RPATH_DIST": Array([self._left(1), self._left(2)]),
            "_RTIME_DIST": Array([self._left(3), self._left(4)]),
            "_VERFAHR": Array([Cell("I", 0) for _ in range(3)]),
            "_RMOUSE_T": Array([SystemCell("R", None, None) for _ in range(9)]),
            "_RMOUSE_R": Array([SystemCell("R", None, None) for _ in range(9)]),
            "_IMOUSE": Array([self._coordinate(number) for number in range(1, 7)]),
        }
        found |= {name: Cell(name[1], value, length=128) for name, value in KEPT.items()}
        found |= {name: self._parameter(name) for name in PATH_VARIABLES}
        found |= {name: self._default(name, parameter) for name, parameter in DEFAULTS.items()}
        return found | {alias: found[name] for alias, name in ALIASES.items()}

    def _words(self, area: str, count: int, writable: bool) -> Array:
        return Array([self._word(area, 4 * number, writable) for number in range(count)])

    def _word(self, area: str, place: int, writable: bool) -> SystemCell:
        def put(value: Scalar) -> None:
            assert isinstance(value, int) and self.machine is not None
            if self.machine.switches(area, place):
                self.world.set_element(area, place, value)

        return SystemCell("I", lambda: self.world.element(area, place), put if writable else None)

    def _left(self, number: int) -> SystemCell:
        return SystemCell("R", lambda: self.path_left(number), None)

    def _coordinate(self, number: int) -> SystemCell:
        """Return a coordinate as a calibration program reads it, after its movement."""

        def get() -> Scalar:
            assert self.machine is not None
            self.world.actual()
            return self.machine.mouse.reading(number)

        return SystemCell("I", get, None)

    def _parameter(self, name: str) -> SystemCell:
        def get() -> Scalar:
            assert self.machine is not None
            return int(self.machine.path.values[name])

        def put(value: Scalar) -> None:
            assert self.machine is not None and not isinstance(value, str)
            self.machine.path.set(name, value)

        return SystemCell("I", get, put)

    def _default(self, name: str, parameter: str) -> SystemCell:
        integer = name[1] == "I"

        def put(value: Scalar) -> None:
            assert self.machine is not None and not isinstance(value, str)
            low, high = RANGES[parameter]
            state = self.machine.path
            if low <= value <= high:
                self.defaults[parameter] = value
                state.defaults = Defaults(dict(self.defaults))
            else:
                state.set(parameter, value)  # raises with the range

        return SystemCell(name[1], lambda: int(self.defaults[parameter]) if integer else float(self.defaults[parameter]), put)
