"""error= of blocks to @MPOS and to entries of the reference path: the program goes on at the label where there is none."""

import pytest

from gateway.pure.image.reasons import CommandState
from hil_tests.lab.virtual.probing import PROBE, Probing
from hil_tests.lab.virtual.program_bench import joints
from hil_tests.unit.motion.program.close import same_program
from hil_tests.unit.motion.program.test_points_in_programs import Portal
from motion.program.errors import TextFaults
from motion.program.text.reader import read
from motion.program.text.writer import write

LINES = ("measure_on ch610", f"ptp joints {joints(20)}", "measure_off ch610", f"ptp joints {joints(25)}", "ptp mpos error=NONE")
BEHIND = (f"ptp joints {joints(12)}", "label NONE", f"ptp rel joints {joints(1)}")


@pytest.mark.requirement("RHO-MOT-12", by="gateway.pure.planning.trial:Trial.coming")
def test_where_nothing_was_measured_the_program_goes_on_at_its_label_and_else_to_the_place() -> None:
    bench = Probing()
    assert bench.finished(bench.order(f"ptp joints {joints(5)}")).state is CommandState.DONE
    assert bench.finished(bench.order(*LINES, *BEHIND)).state is CommandState.DONE
    assert bench.at(26.0), "@MPOS is not read, and what stands before the label is left out"
    assert bench.finished(bench.order(f"ptp joints {joints(5)}")).state is CommandState.DONE
    job = bench.order(*LINES, *BEHIND[1:])
    bench.edge_at(15.0, PROBE)
    bench.finished(job)
    there = bench.measured / bench.cell.dispatcher.axes[0].si
    assert job.state is CommandState.DONE and bench.places()[0] == pytest.approx(there + 1.0, abs=0.01)


def test_an_entry_that_is_not_stored_leads_on_at_its_label() -> None:
    cell = Portal()
    lines = ["record_on 1 13mm", "linear pose 165 120 50 0 0 0", "record_off", "linear pose 200 120 50 0 0 0"]
    for entry, x in ((2, None), (30, 210.0)):
        assert cell.run(*lines, f"linear recorded {entry} error=NONE", "label NONE", "linear rel pose 10 0 0 0 0 0") is CommandState.DONE
        assert cell.bench.set()[0] == pytest.approx(x, abs=1e-6) if x else cell.bench.set()[0] < 180
        assert cell.run("ptp joints 100 100 50 0") is CommandState.DONE


def test_it_is_written_again_and_needs_a_label_behind_and_something_that_may_be_missing() -> None:
    head = "axes deg\nstart 0\n"
    text = head + "ptp joints 1 until=464\nptp mpos error=A\nptp recorded 3 error=B\nlabel A\nptp joints 2\nlabel B\nptp joints 3\n"
    program = read(text)
    assert [block.otherwise for block in program.blocks] == ["", "A", "B", "", ""] and same_program(read(write(program)), program)
    for line, words in (
        ("ptp mpos error=A", "error: label A does not follow the block"),
        ("ptp joints 1 error=A", "error: belongs to until="),
        ("ptp mpos error=3", "error: '3' is not a name"),
    ):
        with pytest.raises(TextFaults) as caught:
            read(head + line)
        assert words in str(caught.value), str(caught.value)
