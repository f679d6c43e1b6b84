"""Orders to the cycle and to the planner, in order; they are numbered with the jobs of the command sources, in one sequence.  Pure."""

from gateway.pure.image.records.cell import Order, OrderRecord
from gateway.pure.image.records.planner import ProgramOrder


class OutgoingOrders:
    """What the dispatcher has ordered since the last `take_orders` and `take_programs`."""

    def __init__(self, first_job: int) -> None:
        """`first_job`: a number above every job a predecessor may have used."""
        self._next = first_job
        self._orders: list[OrderRecord] = []
        self._programs: list[ProgramOrder] = []

    def number(self) -> int:
        """For the next job."""
        number, self._next = self._next, self._next + 1
        return number

    def add(
        self, order: Order, job: int = 0, generation: int = 0, *, mask: int = 0, value: float = 0.0, reason: int = 0, piece: bytes = b""
    ) -> int:
        """To the cycle; the number of its job, a new one where it is of none."""
        job = job or self.number()
        self._orders.append(OrderRecord(order, job, generation, mask, value, reason, piece))
        return job

    def add_program(self, order: ProgramOrder) -> None:
        """To the planner."""
        self._programs.append(order)

    def take_orders(self) -> list[OrderRecord]:
        """Orders to the cycle since the last call."""
        orders, self._orders = self._orders, []
        return orders

    def take_programs(self) -> list[ProgramOrder]:
        """Orders to the planner since the last call."""
        programs, self._programs = self._programs, []
        return programs
