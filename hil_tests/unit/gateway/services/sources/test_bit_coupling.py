"""The bit coupling of P20 and P21, built alone over the shared image: areas E and A, blocks of remote lines."""

from gateway.pure.controllers.pic_image import PicImage
from gateway.pure.controllers.rho3.signals.coupling import REMOTE_MOST, Coupled, Coupling
from gateway.services.sources.bit_coupling import CouplingAreas
from hil_tests.lab.virtual.cell_bench import DEMO
from hil_tests.lab.virtual.source_bench import SourceBench
from protocols.rk512.header import ErrorNumber


class Written:
    """RC inputs the areas write in the name of their line."""

    def __init__(self) -> None:
        self.calls: list[tuple[int, bytes]] = []

    def __call__(self, first: int, data: bytes) -> ErrorNumber | None:
        self.calls.append((first, data))
        return None


def coupled() -> Coupled:
    return Coupled(Coupling(16), PicImage(), bytearray(8), bytearray(5))


def test_without_a_coupling_the_cell_has_no_such_areas() -> None:
    bench, written = SourceBench(DEMO), Written()
    areas = CouplingAreas(bench.image, written, remote=True)
    assert (areas.inputs(), areas.outputs(), areas.remote, areas.sent_blocks()) == (None, None, False, b"")
    assert areas.write(0, b"\1") is ErrorNumber.BLOCK and areas.received(bytes(2 + REMOTE_MOST)) is ErrorNumber.BLOCK
    bench.close()


def test_area_e_is_what_the_control_gives_and_area_a_goes_to_rc_inputs_and_board() -> None:
    bench, written = SourceBench(DEMO), Written()
    bench.image.coupled = made = coupled()
    areas = CouplingAreas(bench.image, written, remote=False)
    made.image.put(8, True)
    content = areas.inputs()
    assert content is not None and len(content) == 256 and any(content)
    inside = made.coupling.rc_in_bytes
    assert areas.write(inside - 1, b"\x11\x22") is None
    assert written.calls == [(made.coupling.rc_in_first + inside - 1, b"\x11")] and made.board_out[0] == 0x22
    assert areas.write(made.coupling.from_plc_bytes - 1, b"\0\0") is ErrorNumber.BLOCK, "all or nothing"
    bench.close()


def test_a_remote_frame_is_taken_with_its_last_block() -> None:
    bench, written = SourceBench(DEMO), Written()
    bench.image.coupled = made = coupled()
    areas = CouplingAreas(bench.image, written, remote=True)
    count = -(-made.coupling.from_plc_bytes // REMOTE_MOST)
    blocks = [bytes((number, count)) + bytes((number + 1,)) * REMOTE_MOST for number in range(count)]
    assert [areas.received(block) for block in blocks[:-1]] == [None] * (count - 1) and not written.calls
    assert areas.received(blocks[-1]) is None
    assert b"".join(data for _, data in written.calls)[: REMOTE_MOST + 1] == b"\1" * REMOTE_MOST + b"\2"
    assert len(areas.sent_blocks()) % (2 + REMOTE_MOST) == 0
    bench.close()
