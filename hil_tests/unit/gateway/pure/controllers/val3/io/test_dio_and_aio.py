"""dio and aio on the process image.  VAL 3 reference manual: L2296-2564, L6645."""

from collections.abc import Callable

import pytest

from gateway.pure.controllers.pic_image import PicImage
from gateway.pure.controllers.val3.io.system import Board, Health, IoSystem, Point, RunTimeFault
from gateway.pure.controllers.val3.io.variables import Aio, CompileFault, Dio, Instructions
from gateway.pure.image.records.cell import set_bit

FIRST = 88 * 8


class Cell:
    """Four inputs, four outputs, three analog points on one board."""

    def __init__(self) -> None:
        self.image, self.board = PicImage(), Board("BasicIO-1")
        points = [Point(f"i{n}", self.board, "Inputs", f"%I{n}", False, FIRST + n, description=f"part at place {n}") for n in range(4)]
        points += [Point(f"o{n}", self.board, "Outputs", f"%Q{n}", True, FIRST + n) for n in range(4)]
        points += [
            Point("command", self.board, "Analog", "%QW0", True, byte=100, steps=10, low=-20.0, high=20.0, description="Kraft, Sollwert"),
            Point("count", self.board, "Analog", "%QW1", True, byte=102, steps=1, low=0.0, high=100.0, integer=True),
            Point("sensor", self.board, "Analog", "%IW0", False, byte=104, steps=100, low=-10.0, high=10.0),
        ]
        self.system = IoSystem(self.image, points)
        self.do = Instructions(self.system)

    def input(self, number: int, value: bool) -> None:
        set_bit(self.image.inputs, FIRST + number, value)

    def outputs(self) -> list[bool]:
        return [self.image.output(FIRST + n) for n in range(4)]


def outputs() -> list[Dio]:
    return [Dio(f"o{n}") for n in range(4)]


@pytest.mark.requirement("VAL-DIO-01", by="gateway.pure.controllers.val3.io.system:IoSystem.usable")
def test_reading_or_writing_something_unlinked_is_123() -> None:
    cell = Cell()
    actions: tuple[Callable[[], object], ...] = (
        lambda: cell.do.value(Dio()),
        lambda: cell.do.assign(Dio(), True),
        lambda: cell.do.value(Dio("nowhere")),
        lambda: cell.do.dio_get([Dio("i0"), Dio()]),
        lambda: cell.do.dio_set([Dio("o0"), Dio()], 1),
        lambda: cell.do.value(Dio("sensor")),
    )
    for action in actions:
        with pytest.raises(RunTimeFault) as fault:
            action()
        assert fault.value.code == 123
    assert not any(cell.image.outputs)
    with pytest.raises(RunTimeFault, match="not linked"):
        cell.system.usable(None)
    with pytest.raises(RunTimeFault, match="nowhere"):
        cell.system.usable("nowhere")
    cell.board.health = Health.FAULT
    codes = []
    for link in ("i0", "nowhere"):
        with pytest.raises(RunTimeFault) as fault:
            cell.system.usable(link)
        codes.append(fault.value.code)
    assert codes == [125, 123]


@pytest.mark.requirement("VAL-DIO-01", by="gateway.pure.controllers.val3.io.system:IoSystem.writable")
def test_writing_an_input_is_122() -> None:
    cell = Cell()
    actions: tuple[Callable[[], object], ...] = (
        lambda: cell.do.assign(Dio("i0"), True),
        lambda: cell.do.dio_set([Dio("o0"), Dio("i1")], 3),
    )
    for action in actions:
        with pytest.raises(RunTimeFault, match="122") as fault:
            action()
        assert fault.value.code == 122
    assert not any(cell.image.inputs) and not any(cell.image.outputs)


@pytest.mark.requirement("VAL-DIO-02", by="gateway.pure.controllers.val3.io.variables:Instructions.dio_link")
def test_dio_link_after_a_look_at_the_status() -> None:
    cell = Cell()
    signal, device = Dio("i0"), Dio("i1")
    cell.input(1, True)
    assert not cell.do.value(signal)
    if cell.do.io_status(device) >= 0:
        cell.do.dio_link(signal, device)
    assert cell.do.value(signal)
    cell.input(1, False)
    assert not cell.do.value(signal)
    cell.do.dio_link(signal, Dio())
    assert cell.do.io_status(signal) == -1


@pytest.mark.requirement("VAL-DIO-03", by="gateway.pure.controllers.val3.io.variables:Instructions.dio_get")
def test_dio_get() -> None:
    cell = Cell()
    for number, value in enumerate((False, True, False, True)):
        cell.input(number, value)
    assert cell.do.dio_get([Dio(f"i{n}") for n in range(4)]) == 10
    assert cell.do.dio_get([Dio("i1")]) == 1


@pytest.mark.requirement("VAL-DIO-04", by="gateway.pure.controllers.val3.io.variables:Instructions.dio_set")
def test_dio_set() -> None:
    cell = Cell()
    assert cell.do.dio_set(outputs(), 10) == 10 and cell.outputs() == [False, True, False, True]
    assert cell.do.dio_set(outputs(), 26) == 10 and cell.outputs() == [False, True, False, True]
    assert cell.do.dio_set(outputs(), 5.9) == 5 and cell.outputs() == [True, False, True, False]
    assert cell.do.dio_set(outputs(), 0) == 0 and cell.outputs() == [False] * 4


@pytest.mark.requirement("VAL-DIO-05", by="gateway.pure.controllers.val3.io.variables:Instructions.assign")
def test_an_assignment_returns_the_bool_and_dio_to_dio_is_none() -> None:
    cell = Cell()
    assert cell.do.assign(Dio("o2"), True) is True and cell.outputs() == [False, False, True, False]
    assert cell.do.assign(Dio("o2"), False) is False and cell.outputs() == [False] * 4
    with pytest.raises(CompileFault, match="diIn == true"):
        cell.do.assign(Dio("o2"), Dio("i0"))
    cell.input(0, True)
    assert cell.do.assign(Dio("o2"), cell.do.value(Dio("i0")) is True) and cell.outputs()[2]


@pytest.mark.requirement("VAL-DIO-05", by="gateway.pure.controllers.val3.io.variables:Instructions.assign")
def test_an_assignment_gives_its_condition_on_whatever_the_output_does_and_refuses_a_dio_before_it_writes() -> None:
    """L2304: it assigns the condition and returns it; L2314: = between two dio has gone, (diIn == true) stands for it."""
    cell = Cell()
    cell.system.lock("o1", True)
    assert cell.do.assign(Dio("o1"), True) is True and cell.outputs() == [False] * 4, "a locked output stays, if(diOut = true) is true"
    chained = cell.do.assign(Dio("o3"), cell.do.assign(Dio("o0"), True))
    assert chained is True and cell.outputs() == [True, False, False, True]
    for source in (Dio("i0"), Dio("o2"), Dio()):
        with pytest.raises(CompileFault) as refused:
            cell.do.assign(Dio("o0"), source)
        assert "diOut = (diIn == true)" in str(refused.value)
        assert cell.outputs() == [True, False, False, True], "nothing was written"
    for level in (True, False, True):
        cell.input(2, level)
        assert cell.do.assign(Dio("o2"), cell.do.value(Dio("i2")) is True) is level and cell.outputs()[2] is level
    with pytest.raises(RunTimeFault) as unlinked:
        cell.do.assign(Dio(), True)
    assert unlinked.value.code == 123


@pytest.mark.requirement("VAL-DIO-06", by="gateway.pure.controllers.val3.io.system:IoSystem.status")
def test_io_status() -> None:
    cell = Cell()
    cell.system.lock("i1", True)
    cell.system.simulate("i2", 1)
    variables: list[Dio | Aio] = [Dio("i0"), Dio("i1"), Dio("i2"), Dio(), Dio("nowhere"), Aio("sensor"), Aio(), Aio("x")]
    assert [cell.do.io_status(variable) for variable in variables] == [0, 1, 2, -1, -2, 0, -1, -2]
    cell.board.health = Health.FAULT
    assert [cell.do.io_status(variable) for variable in variables] == [-3, -3, -3, -1, -2, -3, -1, -2]
    with pytest.raises(RunTimeFault) as fault:
        cell.do.value(Dio("i0"))
    assert fault.value.code == 125
    cell.board.health = Health.ABSENT
    assert cell.do.io_status(Dio("i0")) == -2


@pytest.mark.requirement("VAL-DIO-07", by="gateway.pure.controllers.val3.io.system:IoSystem.lock")
def test_a_locked_output_ignores_writes_and_a_locked_input_is_frozen() -> None:
    cell = Cell()
    cell.system.lock("o1", True)
    assert cell.do.assign(Dio("o1"), True) is True
    assert cell.outputs() == [False] * 4 and cell.do.value(Dio("o1")) is False and cell.do.io_status(Dio("o1")) == 1
    assert cell.do.dio_set(outputs(), 15) == 15 and cell.outputs() == [True, False, True, True]
    cell.input(0, True)
    cell.system.lock("i0", True)
    cell.input(0, False)
    assert cell.do.value(Dio("i0"))
    cell.system.lock("i0", False)
    cell.system.lock("o1", False)
    cell.do.assign(Dio("o1"), True)
    assert not cell.do.value(Dio("i0")) and cell.outputs() == [True] * 4


@pytest.mark.requirement("VAL-DIO-07", by="gateway.pure.controllers.val3.io.system:IoSystem.put")
def test_a_simulated_output_reaches_no_device() -> None:
    cell = Cell()
    cell.system.simulate("o1", 0)
    cell.do.assign(Dio("o1"), True)
    assert cell.do.value(Dio("o1")) and not cell.outputs()[1]
    cell.system.simulate("o1", None)
    assert not cell.do.value(Dio("o1"))
    cell.do.assign(Dio("o1"), True)
    assert cell.outputs() == [False, True, False, False]


@pytest.mark.requirement("VAL-DIO-08", by="gateway.pure.controllers.val3.io.variables:Instructions.io_description")
def test_description_and_path() -> None:
    cell = Cell()
    cell.system.lock("i3", True)
    assert cell.do.io_description(Dio("i3")) == (1, "part at place 3", "BasicIO-1\\Inputs\\%I3")
    assert cell.do.io_description(Aio("command")) == (0, "Kraft, Sollwert", "BasicIO-1\\Analog\\%QW0")
    assert cell.do.io_description(Dio()) == (-1, "", "")
    cell.board.health = Health.FAULT
    assert cell.do.io_description(Dio("o0")) == (-3, "", "BasicIO-1\\Outputs\\%Q0")


@pytest.mark.requirement("VAL-AIO-01", by="gateway.pure.controllers.val3.io.variables:Instructions.aio_set")
def test_aio_set_at_float_and_integer_outputs() -> None:
    cell = Cell()
    assert cell.do.aio_set(Aio("command"), -12.3) == -12.3 == cell.do.aio_get(Aio("command"))
    assert cell.image.outputs[100:102] == (-123).to_bytes(2, "little", signed=True)
    assert cell.do.aio_set(Aio("count"), 12.3) == 12 == cell.do.aio_get(Aio("count"))
    assert cell.image.outputs[102:104] == b"\x0c\0"


@pytest.mark.requirement("VAL-AIO-02", by="gateway.pure.controllers.val3.io.variables:Instructions.aio_set")
def test_aio_set_out_of_range_and_unlinked() -> None:
    cell = Cell()
    cell.do.aio_set(Aio("command"), 7.5)
    for value in (20.1, -20.1, float("nan")):
        assert cell.do.aio_set(Aio("command"), value) == 7.5 == cell.do.aio_get(Aio("command"))
    assert cell.do.aio_set(Aio("count"), float("inf")) == 0.0 == cell.do.aio_set(Aio("count"), float("nan"))
    for code, variable in ((123, Aio()), (122, Aio("sensor"))):
        with pytest.raises(RunTimeFault) as fault:
            cell.do.aio_set(variable, 1.0)
        assert fault.value.code == code


@pytest.mark.requirement("VAL-AIO-02", by="gateway.pure.controllers.val3.io.variables:Instructions.aio_get")
def test_aio_get() -> None:
    cell = Cell()
    cell.image.inputs[104:106] = (-250).to_bytes(2, "little", signed=True)
    mine = Aio()
    with pytest.raises(RunTimeFault) as fault:
        cell.do.aio_get(mine)
    assert fault.value.code == 123
    cell.do.aio_link(mine, Aio("sensor"))
    assert cell.do.aio_get(mine) == -2.5
