"""A portal with three belts (types 1, 2, 3) whose encoders are on the drive bus, as a whole running cell."""

import contextlib
import pathlib
import re
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator

from gateway.pure.image.records.cell import CellState, Motion
from gateway.recording.file import read
from gateway.simulation.drives.control import EmulatorControl
from hil_tests.lab.running.program_run import PROBE, ProgramRun, program_run
from motion.sync.belts import SET_COUNTER

INCREMENT = 1e-4  # m
FIRST_ID = 0x1F0
SPEED = 0.150  # m/s
BELTS = "".join(
    f'[[belt]]\nname = "B{kind}"\ntype = {kind}\nincrement = 0.1\nbus = "drives"\nid = {FIRST_ID + kind}\nsimulated = 50.0\n\n'
    f"[plant.belt.B{kind}]\naccel = 2000.0\n\n"
    for kind in (1, 2, 3)
)


def with_belts(text: str) -> str:
    """The portal's cell file with belts, absolute axes that are where programs begin, and the belts' signals from the PLC."""
    text = re.sub(r'home            = \{ by = "gateway".*\}', 'home            = { by = "none" }', text)
    for axis, place in (("X", 100.0), ("Y", 100.0), ("Z", 50.0), ("C", 0.0)):
        text = re.sub(rf"(\[plant\.axis\.{axis}\][^\[]*?start +=) [\d.]+", rf"\g<1> {place}", text)
    text = with_signals(text)
    kept = '[retain]\nvalues = ["belt.*"]\n\n'
    return text.replace("# ---- the emulated machine", kept + BELTS + "# ---- the emulated machine")


def with_signals(text: str) -> str:
    """RC inputs of belts come from the PLC."""
    owners = ", ".join(f'"{byte}" = "plc"' for byte in (PROBE >> 3, SET_COUNTER >> 3, 399 >> 3))
    return re.sub(r"owner = \{.*\}", f"owner = {{ {owners} }}", text)


class BeltRun:
    """The other parts of such a run, besides the programs."""

    def __init__(self, run: ProgramRun) -> None:
        self.programs, self._emulator = run, EmulatorControl(f"{run.run.name}-drives")

    def close(self) -> None:
        self._emulator.close()

    def drive(self, kind: int, speed: float) -> None:
        """The belt of this type runs at m/s."""
        self._emulator.ask("belt", belt=kind, speed=speed / INCREMENT)

    def silence(self, kind: int, *, silent: bool) -> None:
        """Stop the transmission of its encoder."""
        self._emulator.ask("belt", belt=kind, silent=silent)

    def zero(self, kind: int) -> None:
        """The PLC sets the belt's counter to its reset value, 0; the input is set for several cycles, so that one of them sees it."""
        self.programs.coil(SET_COUNTER + kind - 1, True)
        seen = self.programs.state().cycle + 3
        self.programs.watch("cycles with the input", lambda state: state.cycle >= seen)
        self.programs.coil(SET_COUNTER + kind - 1, False)

    @contextlib.contextmanager
    def recorded(self, file: pathlib.Path) -> Iterator[pathlib.Path]:
        """`axisgate record` of what is done inside."""
        command = [sys.executable, "-m", "gateway", "record", "--slug", self.programs.run.name, "-o", str(file), "--json"]
        with (
            subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as recorder,
            contextlib.ExitStack() as ends,
        ):
            ends.callback(recorder.kill)  # whatever becomes of the test
            self.programs.watch("it records", lambda s: file.exists() and file.stat().st_size > 1000 and read(file).cycles > 0, 60.0)
            yield file
            recorder.send_signal(signal.SIGTERM)
            said, wrong = recorder.communicate(timeout=60)
        assert recorder.returncode == 0, f"{said}\n{wrong}"

    def snapshots(self, seconds: float = 20.0) -> list[CellState]:
        """States of the cycle, each whole, from the moment the program is taken until it is over."""
        self.programs.watch("the program is taken", lambda state: state.motion is Motion.RUNNING, seconds)
        found: list[CellState] = []

        def seen(state: CellState) -> bool:
            found.append(state)
            return state.motion is Motion.IDLE

        self.programs.watch("at rest", seen, seconds)
        return found


@contextlib.contextmanager
def belt_run(
    folder: pathlib.Path, programs: dict[int, str], name: str = "belts", change: Callable[[str], str] = with_belts
) -> Iterator[BeltRun]:
    """change: of the portal's cell file."""
    with program_run(folder, "portal", programs, name, change) as run, contextlib.closing(BeltRun(run)) as found:
        run.ready()
        yield found
