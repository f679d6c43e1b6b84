"""PHG 2000 variables of processes and files.  Source: rho 3 Releases L9429-9460, L10182-10338; rho3 3.8, AX-542."""

from collections.abc import Sequence
from dataclasses import dataclass

from gateway.pure.controllers.rho3.functions.messages import say
from gateway.pure.controllers.rho3.functions.processes import Kind, Process, ProcessTable, State

NORMAL, PERMANENT, SUB, INCORRECT, PROCESS_LIST, SELECTED, STOP_PROCESS = 34305, 34306, 34307, 34308, 34309, 34310, 34322
FILES, FILES_SIZE, FILES_DATE, FILES_NAME, CURSOR, CONTROL, MEMORY, AVAILABLE, USED, FREE = range(34561, 34571)
_COUNTED = {NORMAL: Kind.NORMAL, PERMANENT: Kind.PERMANENT, SUB: Kind.SUB}
_ERROR_TEXT = 20  # characters (L10314)


class VariableError(Exception):
    """No such variable, index or access; nothing was done."""


@dataclass(frozen=True, slots=True)
class FileEntry:
    """A file as the list shows it; day as 24.09.95, time as 09:40."""

    name: str
    size: int
    day: str
    time: str


class SystemVariables:
    """Reads and writes by code number; list lines count from 1, lines after the last one are empty."""

    def __init__(self, processes: ProcessTable, files: Sequence[FileEntry] = (), memory: int = 131072, language: str = "en") -> None:
        self.files = tuple(files)
        self.memory = memory  # bytes in all
        self.cursor, self.control = 1, 0
        self._selected = 0  # number of a process, not its line: the selection stays when the list moves up
        self._processes, self._language = processes, language

    def read(self, code: int, index: int = 1) -> int | str:
        """Value of a variable; raises VariableError."""
        if code in _COUNTED:
            return sum(process.kind is _COUNTED[code] for process in self._processes.processes)
        if code == INCORRECT:
            return sum(process.state is State.FAULTY for process in self._processes.processes)
        if code == PROCESS_LIST:
            names = [process.name for process in self._processes.processes]
            return _line(names, index, 100)
        if SELECTED <= code < STOP_PROCESS:
            return self._selected_line() if code == SELECTED else self._of_process(code)
        if FILES <= code <= FREE:
            return self._of_files(code, index)
        raise VariableError(f"{code}: no such variable, or it is not read")

    def write(self, code: int, value: int) -> None:
        """Select a process by its line, stop the selected one (1 on pressing the key); raises VariableError."""
        if code == STOP_PROCESS:
            process = self._chosen()
            if value == 1 and process is not None:
                self._processes.stop(process.number)
        elif code == SELECTED and 1 <= value <= 100:
            processes = self._processes.processes
            self._selected = processes[value - 1].number if value <= len(processes) else 0
        else:
            raise VariableError(f"{code}: is not written, or not with {value}")

    def _chosen(self) -> Process | None:
        return self._processes.numbered(self._selected)

    def _selected_line(self) -> int:
        numbers = [process.number for process in self._processes.processes]
        return numbers.index(self._selected) + 1 if self._selected in numbers else 0

    def _of_process(self, code: int) -> int | str:
        """Variables 34311..34321 of the selected process; empty where there is none."""
        process = self._chosen()
        texts = {34311, 34313, 34314, 34316, 34321}
        if process is None:
            return "" if code in texts else 0
        values: dict[int, int | str] = {
            34311: say(process.kind.name, self._language),
            34312: process.priority,
            34313: say("STUCK" if process.stuck else process.state.name, self._language),
            34314: process.external,
            34315: process.level,
            34316: process.name,
            34317: process.line,
            34318: process.include_line,
            34319: process.kinematics,
            34320: process.error,
            34321: process.error_text[:_ERROR_TEXT].ljust(_ERROR_TEXT),
        }
        return values[code]

    def _of_files(self, code: int, index: int) -> int | str:
        used = sum(file.size for file in self.files)
        match code:
            case 34561 | 34562 | 34563 | 34564:
                return _line([_file_line(file, code) for file in self.files], index, 1000)
            case 34565 | 34566:
                return self.cursor if code == CURSOR else self.control
            case 34567:  # one string, as the example shows it (D-45)
                word = ("used", "free") if self._language == "en" else ("bel.", "frei")
                return f"{self.memory} Bytes {used:>8} {word[0]} {self.memory - used:>8} {word[1]}"
            case _:
                return {AVAILABLE: self.memory, USED: used, FREE: self.memory - used}[code]


def _line(lines: Sequence[str], index: int, most: int) -> str:
    if not 1 <= index <= most:
        raise VariableError(f"line {index}; 1 to {most}")
    return lines[index - 1] if index <= len(lines) else ""


def _file_line(file: FileEntry, code: int) -> str:
    """Columns as in the manual's list: `PHG_2001.PKT      848 Byte  24.09.95  09:40`."""
    size, date = f" {file.size:>8} Byte", f"  {file.day}  {file.time}"
    return f"{file.name:<12}" + {FILES: size + date, FILES_SIZE: size, FILES_DATE: date, FILES_NAME: ""}[code]
