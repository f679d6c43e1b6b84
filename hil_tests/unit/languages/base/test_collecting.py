"""The collector of cycles rests while a program is read, and is as before afterwards."""

import gc
from collections.abc import Iterator

import pytest

from gateway.pure.languages.base.collecting import uncollected


@pytest.fixture
def searched() -> Iterator[None]:
    before = gc.isenabled()
    yield
    (gc.enable if before else gc.disable)()


@pytest.mark.usefixtures("searched")
@pytest.mark.parametrize("before", [True, False])
def test_the_collector_is_as_before_behind_it_and_behind_a_failure(before: bool) -> None:
    (gc.enable if before else gc.disable)()
    with uncollected():
        assert not gc.isenabled()
    assert gc.isenabled() is before
    with pytest.raises(ValueError, match="misread"), uncollected():
        raise ValueError("misread")
    assert gc.isenabled() is before


@pytest.mark.usefixtures("searched")
def test_what_was_made_is_not_among_the_young_objects() -> None:
    gc.enable()
    with uncollected():
        made = [[at] for at in range(50_000)]
        assert _young() >= len(made)
    assert _young() < len(made) / 10


def _young() -> int:
    """Objects that the next collections look through: those of generation 0, and of 1 where they go from there."""
    return len(gc.get_objects(generation=0)) + len(gc.get_objects(generation=1))
