"""Processes run by priority, round robin among equals, and never longer than their budget."""

from collections.abc import Callable

from gateway.pure.languages.base.process import Body, Process, ProcessState
from gateway.pure.languages.base.requests import PENDING, Await, Request, RuntimeFault, Sleep, Turn
from gateway.pure.languages.base.scheduler import Scheduler


class Ask(Request):
    """A request of the host, without content."""


class FakeHost:
    """Answers when it is told to."""

    def __init__(self) -> None:
        self.answer: object = PENDING
        self.over: list[str] = []

    def ask(self, process: Process, request: Request, now: int) -> object:
        return self.answer

    def answer_of(self, process: Process, request: Request, now: int) -> object:
        return self.answer

    def ended(self, process: Process, now: int) -> None:
        self.over.append(process.program)


def started(scheduler: Scheduler, name: str, make: Callable[[Process], Body], priority: int = 0, parent: Process | None = None) -> Process:
    def begin(process: Process) -> None:
        process.body = make(process)

    return scheduler.start(name, begin, priority, parent)


def counting(said: list[str], name: str, times: int) -> Callable[[Process], Body]:
    def body(process: Process) -> Body:
        for _ in range(times):
            said.append(name)
            yield Turn()

    return body


def test_equal_priorities_take_turns() -> None:
    said: list[str] = []
    scheduler = Scheduler(FakeHost())
    for name in "ab":
        started(scheduler, name, counting(said, name, 2))
    assert scheduler.run(0) is None
    assert said == ["a", "b", "a", "b"]


def test_the_lower_priority_number_runs_until_it_waits() -> None:
    said: list[str] = []
    scheduler = Scheduler(FakeHost())
    started(scheduler, "slow", counting(said, "slow", 1), priority=5)
    started(scheduler, "fast", counting(said, "fast", 3), priority=1)
    scheduler.run(0)
    assert said == ["fast", "fast", "fast", "slow"]


def test_an_endless_loop_gives_the_processor_back() -> None:
    def body(process: Process) -> Body:
        while True:
            process.left -= 1
            if process.left < 0:
                yield Turn()

    scheduler = Scheduler(FakeHost(), budget=10, rounds=3)
    process = started(scheduler, "endless", body)
    assert scheduler.run(7) == 7  # due again at once
    assert process.state is ProcessState.READY


def test_a_sleeper_is_resumed_at_its_moment_and_names_it_as_deadline() -> None:
    woken: list[int] = []

    def body(process: Process) -> Body:
        yield Sleep(100)
        woken.append(1)

    scheduler = Scheduler(FakeHost())
    started(scheduler, "sleeper", body)
    assert (scheduler.run(0), scheduler.run(99), woken) == (100, 100, [])
    assert (scheduler.run(100), woken) == (None, [1])


def test_a_condition_that_never_holds_ends_at_its_deadline_with_false() -> None:
    answers: list[object] = []

    def body(process: Process) -> Body:
        answers.append((yield Await(lambda: False, 50)))
        answers.append((yield Await(lambda: True)))

    scheduler = Scheduler(FakeHost())
    started(scheduler, "waiter", body)
    scheduler.run(0)
    assert answers == []
    scheduler.run(50)
    assert answers == [False, True]


def test_a_pending_answer_is_taken_when_the_host_has_it() -> None:
    answers: list[object] = []

    def body(process: Process) -> Body:
        answers.append((yield Ask()))

    host = FakeHost()
    scheduler = Scheduler(host)
    started(scheduler, "asker", body)
    scheduler.run(0)
    assert answers == []
    host.answer = 42
    scheduler.run(1)
    assert (answers, host.over) == ([42], ["asker"])


def test_a_fault_as_answer_is_raised_in_the_program_which_may_handle_it() -> None:
    def careless(process: Process) -> Body:
        yield Ask()

    def careful(process: Process) -> Body:
        try:
            yield Ask()
        except RuntimeFault as fault:
            handled.append(fault.code)

    handled: list[int] = []
    host = FakeHost()
    host.answer = RuntimeFault(23, "PTP not allowed")
    scheduler = Scheduler(host)
    failing = started(scheduler, "careless", careless)
    started(scheduler, "careful", careful)
    scheduler.run(0)
    assert failing.state is ProcessState.FAILED
    assert failing.fault is not None
    assert (failing.fault.code, handled) == (23, [23])


def test_stopping_a_process_stops_what_it_started() -> None:
    def body(process: Process) -> Body:
        yield Await(lambda: False)

    host = FakeHost()
    scheduler = Scheduler(host)
    main = started(scheduler, "main", body)
    started(scheduler, "branch", body, parent=main)
    scheduler.run(0)
    scheduler.stop(main, 1)
    assert (host.over, scheduler.processes) == (["branch", "main"], [])
