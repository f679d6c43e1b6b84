"""Feed bad input to a byte machine in virtual time: everything follows from the seed, so every find can be repeated.

A round is a new machine and a few dozen steps: mutated messages, garbage, damage, a lost port, time.  Then the line is quiet
and the machine must work again.  Judged: no exception, no deadline that stays in the past, bounded memory and output, no dead machine.
"""

import collections
import random
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

from protocols.base.machine import Damage, Machine, Ns, ms

STEPS = 40
MOST_WAKES = 2000  # at one moment: more is a deadline that does not move
PEACE: Ns = ms(60_000)  # after a round: every timer of every profile has run out
MOST_BYTES = 64 * 1024  # of one machine, with everything it holds
MOST_OUTPUT = 32 * 1024  # said to one step
CHUNK = 700


@dataclass(frozen=True, slots=True)
class Target:
    """What is fuzzed: a machine, messages to mutate, and how to see that it still works."""

    name: str
    make: Callable[[], Machine[Any]]
    corpus: Sequence[bytes]
    works: Callable[["Player"], None]  # AssertionError when it does not
    act: Callable[[Machine[Any], random.Random, Ns], object] = lambda machine, chance, now: None  # its owner's doing
    judge: Callable[[bytes], None] = lambda said: None  # of what it says
    on_event: Callable[[Machine[Any], object], None] = lambda machine, event: None


@dataclass
class Player:
    """One machine and its clock."""

    target: Target
    machine: Machine[Any]
    now: Ns = 0
    said: bytearray = field(default_factory=bytearray)
    told: list[object] = field(default_factory=list)
    log: list[str] = field(default_factory=list)

    def hears(self, data: bytes) -> None:
        self.log.append(f"hears {data.hex()}")
        self._note(self.machine.receive(data, self.now))

    def damaged(self, kind: Damage) -> None:
        self.log.append(f"damaged {kind.name}")
        self._note(self.machine.damaged(kind, self.now))

    def loses(self) -> None:
        self.log.append("lost")
        self._note(self.machine.lost(self.now))

    def kick(self) -> None:
        """Its owner gave it something to do."""
        self._note(())

    def passes(self, span: Ns) -> None:
        """Time; each deadline on the way is kept."""
        self.log.append(f"passes {span}")
        self.kick()
        until = self.now + span
        wakes, at = 0, self.now
        while (due := self.machine.deadline()) is not None and due <= until:
            moment = max(due, self.now)
            wakes = wakes + 1 if moment == at else 0
            at = moment
            assert wakes < MOST_WAKES, f"the deadline stands still at {due}"
            self.now = moment
            self._note(self.machine.wake(moment))
        self.now = until

    def take(self) -> bytes:
        """Return what it has sent since the last call."""
        said = bytes(self.said)
        self.said.clear()
        return said

    def _note(self, events: Iterable[object]) -> None:
        for event in events:
            self.told.append(event)
            self.target.on_event(self.machine, event)
        said = 0
        while output := self.machine.take_output():
            self.target.judge(output)
            said += len(output)
            assert said <= MOST_OUTPUT, f"says {said} bytes to one step"
            self.said += output
            for event in self.machine.sent(self.now):
                self.told.append(event)
                self.target.on_event(self.machine, event)


def mutated(chance: random.Random, corpus: Sequence[bytes]) -> bytes:
    """A message with something wrong, or garbage, or several glued together."""
    data = bytearray(chance.choice(corpus))
    for _ in range(chance.choice((0, 1, 1, 2, 5))):
        at = chance.randrange(len(data) + 1)
        match chance.randrange(7):
            case 0:
                data[at : at + 1] = bytes((chance.randrange(256),))
            case 1 if data:
                data[at % len(data)] ^= 1 << chance.randrange(8)
            case 2:
                data[at:at] = chance.randbytes(chance.choice((1, 2, 9, 300)))
            case 3:
                del data[at : at + chance.choice((1, 2, 50))]
            case 4:
                data[at:at] = chance.choice(corpus)
            case 5:
                data[at:at] = bytes((chance.choice((0x00, 0x02, 0x03, 0x10, 0x15, 0xFF)),)) * chance.choice((1, 3, 200))
            case _:
                del data[at:]
    return bytes(data[:CHUNK])


def held(thing: object, depth: int = 8) -> int:
    """Bytes and entries a machine holds, roughly: what would grow if something grew."""
    if isinstance(thing, bytes | bytearray | str):
        return len(thing)
    if depth == 0 or isinstance(thing, type) or callable(thing):
        return 1
    if isinstance(thing, dict | collections.Counter):
        return sum(held(key, depth - 1) + held(value, depth - 1) for key, value in thing.items())
    if isinstance(thing, list | tuple | set | frozenset | collections.deque):
        return len(thing) + sum(held(each, depth - 1) for each in thing)
    slots = [name for kind in type(thing).__mro__ for name in getattr(kind, "__slots__", ())]
    inside = [*getattr(thing, "__dict__", {}).values(), *(getattr(thing, name, None) for name in slots)]
    return 1 + sum(held(each, depth - 1) for each in inside)


def play(target: Target, seed: str) -> None:
    """One round.  AssertionError: the find, with the seed and the steps that led there."""
    chance = random.Random(seed)
    player = Player(target, target.make())
    try:
        for _ in range(chance.randrange(1, STEPS)):
            _step(player, chance)
        player.passes(PEACE)
        size = held(player.machine)
        assert size <= MOST_BYTES, f"holds {size} bytes"
        player.take()
        player.told.clear()
        target.works(player)
    except Exception as error:
        steps = "\n  ".join(player.log[-12:])
        raise AssertionError(f"{target.name}, round {seed!r}: {error!r}\n  {steps}") from error


def _step(player: Player, chance: random.Random) -> None:
    player.target.act(player.machine, chance, player.now)
    player.passes(0)
    match chance.randrange(12):
        case 0:
            player.damaged(chance.choice(list(Damage)))
        case 1:
            player.loses()
        case 2 | 3:
            player.passes(chance.choice((1000, ms(1), ms(100), ms(3000))))
        case 4:
            for byte in mutated(chance, player.target.corpus)[:80]:
                player.hears(bytes((byte,)))
        case _:
            player.hears(mutated(chance, player.target.corpus))
