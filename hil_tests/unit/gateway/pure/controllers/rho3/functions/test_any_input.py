"""Whatever the PLC and the operator do: nothing raises, the panel keeps its shape, only the functions' own bits change."""

from hypothesis import given
from hypothesis import strategies as st

from gateway.pure.controllers.rho3.functions.addresses import Places
from gateway.pure.controllers.rho3.functions.display import Layer
from gateway.pure.image.records.cell import RC_BYTES, Quality
from hil_tests.unit.gateway.pure.controllers.rho3.functions.plant import Plant

PLACES = Places()
BITS = [35, 49, 56, 57, 58, 59, 60, 80, 81, 83, 85, 88, 89, 90, 104, 105, 464, 471, 562]
OWN = {104, 108, 109, 115, 116, 117, 118, 119, 120, 121, *range(152, 168)}
ACTS = st.one_of(
    st.tuples(st.just("bit"), st.sampled_from(BITS), st.booleans()),
    st.tuples(st.just("key"), st.integers(0, 9), st.just(True)),
    st.tuples(st.just("quality"), st.sampled_from([4, 6, 7, 10, 11, 13, 58]), st.booleans()),
    st.tuples(st.just("wait"), st.integers(1, 30), st.just(True)),
    st.tuples(st.just("error"), st.sampled_from([1, 91, 528, 3716]), st.just(True)),
    st.tuples(st.just("write"), st.integers(1, 4), st.booleans()),
    st.tuples(st.just("scroll"), st.just(0), st.just(True)),
)


def act(plant: Plant, what: str, number: int, value: bool) -> None:
    match what:
        case "bit":
            plant.put(number, value)
        case "key":
            plant.functions.press(str(number))
        case "quality":
            plant.inputs.quality[number] = Quality.GOOD if value else Quality.BAD
        case "wait":
            plant.cycle(number)
        case "error":
            plant.errors.report(number, "x", plant.now, source="rho3")
        case "write":
            plant.display.write(Layer.STANDARD if value else Layer.WRITE, number, "x" * (15 + number * 3))
        case _:
            plant.functions.statuses.scroll()


@given(st.lists(ACTS, max_size=40))
def test_any_sequence_keeps_the_rules(acts: list[tuple[str, int, bool]]) -> None:
    plant = Plant()
    plant.outputs[:] = b"\xa5" * RC_BYTES
    for what, number, value in acts:
        act(plant, what, number, value)
        plant.cycle()
        assert [len(line) for line in plant.display.screen()] == [20] * 4
        assert not (plant.out(PLACES.error_strobe) is False and any(plant.out(bit) for bit in range(152, 168)))
    for bit in range(RC_BYTES * 8):
        if bit not in OWN:
            assert plant.out(bit) == bool(0xA5 >> (bit & 7) & 1), bit


def test_a_code_of_a_lost_source_beside_a_living_strobe_is_refused() -> None:
    plant = Plant()
    plant.start("PROGXY")
    for byte in (7, 11, 13):
        plant.inputs.quality[byte] = Quality.STALE
    plant.number(88, 8, 2).put(83).number(104, 8, 1).number(56, 4, 4).cycle()
    plant.put(80).put(85).put(49).cycle()
    assert plant.refused == ["not_good", "not_good"]
    assert plant.outs(108, 109, 116, 117) == [109, 117]
    assert (plant.names(), plant.functions.phg.mode) == (["PROGXY"], "0")
