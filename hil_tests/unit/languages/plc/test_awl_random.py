"""Random statement lists give in the integrated PLC what a STEP processor gives, scan by scan (AX-746)."""

import random
from collections.abc import Mapping

import pytest

from gateway.pure.languages.plc.awl.report import imported
from hil_tests.unit.languages.plc.rig import Rig

BITS = [f"{byte}.{bit}" for byte in (0, 1) for bit in range(8)]


def chain(r: random.Random, depth: int = 0) -> list[str]:
    """Links, brackets, single O."""
    found = [f"{r.choice(['U', 'UN', 'O', 'ON'])} {r.choice('EM')} {r.choice(BITS)}"]
    for _ in range(r.randint(0, 4)):
        kind = r.random()
        if kind < 0.2 and depth < 2:
            found += [f"{r.choice(['U', 'UN', 'O', 'ON'])}(", *chain(r, depth + 1), ")"]
        elif kind < 0.4:
            found += ["O", f"{r.choice(['U', 'UN'])} E {r.choice(BITS)}"]
        else:
            found.append(f"{r.choice(['U', 'UN', 'O', 'ON'])} {r.choice('EM')} {r.choice(BITS)}")
    return found


def written(r: random.Random) -> list[str]:
    """A list: chains with their ends, jumps, edges, NOT, SET, CLR, BEB."""
    found: list[str] = []
    for part in range(r.randint(3, 9)):
        found += chain(r) + [f"{r.choice('=SR')} {r.choice('AM')} {r.choice(BITS)}" for _ in range(r.randint(1, 3))]
        kind = r.randint(0, 9)
        if kind < 3:
            found += [*chain(r), f"{r.choice(['SPA', 'SPB', 'SPBN'])} L{part}", f"= M {r.choice(BITS)}", *chain(r)]
            found += [f"= A {r.choice(BITS)}", f"L{part}: {r.choice(['NOP 0', f'S M {r.choice(BITS)}'])}"]
        elif kind < 5:
            found += [*chain(r), f"{r.choice(['FP', 'FN'])} M 10.{part % 8}", f"= A {r.choice(BITS)}"]
        elif kind < 8:
            found += [*(chain(r) + ["NOT"] if kind == 5 else [r.choice(["SET", "CLR"])]), f"= M {r.choice(BITS)}"]
        elif kind == 8:
            found += [*chain(r), "BEB", f"R M {r.choice(BITS)}"]
    return found


class Step:
    """A STEP processor: result, first link of a chain, the part in front of a single O (None: none), brackets."""

    def __init__(self) -> None:
        self.bits: dict[str, bool] = {}
        self.result, self.first, self.before, self.anew = True, True, False, False
        self.brackets: list[tuple[str, bool, bool, bool, bool]] = []

    def _link(self, word: str, value: bool) -> None:
        if self.first or (self.anew and word[0] == "U"):
            self.before = self.before and not self.first
            self.result = value
        elif word[0] == "U":
            self.result = self.result and value
        else:
            self.result, self.before = self.result or self.before or value, False
        self.first = self.anew = False

    def _end(self, result: bool) -> None:
        self.result, self.first, self.before, self.anew = result, True, False, False

    def scan(self, lines: list[str], inputs: Mapping[str, bool]) -> None:
        """One scan."""
        labels = {line.split(":")[0]: at for at, line in enumerate(lines) if ":" in line}
        at = 0
        while 0 <= at < len(lines):
            word, _, rest = lines[at].rpartition(":")[2].strip().partition(" ")
            at = self._do(word, rest.replace(" ", ""), {**self.bits, **inputs}, at + 1, labels)

    def _do(self, word: str, operand: str, bits: Mapping[str, bool], at: int, labels: Mapping[str, int]) -> int:
        total = self.result or self.before
        if word == ")":
            opened, self.result, self.first, self.before, self.anew = self.brackets.pop()
            self._link(opened, total != ("N" in opened))
        elif word.endswith("("):
            self.brackets.append((word, self.result, self.first, self.before, self.anew))
            self.first, self.before, self.anew = True, False, False
        elif word == "O" and not operand:
            self.result, self.before, self.anew = False, total, True
        elif word in ("U", "UN", "O", "ON"):
            self._link(word, bits.get(operand, False) != ("N" in word))
        elif word in ("=", "S", "R"):
            if word == "=" or total:
                self.bits[operand] = total if word == "=" else word == "S"
            self._end(total)
        elif word in ("SPA", "SPB", "SPBN", "BEB"):
            jumps = word == "SPA" or total == (word != "SPBN")
            self._end(total if jumps else True)
            return (-1 if word == "BEB" else labels[operand]) if jumps else at
        elif word in ("FP", "FN"):
            edge = total != bits.get(operand, False) and total == (word == "FP")
            self.bits[operand] = total
            self._end(edge)
        elif word in ("NOT", "SET", "CLR"):
            self._end(not total if word == "NOT" else word == "SET")
        return at


@pytest.mark.parametrize("seed", range(60))
def test_a_random_list_runs_as_step_runs_it(seed: int) -> None:
    r = random.Random(seed)
    lines = written(r)
    result = imported("FUNCTION FC 1 : VOID\nBEGIN\n" + "".join(f"{line};\n" for line in lines) + "END_FUNCTION\n")
    assert result.refused == []
    rig, step = Rig(sources=result.programs, start="FC1"), Step()
    for _ in range(5):
        inputs = {f"E{bit}": r.random() < 0.5 for bit in BITS}
        step.scan(lines, inputs)
        rig.scan(*[name for name, high in inputs.items() if high])
        for bit in BITS:
            byte, number = (int(part) for part in bit.split("."))
            assert rig.output(f"A{bit}") == step.bits.get(f"A{bit}", False), (bit, lines)
            assert rig.plc.bit(byte, number) == step.bits.get(f"M{bit}", False), (bit, lines)
