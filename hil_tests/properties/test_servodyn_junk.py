"""Garbage in, never an exception out: I/O blocks, parameter telegrams, recordings, parameter lists."""

import contextlib

from hypothesis import given, settings
from hypothesis import strategies as st

from drivers.emulator.servo.settings import BusSettings, ServoSettings
from drivers.emulator.servodyn.slave import ServodynSlave
from gateway.pure.buses.inference.dbc import as_dbc
from gateway.pure.buses.inference.proposal import NothingFound, propose
from gateway.pure.controllers.rho3.can.blocks import IoBus, IoSettings
from gateway.pure.controllers.rho3.can.messages import Trouble
from gateway.pure.controllers.rho3.can.rules import Block, BusSetup, Setup, judge
from gateway.pure.controllers.rho3.parameter_list.cell_file import import_list
from hil_tests.lab.virtual.servodyn_bus import CODEC, START
from protocols.base.dbc import compile_dbc
from protocols.base.errors import DecodeError
from protocols.base.machine import Frame, ms
from protocols.servodyn.parameters import decode_answer, decode_request, encode_request

FRAME = st.builds(Frame, st.sampled_from([100, 210, 310, 471, 541, 542, 610, 710]), st.binary(max_size=8))


@given(st.lists(st.one_of(FRAME, st.none()), max_size=80), st.booleans(), st.booleans())
def test_io_blocks_take_whatever_comes_and_every_error_that_came_goes(frames: list[Frame | None], zero: bool, coupled: bool) -> None:
    """None ends a P2 cycle.  What stands at the end is exactly what was told and not taken back."""
    inputs = (Block(92, 4, 471 if coupled else 541), Block(96, 2, 542))
    bus = IoBus(IoSettings(1, inputs, (Block(92, 4, 472),), ms(16), ms(40), zero), 0)
    now, told = 0, {}
    for frame in frames:
        now += ms(4) if frame is None else 0
        for error in bus.cycle(now) if frame is None else bus.receive(frame, now):
            told[error.block, error.trouble is Trouble.SAME_IDENTIFIER] = error if error.active else None
    standing = {(error.block, error.trouble is Trouble.SAME_IDENTIFIER): error for error in bus.errors}
    assert standing == {key: error for key, error in told.items() if error is not None}
    assert len(bus.frames(bytes(128))) == 1


@given(st.sampled_from([310, 710, 5]), st.binary(max_size=8))
def test_parameter_telegrams_decode_to_what_encodes_again_or_are_refused(identifier: int, data: bytes) -> None:
    with contextlib.suppress(DecodeError):
        decode_answer(Frame(identifier, data))
    with contextlib.suppress(DecodeError):
        slot, request = decode_request(Frame(identifier, data))
        if request.number in range(1, 57):
            assert decode_request(encode_request(slot, request)) == (slot, request)


@settings(max_examples=50)
@given(st.lists(st.binary(min_size=8, max_size=8), max_size=30))
def test_an_emulated_booster_survives_any_parameter_and_still_answers_sync(requests: list[bytes]) -> None:
    slave = ServodynSlave(BusSettings(4.0, 1, {1: ServoSettings()}), CODEC)
    for n, data in enumerate(requests):
        slave.receive([Frame(310, data, START + n * ms(1))], START + n * ms(1))
    slave.take_output()
    slave.receive([Frame(100, b"", START + ms(100))], START + ms(100))
    assert [frame.identifier for frame in slave.take_output()] == [610]


@settings(max_examples=20, deadline=None)
@given(st.lists(st.binary(min_size=3, max_size=8), min_size=1, max_size=12), st.integers(1, 5))
def test_any_recording_gives_a_proposal_that_reads_back_or_nothing(payloads: list[bytes], messages: int) -> None:
    frames = [
        Frame(200 + number, payloads[(cycle * 7 + number) % len(payloads)], cycle * ms(4))
        for cycle in range(150)
        for number in range(messages)
    ]
    with contextlib.suppress(NothingFound):
        assert compile_dbc(as_dbc(propose(frames), "junk")) if not propose(frames).reverse else as_dbc(propose(frames), "junk")


WORDS = st.sampled_from(
    "P5 P15 P30 P31 P103 P401 P607 A_1 A_12 : = 8 16384 -2 TRUE X51 bus 2 inputs start identifier ; \n \n \t 1,5 ** P".split(" ")
)


@given(st.one_of(st.text(max_size=300), st.lists(WORDS, max_size=60).map(" ".join)))
def test_any_text_gives_a_cell_file_and_a_report(text: str) -> None:
    file, report = import_list(text, text[:10])
    assert file.startswith("# ") and "[rho3]" in file
    assert all(isinstance(entry, str) for entry in (*report.taken, *report.assumed, *report.missing, *report.ignored))


BLOCKS = st.lists(st.builds(Block, st.integers(-5, 200), st.integers(-1, 12), st.integers(460, 560)), max_size=7).map(tuple)
BUS = st.builds(BusSetup, st.integers(0, 9), st.integers(0, 9), st.integers(0, 9), st.integers(-1, 5), BLOCKS, BLOCKS)


@given(st.builds(Setup, st.integers(1, 50), st.lists(BUS, max_size=2).map(tuple), st.lists(st.integers(0, 9), max_size=4).map(tuple)))
def test_any_parameters_are_judged_and_each_finding_names_its_parameter(setup: Setup) -> None:
    for found in judge(setup):
        assert found.parameter in ("P5", "P15", "P30", "P31", "P32", "P401") and found.hint
        assert found.code in (0, 3732, 3733, 3734)
