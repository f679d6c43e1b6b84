"""Motion commands of a ROBOTstar program as a cell hands them to the planner: parameters, checks and lines of the language, no cell."""

from gateway.pure.languages.robotstar.arm import REIS
from gateway.pure.languages.robotstar.faults import StepFault
from gateway.pure.languages.robotstar.lines import head, line, tool_line
from gateway.pure.languages.robotstar.machine import Go
from gateway.pure.languages.robotstar.motion_steps import way
from gateway.pure.languages.robotstar.path import PathState, Target
from motion.geometry.units import from_si
from motion.program.blocks import Block, JointTarget, PoseTarget
from motion.program.text.reader import Reader

WORDS = {
    "UEBERSCHL": "FLYBY", "BAHN_GESCHW": "PATH_SPEED", "BAHN_BESCHL": "PATH_ACCEL", "PTP_GESCHW": "PTP_SPEED", "PTP_BESCHL": "PTP_ACCEL",
    "BAHN_RADIUS": "PATH_RADIUS", "BAHN_DISTANZ": "PATH_DISTANCE", "BAHN_ZEIT": "PATH_TIME",
}  # fmt: skip


class Path:
    """`set` with the manual's names, `position` in their order, blocks out.  extra: additional axes, mm."""

    def __init__(self, start: PoseTarget | JointTarget) -> None:
        self.state, self._here = PathState(), _target(start)
        self._lines = [*head(["deg"] * len(start.q) if isinstance(start, JointTarget) else ["mm"]), tool_line("T", (0.0,) * 6)]
        self._through: tuple[Go, str] | None = None

    def set(self, name: str, value: float | str) -> None:
        if isinstance(value, str):
            self.state.set_mode(value)
        else:
            self.state.set(WORDS.get(name, f"_{name}"), value)

    def position(self, target: PoseTarget | JointTarget) -> None:
        go, text = way(self.state, self.state.shifted(_target(target)), self._here), _text(target)
        self._here = go.target
        if go.auxiliary:
            self._through = go, text
            return
        if self._through is None:
            self._lines.append(line(go, text, "T"))
        else:
            through, via = self._through
            self._lines.append(line(go, text, "T", via, through.settings["_IORI_CIRCHP"]))
        self._through = None

    def blocks(self) -> tuple[Block, ...]:
        reader = Reader()
        for text in self._lines:
            reader.statement(text)
        return tuple(reader.blocks)


def fault(path: Path, *targets: PoseTarget | JointTarget) -> int:
    """Number of the path error that the last of these positions is; 0: none."""
    for target in targets[:-1]:
        path.position(target)
    try:
        path.position(targets[-1])
    except StepFault as error:
        return error.code
    return 0


def _target(target: PoseTarget | JointTarget) -> Target:
    if isinstance(target, JointTarget):
        return Target((), 0, {f"A{number}": from_si(value, "deg") for number, value in enumerate(target.q, 1)})
    return Target(REIS.values(target.pose), 0, {f"A{number}": value * 1e3 for number, value in enumerate(target.extra, 7)})


def _text(target: PoseTarget | JointTarget) -> str:
    found = _target(target)
    if isinstance(target, JointTarget):
        return "joints " + " ".join(f"{value:.12g}" for value in found.axes.values())
    extra = ",".join(f"{value:.12g}mm" for value in found.axes.values())
    return "pose " + " ".join(f"{value:.12g}" for value in found.pose) + (f" extra={extra}" if extra else "")
