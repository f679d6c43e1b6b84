"""Values by name: who has one, who may write one, what is valid now."""

from collections.abc import Iterator

import pytest

from gateway.cell_file.load import load_cell
from gateway.pure.image.records.cell import AxisFlag, Quality
from hil_tests.lab.virtual.cell_bench import DEMO
from hil_tests.lab.virtual.source_bench import SourceBench

HOST = load_cell("host-telegrams")


@pytest.fixture
def bench() -> Iterator[SourceBench]:
    made = SourceBench(HOST)
    made.publish(AxisFlag.ENABLED, motion=2)
    yield made
    made.close()


def test_names_of_every_provider_are_read_in_one_place(bench: SourceBench) -> None:
    values = bench.values
    values.write("order.number", 42, 1, "test")
    bench.image.put_bit(24, True)
    assert [values.read(name) for name in ("order.number", "cell.motion", "axis.A1.enabled", "A 3.0", "AB 3")] == [42, 2.0, 1.0, 1, 1]
    assert {"order.number", "cell.motion", "axis.A1.actual"} <= set(values.names())


@pytest.mark.parametrize("name", ["order.unknown", "axis.Z9.actual", "cell.nothing", "T 5", "DB77.DW0", "nonsense"])
def test_an_unknown_name_is_a_key_error_and_has_no_current_value(bench: SourceBench, name: str) -> None:
    with pytest.raises(KeyError):
        bench.values.read(name)
    assert bench.values.current(name) is None


@pytest.mark.parametrize("name", ["cell.motion", "axis.A1.actual", "RC out 1.0", "EW 2"])
def test_values_others_own_are_read_only(bench: SourceBench, name: str) -> None:
    with pytest.raises(KeyError):
        bench.values.write(name, 1, 0, "test")


def test_only_valid_values_are_current(bench: SourceBench) -> None:
    values = bench.values
    values.write("order.number", 42, 1, "plc/ORDER")
    assert (values.current("order.number"), values.current("cell.motion")) == (42.0, 2.0)
    values.named.source_gone("plc")
    bench.image.cycle_lives = lambda: False
    assert (values.current("order.number"), values.current("cell.motion")) == (None, None)
    assert values.read("order.number") == 42, "the last value can still be read"


def test_a_text_is_no_number_for_words_and_registers(bench: SourceBench) -> None:
    bench.values.write("order.pattern", "AB", 1, "test")
    assert bench.values.read("order.pattern") == "AB"
    assert (bench.values.number("order.pattern"), bench.values.current("order.pattern")) == (0.0, None)


def test_an_rc_input_without_an_owner_is_written_by_name_and_one_with_an_owner_is_not() -> None:
    bench = SourceBench(DEMO)
    bench.values.write("A 5.1", 1, 9, "program")
    assert bench.image.input_bit(41) and bench.image.inputs.quality[5] == Quality.GOOD and bench.passed_on == 1
    with pytest.raises(KeyError):
        bench.values.write("A 3.1", 1, 9, "program")
    assert not bench.image.input_bit(25)
    bench.close()


def test_listeners_hear_of_each_write_of_a_named_value(bench: SourceBench) -> None:
    heard: list[int] = []
    bench.values.listen(lambda: heard.append(1))
    bench.values.write("order.number", 1, 1, "test")
    assert heard == [1]
