"""SF 17 MIRROR in programs (rho 3 Releases part 1, L9003-9005; AX-360, AX-577): words, and a cell judged by the emulator's own record."""

import numpy as np
import pytest

from gateway.pure.image.reasons import CommandState
from hil_tests.lab.cells.arms import Array
from hil_tests.lab.virtual.belt_bench import CELL
from hil_tests.lab.virtual.planned_bench import Planned, ServodynRobot
from hil_tests.unit.motion.program.close import same_program
from motion.geometry.frames import Pose
from motion.program.blocks import Block, PoseTarget
from motion.program.errors import TextFaults
from motion.program.text.reader import read
from motion.program.text.writer import write

ARM = "axes deg deg deg deg deg deg\nstart 0 30 90 0 60 0\nframe f 300 40 50 0 0 30\npoint P pose 350 -150 200 170 10 30\n"
ARM += "point STEP rel pose 10 20 -30 5 -7 9\n"
ACROSS = {"yz": (-1.0, 1.0, 1.0), "xz": (1.0, -1.0, 1.0), "xy": (1.0, 1.0, -1.0)}


def mirrored(pose: Pose, plane: str) -> Pose:
    """By matrices: M p, M R M."""
    m, r = np.diag(ACROSS[plane]), np.reshape(pose.rotation, (3, 3))
    x, y, z = m @ pose.position
    return Pose((x, y, z), tuple((m @ r @ m).ravel()))


def poses(block: Block) -> list[Pose]:
    return [place.pose for place in (block.target, block.via) if isinstance(place, PoseTarget)]


def same(one: Pose, other: Pose) -> bool:
    return one.position == pytest.approx(other.position) and one.rotation == pytest.approx(other.rotation)


@pytest.mark.parametrize("angles", ["val3", "rho3"])
@pytest.mark.parametrize("plane", ACROSS)
def test_every_pose_of_a_block_is_mirrored_and_so_is_what_a_relative_one_is_counted_by(plane: str, angles: str) -> None:
    lines = "linear P {0}\ncircular via pose 360 20 210 170 5 0 to pose 350 150 200 180 0 40 frame=f {0}\nlinear STEP {0}\n"
    plain, other = (read(f"angles {angles}\n{ARM}" + lines.format(word)).blocks for word in ("", f"mirror={plane}"))
    rows = [(a, b) for one, two in zip(plain, other, strict=True) for a, b in zip(poses(one), poses(two), strict=True)]
    assert len(rows) == 3 and all(same(mirrored(a, plane), b) for a, b in rows)
    ends = []
    for block, begin in ((plain[2], poses(plain[0])[0]), (other[2], poses(other[0])[0])):
        shift = block.shift
        assert shift is not None and shift.angles is not None
        way = np.concatenate([np.array(shift.values[:3]) * 1e3, np.degrees(shift.values[3:])])
        ends.append(shift.angles.pose((np.array(shift.angles.values(begin)) + way).tolist()))
    assert same(mirrored(ends[0], plane), ends[1])


def test_set_mirrors_what_follows_places_of_axes_stay_and_the_text_written_is_the_same_program() -> None:
    text = ARM + "set mirror=xz\nlinear P\nptp joints 0 30 90 0 60 0\nlinear P mirror=-\nset mirror=-\nlinear P\nlinear P mirror=xz\n"
    program = read(text)
    across = [poses(block)[0].position[1] if poses(block) else 0.0 for block in program.blocks]
    assert across == pytest.approx([0.15, 0.0, -0.15, -0.15, 0.15])
    assert same_program(read(write(program)), program)
    for line, says in [
        ("linear P mirror=x", "line 6: mirror: 'x': yz, xz, xy, or - for none"),
        ("set mirror=q", "mirror: 'q'"),
        ("ptp joints 0 30 90 0 60 0 mirror=xy", "mirror: needs a pose as target"),
        ("ptp rel joints 0 1 0 0 0 0 mirror=xy", "mirror: needs a pose as target"),
    ]:
        with pytest.raises(TextFaults) as caught:
            read(ARM + line)
        assert says in str(caught.value)


def test_in_a_cell_the_drives_run_the_mirrored_path() -> None:
    planned = Planned(ServodynRobot(cell=CELL))
    head = "robot portal\nangles rho3\naxes mm mm mm deg\nstart 100 100 50 0\nframe f 300 200 100 0 0 25\n"
    way = "linear pose 40 60 0 0 0 0 frame=f{0}\ncircular via pose 80 80 0 0 0 0 to pose 100 20 0 0 0 90 frame=f{0}\n"
    frame = read(head).blocks or read(head + "linear pose 0 0 0 0 0 0 frame=f").blocks
    paths: list[Array] = []
    for word in ("", " mirror=xz"):
        assert planned.bench.settle(planned.order(head + f"linear pose 0 0 0 0 0 0 frame=f\n{way.format(word)}")).state is CommandState.DONE
        planned.bench.run(0.1)
        driven = planned.driven()
        places = driven.places(driven.sets, frame=frame[0].frame.pose)
        inside = np.flatnonzero(np.linalg.norm(places, axis=1) < 1e-4)[-1]  # the arc begins here, on both
        paths.append(places[inside:])
    assert len(paths[0]) > 50 and np.abs(paths[0][:, 1]).max() > 0.05
    for place in paths[1] * (1.0, -1.0, 1.0):
        assert np.linalg.norm(paths[0] - place, axis=1).min() < 2e-3
    assert np.linalg.norm(paths[1][-1] - paths[0][-1] * (1.0, -1.0, 1.0)) < 2e-5
