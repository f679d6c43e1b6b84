"""Devices and files of the dry run: READ, WRITE, the file orders and CONDITION (spec 1.3-1.7, 5.3)."""

from gateway.pure.languages.baps2 import demands, filing, forms
from gateway.pure.languages.baps2.errors import fault
from gateway.pure.languages.baps2.feed import UnitFeed
from gateway.pure.languages.baps2.machine import Machine
from gateway.pure.languages.baps2.standard import DEVICES
from gateway.pure.languages.baps2.tasks import Task
from gateway.pure.languages.baps2.typing import signal_place
from gateway.pure.languages.baps2.units import Device, Incomplete
from gateway.pure.languages.base.requests import PENDING, Request, RuntimeFault

LONGEST_BLOCK, WRONG_LENGTH = 138, -8  # characters that 3964R sends in one WRITE (L1938, AX-169)
NO_INTERFACE = -1
PANEL = "PHG"  # is always there
NAME_LETTERS = 8


class Outside:
    """Answers what concerns devices and files."""

    def __init__(self, machine: Machine, *, seen: bool = False) -> None:
        """`seen`: an operator watches the panel while a program reads from it."""
        self._machine, self._seen = machine, seen
        machine.devices.setdefault(PANEL, Device(UnitFeed()))

    def answer(self, task: Task, request: Request) -> object:
        """PENDING where a device has not sent enough yet."""
        match request:
            case demands.ReadDevice():
                return self._read(task, request)
            case demands.WriteDevice():
                return self._write(task, request)
            case demands.FileAction():
                return self._order(task, request)
            case demands.Condition():
                return self.condition(task, request)
        raise TypeError(f"no answer to {request}")

    def place(self, task: Task, unit: str) -> tuple[str, bool]:
        """Name of the device or file of a unit, and whether it is a device."""
        name = task.names.get(unit)
        if name is None:
            if unit in DEVICES:
                return unit, True
            kind = task.unit.files.get(unit)
            name = f"{unit[:NAME_LETTERS]}.{'BNR' if kind is not None and is_binary(kind.base, kind.element) else 'DAT'}"
        return name, name in DEVICES

    # ---- devices

    def _device(self, task: Task, name: str) -> Device | None:
        """Return the device; None where there is no interface and the program continues (SER_IO_STOP -)."""
        device = self._machine.devices.get(name)
        if device is None:
            self._device_fault(task, name, NO_INTERFACE, fault(212, f"{name} has no interface"))
        return device

    def _device_fault(self, task: Task, name: str, code: int, error: RuntimeFault) -> None:
        if task.unit.program.head.serial_stop:
            raise error
        task.conditions[name] = code

    def _read(self, task: Task, request: demands.ReadDevice) -> object:
        if request.base in ("POINT", "JC_POINT") and not request.size:
            sizes = [len(lane.position) for lane in self._machine.lanes.values() if lane.position]
            sizes += [len(start) for start in self._machine.feed.start.values()]
            if not sizes:
                raise fault(220, "the program names no components")
            request = demands.ReadDevice(request.unit, request.base, sizes[0], request.count)
        name, is_device = self.place(task, request.unit)
        return self._read_device(task, name, request) if is_device else self._read_file(task, name, request)

    def _read_device(self, task: Task, name: str, request: demands.ReadDevice) -> object:
        device = self._device(task, name)
        if device is None:
            return None
        if self._seen and name == PANEL and (held := task.held.pop(name, b"")):  # the question (L5760-5762, AX-1749)
            self._machine.event(task, "write", task.process.line, device=name, hex=held.hex())
        device.take_in(self._machine.now)
        try:
            value = device.read(request.base, request.size, request.count)
        except Incomplete:
            return PENDING
        except forms.BadForm as bad:
            self._device_fault(task, name, bad.code, fault(201))
            return None
        task.conditions[name] = 0
        return value

    def _write(self, task: Task, request: demands.WriteDevice) -> object:
        name, is_device = self.place(task, request.unit)
        return self._write_device(task, name, request) if is_device else self._write_file(task, name, request)

    def _write_device(self, task: Task, name: str, request: demands.WriteDevice) -> object:
        device = self._device(task, name)
        if device is None:
            return None
        data = task.held.pop(name, b"") + b"".join(forms.encode(base, value, binary=device.binary) for base, value in request.items)
        if request.open:
            task.held[name] = data
            return None
        if device.binary and len(data) > LONGEST_BLOCK:
            self._device_fault(task, name, WRONG_LENGTH, fault(212, f"{name}: Incorrect character string length"))
            return None
        task.conditions[name] = 0
        self._machine.event(task, "write", task.process.line, device=name, hex=data.hex())
        return None

    def condition(self, task: Task, request: demands.Condition) -> int:
        """CONDITION: a unit's last fault, whether a file is there, or a signal."""
        if request.signal:
            place = signal_place(request.unit)
            if place is None:
                raise fault(206, request.unit)
            letter, byte, bit = place
            return self._machine.image(letter, byte * 8 + bit)
        name, is_device = self.place(task, request.unit)
        if is_device:
            return NO_INTERFACE if name not in self._machine.devices else task.conditions.get(name, 0)
        stored = task.main.conditions.pop(f"file {request.unit}", 0)
        return stored or (0 if name in self._machine.filing.files or self._machine.filing.is_open(name) else -1)

    # ---- files

    def _owners(self, task: Task) -> list[int]:
        """The process and its main process, whose files branches may use."""
        return list(dict.fromkeys((task.process.number, task.main.process.number)))

    def _file_fault(self, task: Task, unit: str, error: RuntimeFault) -> None:
        if task.unit.program.head.file_error:
            raise error
        task.main.conditions[f"file {unit}"] = -1

    def _binary(self, task: Task, unit: str) -> bool:
        kind = task.unit.files.get(unit)
        return kind is not None and is_binary(kind.base, kind.element)

    def _opened(self, task: Task, name: str, unit: str, writing: bool) -> filing.Opened | None:
        """The open file; opened here where the program did not (L5741)."""
        files, owner = self._machine.filing, task.process.number
        found = files.opened(name, self._owners(task), writing)
        if found is None:
            if writing and files.opened(name, [owner], writing=False) is not None:
                raise fault(214, name)  # to open it anew would delete what it has
            if writing:
                files.begin_writing(name, owner, 0, self._binary(task, unit))
            else:
                files.begin_reading(name, owner, 0, self._binary(task, unit))
            found = files.opened(name, [owner], writing)
        return found

    def _read_file(self, task: Task, name: str, request: demands.ReadDevice) -> object:
        binary = self._binary(task, request.unit)
        try:
            opened = self._opened(task, name, request.unit, writing=False)
            if opened is None:
                return None
            if request.count and request.base == "CHAR" and not binary:
                return list(str(filing.read(opened, "TEXT", 0, False))[: request.count].ljust(request.count))
            if request.count:
                return [filing.read(opened, request.base, request.size, binary) for _ in range(request.count)]
            return filing.read(opened, request.base, request.size, binary)
        except forms.BadForm:
            self._file_fault(task, request.unit, fault(201, name))
        except RuntimeFault as error:
            self._file_fault(task, request.unit, error)
        return None

    def _write_file(self, task: Task, name: str, request: demands.WriteDevice) -> object:
        binary = self._binary(task, request.unit)
        try:
            opened = self._opened(task, name, request.unit, writing=True)
        except RuntimeFault as error:
            self._file_fault(task, request.unit, error)
            return None
        if opened is not None:
            for base, value in request.items:
                opened.data += forms.encode(base, value, binary=binary, file=True)
            if not binary and not request.open:
                opened.data += filing.LINE_END
        return None

    def _order(self, task: Task, request: demands.FileAction) -> object:
        if request.word == "ASSIGN":
            return self._assign(task, request)
        name, is_device = self.place(task, request.unit)
        if is_device:
            self._clear(task, name, request.word)
            return None
        files, owner, binary = self._machine.filing, task.process.number, self._binary(task, request.unit)
        offset = request.value if isinstance(request.value, int) else 0
        try:
            match request.word:
                case "READ_BEGIN":
                    files.begin_reading(name, owner, offset, binary)
                case "WRITE_BEGIN":
                    files.begin_writing(name, owner, offset, binary)
                case "WRITE_END":
                    files.begin_writing(name, owner, None, binary)
                case _:
                    files.close(name, owner)
        except RuntimeFault as error:
            self._file_fault(task, request.unit, error)
        return None

    def _clear(self, task: Task, name: str, word: str) -> None:
        """READ_BEGIN and WRITE_BEGIN on a device (L7777-7838)."""
        device = self._device(task, name)
        if device is None:
            return
        if word == "READ_BEGIN":
            device.take_in(self._machine.now)
            device.clear()
        elif word == "WRITE_BEGIN":
            task.held.pop(name, None)
        task.conditions[name] = 0

    def _assign(self, task: Task, request: demands.FileAction) -> object:
        old, is_device = self.place(task, request.unit)
        name = filing.file_name(str(request.value))
        if name is None:
            self._file_fault(task, request.unit, fault(202, repr(request.value)))
        elif not is_device and self._machine.filing.is_open(old):
            self._file_fault(task, request.unit, fault(1057, old))
        else:
            task.main.conditions.pop(f"file {request.unit}", None)
            task.names[request.unit] = name
        return None

    def at_end(self, task: Task, unit: str) -> bool:
        """END_OF_FILE."""
        name, _ = self.place(task, unit)
        opened = self._machine.filing.opened(name, self._owners(task), writing=False)
        if opened is None:
            raise fault(63, name)
        return opened.place >= len(opened.data)


def is_binary(base: str, element: str) -> bool:
    """Whether a declared file is a BNR file (L6867-6890)."""
    return base == "BNR_FILE" or element not in ("", "CHAR")
