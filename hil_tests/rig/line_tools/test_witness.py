"""The witness of a conformance run, in real time."""

import signal
import threading

from gateway.conformance.framework.witness import Witness
from protocols.base.machine import ms


def test_the_worst_of_a_long_case_is_not_forgotten_while_the_host_is_late_all_the_time() -> None:
    """A witness that was held up once for long, then a hundred times a little."""
    witness, wait = Witness(), threading.Event().wait
    try:
        child = witness._children[0]
        wait(0.3)  # it runs
        witness.begin()
        for held in (0.15, *[0.004] * 100):
            child.send_signal(signal.SIGSTOP)
            wait(held)
            child.send_signal(signal.SIGCONT)
            wait(0.004)
        assert witness.late() > ms(120)
    finally:
        witness.close()
