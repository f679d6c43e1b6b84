"""BAPS2 programs in a cell and in an editor: what 100 breakpoints cost, how soon an input is seen, an output follows, an axis moves, a
fault is shown.

`program.input_output_ms` is measured by this process at the Modbus server of a running cell.  `program.editor_ms` is measured at the pipe
of `axisgate lsp`.  The others are in virtual time: cycles, and what all processes calculated in them.
"""

import asyncio
import contextlib
import functools
import pathlib
import shutil
import socket
import statistics
import struct
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator

from lsprotocol import types as lsp
from pytest_lsp import LanguageClient, client_capabilities, make_test_lsp_client

import configs
from gateway.pure.image.records.interpreter import unpack_facts
from gateway.pure.languages.baps2.debugging import DebugRun
from gateway.pure.languages.baps2.dry_run import DryRun
from gateway.pure.languages.baps2.feed import Feed
from gateway.pure.languages.baps2.library import Library
from gateway.pure.languages.baps2.memory import Memory
from gateway.pure.languages.baps2.words import Words
from gateway.tools.client import ToolClient
from gateway.tools.progress import steps
from hil_tests.bench.figure_row import Figure, row
from hil_tests.bench.lanes_bench import AXES, LANES, step_ratio
from hil_tests.lab.running.cell_running import CellRun, running_cell
from hil_tests.lab.running.web_running import until
from hil_tests.lab.virtual.baps2_bench import CODE, FIRST_INPUT, PARITY, SELECT, ProgramCell, one

P5_MS, BREAKPOINTS, PAIRS, EDGES, STARTS, KEYS = 4, 100, 7, 300, 8, 30
SHARE, STATEMENT_MS, OUTPUT_MS, START_MS, LANES_RATIO, EDITOR_MS = 0.9, P5_MS + 1.0, 2.0 * P5_MS + 10.0, 150.0, 1.5, 200.0
FIRST_OUTPUT, BYTES = 384, ("58", "59")  # user output 1; RC input bytes of the user inputs
WRITE_COIL, READ_INPUTS = 5, 2
PATIENCE_S = 60.0
FOLLOWS = "AGAIN:\nWAIT UNTIL A = 1\nX = 1\nWAIT UNTIL A = 0\nX = 0\nJUMP AGAIN"
DECLARED = "INPUT : 1 = A\nOUTPUT : 1 = X"
SERVER = """
[[modbus]]
name          = "plc"
role          = "server"
bind          = "127.0.0.1:1502"
unit          = 1
view          = "rho3"
command_block = true
max_silence_ms = 5000
on_loss       = "stop_on_path"
"""
LINES = 5_000
EDITED = "I = I + {0} * J\nIF I > 10 THEN R = R * 2.5\nMOVE LINEAR TO P{0}\nWAIT 0.5\n"


# ---- breakpoints -----------------------------------------------------------------------------------------------------------
def breakpoints_ratio(words: Words, loop: str, pairs: int) -> float:
    """Statements a second with breakpoints in lines that are not reached, as a share of those of the same program without: median of
    pairs."""
    never = "IF I < 0 THEN\nBEGIN\n" + "".join(f"K = {n}\n" for n in range(BREAKPOINTS)) + "END\n"
    source = loop.replace("PROGRAM_END", f"{never}PROGRAM_END")
    return statistics.median(_plain_s(words, source) / _watched_s(words, source) for _ in range(pairs))


def _plain_s(words: Words, source: str) -> float:
    memory = Memory({"P.QLL": source.encode()})
    library = Library(words, memory)
    library.unit("P")
    run = DryRun(library, memory, Feed())
    began = time.perf_counter()
    run.run("P")
    return time.perf_counter() - began


def _watched_s(words: Words, source: str) -> float:
    watched = DebugRun(words, Memory({"P.QLL": source.encode()}), Feed())
    lines = watched.lines("P")[-BREAKPOINTS:]
    assert len(lines) == BREAKPOINTS
    watched.debugger.set_breakpoints("P", lines)
    began = time.perf_counter()
    watched.run.run("P")
    assert not watched.tasks(), "the program has run to its end"
    return time.perf_counter() - began


# ---- virtual time ----------------------------------------------------------------------------------------------------------
def _answered(cell: ProgramCell, act: Callable[[], None], test: Callable[[], bool]) -> float:
    """ms from an order to its effect: cycles, and what all processes calculated in them."""
    first, began = len(cell.places), time.perf_counter()
    act()
    cell.until(test)
    return (len(cell.places) - first) * P5_MS + (time.perf_counter() - began) * 1e3


class Timed(ProgramCell):
    """`spent`: ns that services, interpreter and planner calculated; `set_by`: what programs have set outputs to."""

    def __init__(self) -> None:
        self.spent, self.set_by = 0, list[float]()
        super().__init__(one(FOLLOWS, DECLARED))
        self.start("P")
        self.bench.run(0.2)

    def turn(self) -> None:
        began = time.perf_counter_ns()
        super().turn()
        self.spent += time.perf_counter_ns() - began
        self.set_by += [
            float(str(said["value"])) for said in map(unpack_facts, self.port.said if self.port else ()) if said["say"] == "output"
        ]


def input_statement_ms(edges: int) -> float:
    """From a user input to the statement after WAIT UNTIL, 99 of 100: cycles, and what the processes of the gateway calculated in them."""
    cell, found = Timed(), list[float]()
    for edge in range(edges):
        level, first = edge % 2 == 0, len(cell.places)
        cell.spent = 0
        cell.give(1, level)
        cell.until(lambda: bool(cell.set_by))
        found.append((len(cell.places) - first) * P5_MS + cell.spent / 1e6)
        assert cell.set_by == [float(level)]
        cell.bench.run(0.02)
        cell.set_by.clear()
    return _p99(found)


def start_ms(starts: int) -> float:
    """From the strobe of the PLC, at rest, to the first set value that differs, the longest of some."""
    longest = 0.0
    for _ in range(starts):
        cell = ProgramCell(one("MOVE LINEAR TO (300, 60, 40, 12)", name="PALLET"))
        cell.bench.permit(CODE, PARITY)
        cell.bench.run(0.1)
        rest = cell.places[-1]
        strobe, moved = functools.partial(cell.bench.permit, SELECT), functools.partial(_left, cell, rest)
        longest = max(longest, _answered(cell, strobe, moved))
    return longest


def _left(cell: ProgramCell, rest: tuple[float, ...]) -> bool:
    return cell.places[-1] != rest


def _p99(values: list[float]) -> float:
    return sorted(values)[max(len(values) * 99 // 100 - 1, 0)]


# ---- running cell ----------------------------------------------------------------------------------------------------------
@contextlib.contextmanager
def modbus_run() -> Iterator[CellRun]:
    """The shipped palletiser; its user inputs belong to a Modbus client, its program copies input 1 to output 1."""
    cells = pathlib.Path(configs.__file__).parent / "cells"
    with tempfile.TemporaryDirectory(prefix="axg-program-") as made:
        folder = pathlib.Path(made)
        shutil.copytree(cells / "palletiser", folder / "palletiser")
        text = (cells / "palletiser.toml").read_text()
        for octet in BYTES:
            text = text.replace(f'"{octet}" = "rack"', f'"{octet}" = "plc"')
        (folder / "palletiser.toml").write_text(text.replace("\n[[line]]", f"{SERVER}\n[[line]]", 1))
        for name, source in one(FOLLOWS, DECLARED, "COPY").items():
            (folder / "palletiser" / name).write_text(source)
        with running_cell(str(folder / "palletiser.toml"), "program", plc=False, p5_ms=P5_MS) as run:
            command = [sys.executable, "-m", "gateway", "program", "start", run.cell, "COPY", "--name", run.name]
            subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
            with contextlib.closing(ToolClient(run.name)) as tool:
                until(lambda: bool(tool.ask("process", do="list")["processes"]), "the program runs", PATIENCE_S)
            yield run


class Coils:
    """A Modbus TCP client that asks as fast as it is answered."""

    def __init__(self, port: int) -> None:
        self._socket = socket.create_connection(("127.0.0.1", port), PATIENCE_S)
        self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._number = 0

    def ask(self, function: int, address: int, value: int) -> bytes:
        """The data of an answer."""
        self._number = (self._number + 1) & 0xFFFF
        self._socket.sendall(struct.pack(">HHHBBHH", self._number, 0, 6, 1, function, address, value))
        head = self._take(7)
        data = self._take(struct.unpack(">H", head[4:6])[0] - 1)
        assert data[0] == function, data.hex()
        return data[1:]

    def _take(self, size: int) -> bytes:
        found = b""
        while len(found) < size:
            part = self._socket.recv(size - len(found))
            assert part, "the server has closed"
            found += part
        return found

    def close(self) -> None:
        """Ends the connection."""
        self._socket.close()


def input_output_ms(edges: int) -> tuple[float, float]:
    """From the request that writes the coil to the answer that shows the output: 99 of 100, median."""
    with modbus_run() as run, contextlib.closing(Coils(run.port)) as client:
        found = [_round(client, bool(edge % 2 == 0), edge) for edge in steps("program, input to output", range(edges))]
    return _p99(found), statistics.median(found)


def _round(client: Coils, level: bool, edge: int) -> float:
    time.sleep(0.03 + edge % 8 * 0.0005)  # edges at all moments of the cycle
    began = time.perf_counter()
    client.ask(WRITE_COIL, FIRST_INPUT, 0xFF00 * level)
    while client.ask(READ_INPUTS, FIRST_OUTPUT, 1)[1] & 1 != level:
        assert time.perf_counter() - began < PATIENCE_S, "the output does not follow"
    return (time.perf_counter() - began) * 1e3


# ---- editor ----------------------------------------------------------------------------------------------------------------
def editor_ms(keys: int) -> float:
    """From a key in a program of 5,000 lines to its faults, the longest of some."""
    body = "".join(EDITED.format(at % 50) for at in range(LINES // 4))
    text = f"PROGRAM P\nINTEGER : I, J\nREAL : R\nBEGIN\n{body}PROGRAM_END\n"
    with tempfile.TemporaryDirectory(prefix="axg-editor-") as made:
        path = pathlib.Path(made) / "P.QLL"
        path.write_text(text)
        return max(asyncio.run(_typed(path, text, keys)))


async def _typed(path: pathlib.Path, text: str, keys: int) -> list[float]:
    client = make_test_lsp_client()
    await client.start_io(sys.executable, "-m", "gateway", "lsp")
    await client.initialize_session(
        lsp.InitializeParams(client_capabilities("visual_studio_code"), root_uri=path.parent.as_uri(), workspace_folders=[])
    )
    try:
        document = lsp.TextDocumentItem(path.as_uri(), "baps2", 1, text)
        await _faults(client, lambda: client.text_document_did_open(lsp.DidOpenTextDocumentParams(document)))
        return [await _key(client, path.as_uri(), number) for number in range(keys)]
    finally:
        await client.shutdown_session()
        await getattr(client, "stop")()  # noqa: B009  # pygls gives it no types


async def _faults(client: LanguageClient, act: Callable[[], object]) -> None:
    waits = asyncio.create_task(client.wait_for_notification(lsp.TEXT_DOCUMENT_PUBLISH_DIAGNOSTICS))
    await asyncio.sleep(0)
    act()
    await asyncio.wait_for(waits, PATIENCE_S)


async def _key(client: LanguageClient, uri: str, number: int) -> float:
    """A letter that makes a name unknown, and its deletion, in turn."""
    begin, wrong = lsp.Position(4, 0), number % 2 == 0
    change = lsp.TextDocumentContentChangePartial(lsp.Range(begin, begin if wrong else lsp.Position(4, 1)), "X" if wrong else "")
    identity = lsp.VersionedTextDocumentIdentifier(number + 2, uri)
    began = time.perf_counter()
    await _faults(client, lambda: client.text_document_did_change(lsp.DidChangeTextDocumentParams(identity, [change])))
    took = (time.perf_counter() - began) * 1e3
    assert any(each.severity == lsp.DiagnosticSeverity.Error for each in client.diagnostics[uri]) is wrong
    return took


def run(words: Words, loop: str, beside: str, anchor: float, *, short: bool = False) -> list[Figure]:
    """`beside`, `anchor`: reference of the other figures of the run.  `short`: a few of each."""
    pairs, edges, starts, keys = (1, 20, 2, 4) if short else (PAIRS, EDGES, STARTS, KEYS)
    answered, median = input_output_ms(edges)
    one_lane, lanes = step_ratio(1 if short else 4)
    return [
        row("program.breakpoints_ratio", breakpoints_ratio(words, loop, pairs), f"of the same without, {BREAKPOINTS} breakpoints", SHARE,
            beside, anchor, at_least=True),
        row("program.input_statement_ms", input_statement_ms(edges), "ms, p99", STATEMENT_MS, beside, anchor),
        row("program.input_output_ms", answered, "ms at a Modbus server, p99", OUTPUT_MS, "its median", median),
        row("program.start_ms", start_ms(starts), "ms, most", START_MS, beside, anchor),
        row("program.lanes_ratio", lanes / one_lane, f"median, {LANES} lanes of {AXES // LANES} axes to one of {AXES}", LANES_RATIO,
            "one lane, us", one_lane),
        row("program.editor_ms", editor_ms(keys), f"ms, most, {LINES} lines", EDITOR_MS, beside, anchor),
    ]  # fmt: skip
