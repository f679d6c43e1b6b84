"""dio, aio and sio instructions.  Source: VAL 3 reference 3.5 and 3.7, L2290-2808."""

import math
from collections.abc import Generator
from typing import TypeVar

from gateway.pure.controllers.val3.sio.calls import Call
from gateway.pure.languages.base.requests import Ns
from gateway.pure.languages.val3.arrays import Maker, f_delete, f_resize
from gateway.pure.languages.val3.errors import Rte
from gateway.pure.languages.val3.instance import Instance
from gateway.pure.languages.val3.numbers import Place
from gateway.pure.languages.val3.sockets import sockets_in
from gateway.pure.languages.val3.values import AioV, Container, DioV, LinkV, SioV, cut
from gateway.pure.languages.val3.virtual_io import Point, Status

T = TypeVar("T")
Waiting = Generator[Ns | None, None, object]


def io_get(own: Instance, variable: DioV) -> bool:
    """A dio as a bool; 123."""
    return own.machine.io.usable(variable.link).value != 0


def io_put(own: Instance, variable: DioV, value: bool) -> bool:
    """dio = bool, which returns the bool; 122, 123."""
    own.machine.io.write(variable.link, float(value))
    return value


def f_dio_link(own: Instance, variable: LinkV, source: LinkV) -> None:
    """Copy the source's link to the variable."""
    variable.link = source.link


f_aio_link = f_dio_link


def f_dio_get(own: Instance, array: Place) -> float:
    """The array as a number, its first element lowest."""
    return float(sum(1 << at for at, one in enumerate(array[0][array[1] :]) if isinstance(one, DioV) and io_get(own, one)))


def f_dio_set(own: Instance, array: Place, value: float) -> float:
    """The integer part in binary; what the outputs can show of it."""
    outputs = [one for one in array[0][array[1] :] if isinstance(one, DioV)]
    for one in outputs:  # all or nothing
        if own.machine.io.usable(one.link).is_input:
            raise Rte(122, str(one.link))
    shown = int(value) & ((1 << len(outputs)) - 1)
    for at, one in enumerate(outputs):
        io_put(own, one, bool(shown >> at & 1))
    return float(shown)


def f_aio_get(own: Instance, variable: AioV) -> float:
    """The value; 123."""
    return own.machine.io.usable(variable.link).value


def f_aio_set(own: Instance, variable: AioV, value: float) -> float:
    """Write; return the value as the output accepts it, or its present value if out of range (L2493)."""
    return own.machine.io.write(variable.link, value)


def f_io_status(own: Instance, variable: LinkV) -> float:
    """0 .. 2, -1 .. -3."""
    if not variable.link:
        return float(Status.NO_LINK)
    return float(own.machine.io.declare(variable.link).status)


def f_io_description(own: Instance, variable: LinkV, description: Place, path: Place) -> float:
    """With description and physical path."""
    point = own.machine.io.declare(variable.link) if variable.link else Point("")
    description[0][description[1]], path[0][path[1]] = cut(point.description), cut(point.path)
    return f_io_status(own, variable)


# ---- sio -------------------------------------------------------------------------------------------------------------------


def f_sio_link(own: Instance, variable: SioV, source: SioV) -> None:
    """Copy the source's link to the variable; 123 where it has none."""
    own.machine.sio.link(variable, source)


def f_sio_status(own: Instance, variable: SioV) -> float:
    """0, -1, -2."""
    return float(own.machine.sio.status(variable)[0])


def f_sio_description(own: Instance, variable: SioV, description: Place, path: Place) -> float:
    """With description and physical path."""
    status, words, where = own.machine.sio.status(variable)
    description[0][description[1]], path[0][path[1]] = cut(words), cut(where)
    return float(status)


def f_clear_buffer(own: Instance, variable: SioV) -> float:
    """Characters dropped; -1: a closed socket."""
    return float(own.machine.sio.clear(variable))


def f_sio_ctrl(own: Instance, variable: SioV, name: str, value: float | str | bool) -> float:
    """0 or -1 .. -5."""
    return float(own.machine.sio.control(variable, name, value))


def f_sio_get(own: Instance, variable: SioV, array: Place) -> Waiting:
    """How many bytes came."""
    data = [float(one) if isinstance(one, float) else 0.0 for one in array[0]]
    call = own.machine.sio.core.get(own.machine.sio.of(variable), data, own.machine.now, array[1])
    count = yield from _done(own, call)
    assert isinstance(count, int)
    if count > 0:
        array[0][array[1] : array[1] + count] = data[array[1] : array[1] + count]
    return float(count)


def f_sio_set(own: Instance, variable: SioV, array: Place, count: float | None = None) -> Waiting:
    """How many bytes went."""
    data = [float(one) if isinstance(one, float) else 0.0 for one in array[0]]
    amount = None if count is None else math.floor(count + 0.5)
    call = own.machine.sio.core.set(own.machine.sio.of(variable), data, own.machine.now, amount, array[1])
    done = yield from _done(own, call)
    return float(done) if isinstance(done, int | float) else -1.0


def sio_write_string(own: Instance, variable: SioV, text: str) -> Waiting:
    """sio = string."""
    return (yield from _done(own, own.machine.sio.core.write_text(own.machine.sio.of(variable), text, own.machine.now)))


def sio_write_num(own: Instance, variable: SioV, value: float) -> Waiting:
    """sio = num."""
    return (yield from _done(own, own.machine.sio.core.write_num(own.machine.sio.of(variable), value, own.machine.now)))


def sio_read_string(own: Instance, variable: SioV) -> Waiting:
    """string = sio."""
    text = yield from _done(own, own.machine.sio.core.read_text(own.machine.sio.of(variable), own.machine.now))
    return cut(str(text))


def sio_read_num(own: Instance, variable: SioV) -> Waiting:
    """num = sio."""
    return (yield from _done(own, own.machine.sio.core.read_num(own.machine.sio.of(variable), own.machine.now)))


def _done(own: Instance, call: Call[T]) -> Waiting:
    """Waits for it; an asynchronous task yields its turn once in any case (L3368).

    A call that has ended at once does not look at the network: reading a telegram byte by byte would cost a system call for each byte.
    """
    try:
        if not own.machine.current_is_synchronous:
            yield own.machine.now
        if not call.done or own.machine.sio.core.ordered():
            _settle(own)
        while not call.done:
            yield None
            _settle(own)
    finally:
        if not call.done:  # the task is killed, or continues elsewhere: received data is for the tasks that still wait
            own.machine.sio.core.cancel(call)
    return call.result()


def _settle(own: Instance) -> None:
    """Bring the channels up to date: a call that must not wait (time-out -1) has ended then and costs no cycle (L3391)."""
    own.machine.sio.now = own.machine.now
    own.machine.sio.settle()


def f_delete_of_sockets(own: Instance, container: Container, place: object, make: Maker, local: bool) -> bool:
    """delete() of values that are sio variables or have some inside: their connections to a server close (L2646)."""
    before = list(sockets_in(container))
    f_delete(container, place, make, local)
    _forget(own, before, container)
    return True


def f_resize_of_sockets(own: Instance, container: Container, dimension: float, size: float, make: Maker, local: bool) -> None:
    """As delete() for what it drops."""
    before = list(sockets_in(container))
    f_resize(container, dimension, size, make, local)
    _forget(own, before, container)


def _forget(own: Instance, before: list[SioV], container: Container) -> None:
    left = {id(each) for each in sockets_in(container)}
    for variable in before:
        if id(variable) not in left:
            own.machine.sio.forget(variable)
