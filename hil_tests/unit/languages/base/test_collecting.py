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
