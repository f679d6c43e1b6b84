"""The demo's two PLCs with a person for their program: targets typed at a prompt, sent as DB 10 on the simulated line.

python -m hil_tests.lab.partners.hand_plc [RUN] [MODBUS-PORT]        next to `axisgate run demo --sim`
"""

import sys
from typing import TextIO

from drivers.ports.base import PortError, runtime_dir
from gateway.cell_file.load import load_cell
from gateway.files.find import find_config
from gateway.pure.image.reasons import Reason, text
from hil_tests.lab.partners.plc1 import Block, S5Plc
from hil_tests.lab.partners.plc2 import ModbusPlc
from protocols.base.step5 import Step5Type, encode

HELP = "a number: move A1 there (0.1 mm);  kg: send 120.0 as an S5 float where the cell declares REAL;  on: switch the drives on;  q: quit"
ON, REFERENCED, CONTROL, BUSY, DONE, ERROR = (0, 3), (0, 1), (0, 4), (0, 8), (0, 9), (0, 15)


class Hand:
    """PLC 2 keeps the enabling inputs, PLC 1 does what is typed."""

    def __init__(self, run: str, port: int) -> None:
        axes = [axis.name for axis in load_cell(str(find_config("demo", "cells"))).axis]
        self.one = S5Plc(str(runtime_dir() / f"{run}-plc1-a"), axes)
        self.two = ModbusPlc("127.0.0.1", port)

    def begin(self) -> str:
        """Drives on and referenced; TimeoutError."""
        self.two.start()
        self.two.wait(lambda status: True, 10)
        self.one.start()
        return self.ready()

    def ready(self) -> str:
        """From any state; TimeoutError."""
        one = self.one
        one.word(1, 100)  # override
        one.word(8, 100)  # speed
        one.bit(0, 8, False)
        one.bit(0, 0, False)
        one.wait_cycles(2)
        one.pulse(0, 2)  # what was latched before the enabling inputs came
        one.bit(0, 0, True)
        one.wait(lambda block: block.bit(*ON) and block.bit(*CONTROL), 20, "drives on")
        if not one.status.bit(*REFERENCED):
            one.pulse(0, 3)
            one.wait(lambda block: block.bit(*REFERENCED), 60, "referenced")
        for word in range(2, 8):
            one.word(word, one.status.word(word))
        return "drives on, referenced"

    def obey(self, wish: str) -> str:
        """What became of one typed line."""
        one = self.one
        if wish == "on":
            return self.ready()
        number = int(wish) if wish.lstrip("-").isdecimal() else None
        if wish != "kg" and (number is None or not -0x8000 <= number <= 0x7FFF):
            return HELP
        one.bit(0, 8, False)
        one.wait_cycles(2)
        if number is None:
            start = (one.word_value(0) | 1 << 8).to_bytes(2, "big")
            one.send((12, 0, encode(Step5Type.KG, 120.0)), (10, 0, start))  # the latest target before the start counts
        else:
            one.word(2, number)
        one.bit(0, 8, True)
        one.wait_cycles(2)
        try:
            end = one.wait(lambda block: not block.bit(*BUSY) and (block.bit(*DONE) or block.bit(*ERROR)), 30, "the move")
        except TimeoutError:
            return unfinished(one.status)
        return said(end)

    def end(self) -> None:
        self.one.stop()
        self.two.stop()


def said(block: Block) -> str:
    """DB 11 in words."""
    outcome = "done" if block.bit(*DONE) else f"refused or ended, error {words_of(block.word(1))}"
    return f"{outcome}; A1 is at {block.word(2)} (KF, 0.1 mm)"


def unfinished(block: Block) -> str:
    """The block is the last one that was fetched: on a pulled cable it still shows the move, so it reports no outcome."""
    return f"the move did not end in 30 s; DB 11 was last fetched with A1 at {block.word(2)} (KF, 0.1 mm); plug the line in, then: on"


def carried_out(hand: Hand, wish: str) -> str:
    """An order that cannot be carried out does not end this program."""
    try:
        return hand.obey(wish)
    except TimeoutError:
        return f"not carried out: {why(hand.one.status)}; try: on"


def why(block: Block) -> str:
    """Return what DB 11 reports about it."""
    return f"error {words_of(block.word(1))}" if block.word(1) else "DB 11 reports no error, or was never fetched"


def words_of(code: int) -> str:
    """The number the PLC gets, and the sentence that belongs to it."""
    if code not in set(Reason):
        return f"{code} (axisgate explain {code})"
    sentence = text(Reason(code), detail="..").replace(": ..", "").replace(" ..", "")
    return f"{code} ({sentence})" if code else "0"


def main(argv: list[str], typed: TextIO = sys.stdin) -> int:
    """Exit code 0, or 3 when no run answers."""
    hand = Hand(argv[0] if argv else "demo", int(argv[1]) if len(argv) > 1 else 1502)
    try:
        print(hand.begin(), flush=True)
        print(HELP, flush=True)
        for line in typed:
            if line.strip() == "q":
                break
            print(carried_out(hand, line.strip()), flush=True)
    except TimeoutError:
        print(
            f"drives not on, or axes not referenced: {why(hand.one.status)}; is the cell running?  axisgate run demo --sim", file=sys.stderr
        )
        return 3
    except PortError as error:
        print(f"{error}\nis the cell running?  axisgate run demo --sim", file=sys.stderr)
        return 3
    finally:
        hand.end()
    return 0


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
