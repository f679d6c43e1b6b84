"""AX-395: one route, step by step: levels, edges, debounce, rate, what is shown when the source is lost, marks."""

import math

import pytest

from gateway.assembly.routes import compile_route
from gateway.pure.cell.routes import Route as CellRoute
from gateway.pure.routes.route import Edge, Loss, Route, RouteSettings, RouteTable
from protocols.base.machine import ms


def play(settings: RouteSettings, *steps: tuple[int, float | None]) -> list[tuple[float | None, bool]]:
    """(ms, source) for each step; what the target shows after each."""
    route, shown = Route(settings), []
    for at, source in steps:
        route.step(ms(at), source)
        shown.append((route.value, route.valid))
    return shown


def test_a_level_follows_with_scale_and_offset_and_reports_when_it_changed() -> None:
    route = Route(RouteSettings("r", scale=0.1, offset=5.0))
    assert [route.step(ms(n), source) for n, source in enumerate((100.0, 100.0, 200.0))] == [True, False, True]
    assert (route.value, route.valid, route.life) == (25.0, True, 3)


def test_life_counts_living_steps_and_stands_still_while_lost() -> None:
    route = Route(RouteSettings("r"))
    for n in range(65537):
        route.step(n, 1.0)
    assert route.life == 1
    for n in range(5):
        route.step(n, None)
    assert route.life == 1 and not route.valid


@pytest.mark.parametrize(
    ("loss", "shown"),
    [
        (RouteSettings("r", loss=Loss.HOLD), [7.0, 7.0, 7.0]),
        (RouteSettings("r", loss=Loss.ZERO), [0.0, 0.0, 0.0]),
        (RouteSettings("r", loss=Loss.VALUE, loss_value=9.0, loss_after_ns=ms(20)), [7.0, 7.0, 9.0]),
    ],
)
def test_a_lost_source_is_shown_as_the_policy_says_and_always_marked(loss: RouteSettings, shown: list[float]) -> None:
    told = play(loss, (0, 7.0), (10, None), (29, None), (30, None), (40, 8.0))
    assert told == [(7.0, True), *((value, False) for value in shown), (8.0, True)]


def test_a_source_that_never_lived_shows_nothing_zero_or_the_value() -> None:
    assert play(RouteSettings("r"), (0, None)) == [(None, False)]
    assert play(RouteSettings("r", loss=Loss.ZERO), (0, None)) == [(0.0, False)]
    late = RouteSettings("r", loss=Loss.VALUE, loss_value=3.0, loss_after_ns=ms(5))
    assert play(late, (0, None), (4, None), (5, None)) == [(None, False), (None, False), (3.0, False)]


def test_no_number_is_no_source() -> None:
    assert play(RouteSettings("r"), (0, 1.0), (1, math.nan), (2, math.inf)) == [(1.0, True), (1.0, False), (1.0, False)]


def test_a_bouncing_source_counts_when_it_has_been_stable_long_enough() -> None:
    bounce = RouteSettings("r", debounce_ns=ms(10))
    told = play(bounce, (0, 0.0), (10, 0.0), (11, 1.0), (13, 0.0), (15, 1.0), (24, 1.0), (25, 1.0))
    assert [value for value, _ in told] == [None, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]


def test_what_was_set_before_a_loss_does_not_shorten_the_debounce_after_it() -> None:
    told = play(RouteSettings("r", debounce_ns=ms(10)), (0, 1.0), (10, 1.0), (20, None), (30, 1.0), (39, 1.0), (40, 1.0))
    assert told[3:] == [(1.0, False), (1.0, False), (1.0, True)]


def test_the_rate_limit_delays_and_never_swallows_the_last_value() -> None:
    told = play(RouteSettings("r", rate_ns=ms(100)), (0, 1.0), (10, 2.0), (20, 3.0), (99, 3.0), (100, 3.0), (150, 4.0), (200, 4.0))
    assert [value for value, _ in told] == [1.0, 1.0, 1.0, 1.0, 3.0, 3.0, 4.0]


@pytest.mark.parametrize(
    ("loss", "source", "shown"),
    [
        (
            Loss.HOLD,
            (1.0, 1.0, 0.0, 1.0),
            [None, None, 0.0, 1.0],
        ),  # a bit that is set when the source begins: nothing is started or stopped
        (Loss.HOLD, (0.0, 1.0, None, 1.0, 0.0), [0.0, 1.0, 1.0, 1.0, 0.0]),
        (Loss.HOLD, (0.0, 1.0, None, 0.0, 1.0), [0.0, 1.0, 1.0, 0.0, 1.0]),
        (Loss.HOLD, (0.0, None, 1.0, 0.0, 1.0), [0.0, 0.0, 0.0, 0.0, 1.0]),
        (Loss.ZERO, (0.0, 1.0, None, 1.0, 0.0, 1.0), [0.0, 1.0, 0.0, 0.0, 0.0, 1.0]),
    ],
)
def test_a_command_that_is_still_set_when_its_source_comes_starts_nothing(
    loss: Loss, source: tuple[float | None, ...], shown: list[float | None]
) -> None:
    written = play(RouteSettings("r", loss=loss, command=True), *enumerate(source))
    assert [value for value, _ in written] == shown


@pytest.mark.parametrize(("to", "command"), [("val3.run", True), ("val3.move", True), ("val3.hold", False), ("io.run", False)])
def test_starting_and_moving_are_commands_holding_is_none(to: str, command: bool) -> None:
    assert compile_route(CellRoute(name="run", from_="711", to=to), {}, {}).settings.command is command


@pytest.mark.parametrize(("edge", "first", "second"), [(Edge.RISING, 0.0, 1.0), (Edge.FALLING, 1.0, 0.0)])
def test_an_edge_is_one_pulse_however_long_the_bit_is_set(edge: Edge, first: float, second: float) -> None:
    told = play(
        RouteSettings("r", edge=edge, pulse_ns=ms(50)), (0, first), (10, second), (59, second), (60, second), (500, second), (510, first)
    )
    assert [value for value, _ in told] == [0.0, 1.0, 1.0, 0.0, 0.0, 0.0]


def test_a_bit_that_is_set_at_the_start_or_after_a_loss_gives_no_pulse() -> None:
    told = play(RouteSettings("r", edge=Edge.RISING), (0, 1.0), (1, 0.0), (2, None), (3, 1.0), (4, 0.0), (5, 1.0))
    assert [value for value, _ in told] == [0.0, 0.0, 0.0, 0.0, 0.0, 1.0]


def test_a_pulse_ends_with_its_source_and_inside_a_debounce() -> None:
    lost = play(RouteSettings("r", edge=Edge.RISING, pulse_ns=ms(50)), (0, 0.0), (1, 1.0), (2, None), (3, None))
    assert [value for value, _ in lost] == [0.0, 1.0, 0.0, 0.0]
    settings = RouteSettings("r", edge=Edge.RISING, pulse_ns=ms(5), debounce_ns=ms(10))
    bouncing = play(settings, (0, 0.0), (10, 0.0), (20, 1.0), (30, 1.0), (34, 0.0), (35, 1.0), (36, 0.0))
    assert [value for value, _ in bouncing] == [None, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0]


def test_a_change_is_passed_on_and_what_was_set_before_it_is_not() -> None:
    told = play(RouteSettings("r", edge=Edge.CHANGE, scale=2.0), (0, 5.0), (1, 5.0), (2, 6.0), (3, 6.0), (4, None), (5, 6.0), (6, 7.0))
    assert told == [(None, False), (None, False), (12.0, True), (12.0, True), (12.0, False), (12.0, False), (14.0, True)]


def test_a_value_that_does_not_fit_stays_out_is_marked_and_counted_once() -> None:
    route = Route(RouteSettings("r", low=0.0, high=255.0))
    shown = []
    for n, source in enumerate((255.0, 256.0, 300.0, 255.4, -1.0, 0.0)):
        route.step(n, source)
        shown.append((route.value, route.valid))
    assert shown == [(255.0, True), (255.0, False), (255.0, False), (255.0, False), (255.0, False), (0.0, True)]
    assert route.misfits == 1


def test_a_table_names_the_routes_that_changed() -> None:
    table = RouteTable([RouteSettings("a"), RouteSettings("b", loss=Loss.ZERO)])
    assert table.step(0, [1.0, 1.0]) == [0, 1]
    assert table.step(1, [1.0, None]) == [1]
    assert table.step(2, [1.0, None]) == []
    with pytest.raises(ValueError):
        table.step(3, [1.0])
