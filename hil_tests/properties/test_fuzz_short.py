"""The short form of `make fuzz`, and proof that it finds what is broken."""

from collections.abc import Callable

import pytest

from hil_tests.fuzz.player import Target, held, mutated, play
from hil_tests.fuzz.targets import PDUS, TARGETS, Server, _mbap, _tcp_works
from protocols.base.machine import Ns
from protocols.modbus.mbap import Event, Framing

ROUNDS = 12


@pytest.mark.parametrize("target", TARGETS, ids=lambda target: target.name)
def test_bad_input_breaks_nothing(target: Target) -> None:
    for n in range(ROUNDS):
        play(target, f"{target.name}/short/{n}")


class Raises(Framing):
    def receive(self, data: bytes, now: Ns) -> list[Event]:
        return super().receive(data, now) if data[:1] != b"\xff" else [].pop()


class Grows(Framing):
    def __init__(self) -> None:
        super().__init__()
        self.kept: list[bytes] = []

    def receive(self, data: bytes, now: Ns) -> list[Event]:
        self.kept.append(data * 200)
        return super().receive(data, now)


class StandsStill(Framing):
    def wake(self, now: Ns) -> list[Event]:
        return []


class GoesDeaf(Framing):
    """Forgets that a connection was closed for a bad length, and never closes it."""

    def receive(self, data: bytes, now: Ns) -> list[Event]:
        self._closed = self._closed or b"\xff\xff\xff" in data
        return super().receive(data, now)


@pytest.mark.parametrize(
    "framing, words", [(Raises, "IndexError"), (Grows, "holds"), (StandsStill, "stands still"), (GoesDeaf, "not answered")]
)
def test_what_is_broken_is_found(framing: Callable[[], Framing], words: str) -> None:
    corpus = [*(_mbap(pdu) for pdu in PDUS), b"\xff\xff\xff"]
    broken = Target("broken", lambda: Server(framing(), line=False), corpus, _tcp_works)
    found = []
    for n in range(60):
        try:
            play(broken, f"broken/1/{n}")
        except AssertionError as error:
            found.append(str(error))
    assert any(words in find for find in found), found


def test_a_round_is_played_again_by_its_name() -> None:
    import random

    first = [mutated(random.Random(f"x/1/{n}"), [b"abc"]) for n in range(50)]
    assert first == [mutated(random.Random(f"x/1/{n}"), [b"abc"]) for n in range(50)] and len(set(first)) > 20
    assert held({"a": b"1234", "b": [1, 2, "xy"]}) > 8
