"""One declared channel at work: who is linked to it, which connections it has, who waits for one.  Source: VAL 3 manual, 3.7.1.

Serial line, client and UDP socket have one connection that all their variables share; a server has one for each variable, and a pool of
clients that came before a variable asked for them (AX-186).
"""

from collections.abc import Callable

from gateway.pure.controllers.val3.sio.calls import AnyCall
from gateway.pure.controllers.val3.sio.channel import ANY, Channel, Kind
from gateway.pure.controllers.val3.sio.connection import Connection, State
from gateway.pure.controllers.val3.sio.errors import Rte, Val3Error
from gateway.pure.controllers.val3.sio.inbox import Mark
from gateway.pure.controllers.val3.sio.orders import Close, Configure, Listen, Open, Order, StopListening
from gateway.pure.controllers.val3.sio.variable import Sio
from protocols.base.machine import Ns, ms

RETRY: Ns = ms(250)  # pause between two attempts to open (AX-182)


class Line:
    """Changes nothing outside itself: required actions are in `orders`."""

    def __init__(self, channel: Channel, next_number: Callable[[], int]) -> None:
        self.channel = channel
        self.variables: list[Sio] = []
        self.orders: list[Order] = []
        self.ignored = 0  # datagrams and clients from a wrong address, datagrams without room
        self._next_number = next_number
        self._shared: Connection | None = None
        self._own: dict[Sio, Connection] = {}
        self._pool: list[Connection] = []
        self._opening: list[AnyCall] = []
        self._listening = False
        self._retry_at: Ns | None = None

    @property
    def busy(self) -> bool:
        """Not to be changed now: a socket while one is open or waited for, a serial line while an instruction waits on it."""
        if self.channel.kind is Kind.SERIAL:
            return any(not connection.idle for connection in self.connections())
        return bool(self._opening or self._own or self._open is not None)

    def connections(self) -> list[Connection]:
        """Every one there is."""
        return [*([self._shared] if self._shared else []), *self._own.values(), *self._pool]

    def deadlines(self) -> list[Ns]:
        """When something expires."""
        calls = [*self._opening, *(call for one in self.connections() for call in (*one.readers, *one.writers))]
        due = [call.deadline for call in calls if call.deadline is not None]
        return due if self._retry_at is None or not self._wanted() else [*due, self._retry_at]

    def hears(self, sender: str) -> bool:
        """UDP: whether datagrams of that address are for us (3.7.1.2)."""
        return self.channel.address in (ANY, sender) or self.channel.broadcasts

    # ---------------------------------------------------------------------------------------------- instructions

    def begin(self, call: AnyCall, now: Ns) -> list[AnyCall]:
        """A new instruction: on its connection, or opening one."""
        connection = self._connection_of(call.sio)
        if connection is None or (connection.state is State.OPENING and self.channel.kind is not Kind.SERIAL):
            self._opening.append(call)
            self.want(now)
            return []
        connection.add(call)
        done = self.serve(connection)
        if connection.state is State.OPENING:
            done += connection.fail("the serial port was lost")
        return done

    def clear(self, sio: Sio) -> tuple[int, list[AnyCall]]:
        """clearBuffer: characters dropped; sockets are closed, -1 when nothing was open (AX-189)."""
        if self.channel.kind is Kind.SERIAL:
            return sum(connection.inbox.clear() for connection in self.connections()), []
        server = self.channel.kind is Kind.TCP_SERVER
        waiting = [call for call in self._opening if call.sio is sio or not server]
        mine = self._own.get(sio) if server else self._shared if waiting else self._open
        if mine is None and not waiting:  # an attempt without a waiting call continues, and a server listens until the end
            return -1, []
        dropped = 0 if mine is None else mine.inbox.clear()
        done = self._fail_opening(waiting, "closed by clearBuffer")
        if mine is not None:
            done += self._close(mine, "closed by clearBuffer")
        return dropped, done

    def change(self, channel: Channel) -> None:
        """Other parameters.  With another port, address or number of clients what waits for a partner begins anew."""
        before, self.channel = self.channel, channel
        if channel.kind is not Kind.SERIAL and (before.port, before.address, before.clients) != (
            channel.port,
            channel.address,
            channel.clients,
        ):
            waiting = [] if self._shared is None or self._shared is self._open else [self._shared]
            for connection in [*self._pool, *waiting]:
                self._close(connection, "the channel has other parameters")
            self._deafen()
            self._retry_at = None
        self.orders += [Configure(connection.number, channel) for connection in self.connections() if connection.state is State.OPEN]

    def cancel(self, call: object) -> list[AnyCall]:
        """This call no longer waits; those after it move up."""
        self._opening = [waiting for waiting in self._opening if waiting is not call]
        done: list[AnyCall] = []
        for connection in self.connections():
            connection.remove(call)
            done += self.serve(connection)
        return done

    def release(self, sio: Sio) -> list[AnyCall]:
        """A variable refers to this channel no longer; its server connection goes with it, the last one closes the socket (3.7.1.3)."""
        self.variables = [variable for variable in self.variables if variable is not sio]
        done: list[AnyCall] = []
        for call in [*self._opening, *(call for one in self.connections() for call in (*one.readers, *one.writers))]:
            if call.sio is sio:
                done += [*self.cancel(call), call]
                call.stop(Val3Error(Rte.NOT_LINKED, f"{sio} was deleted or linked again"))
        if sio in self._own:
            done += self._close(self._own[sio], "its variable is gone")
        if not self.variables and self.channel.kind is not Kind.SERIAL:
            done += self.shut("no variable is linked to it")
        return done

    def shut(self, why: str) -> list[AnyCall]:
        """Everything closed and no call waiting; a serial line itself stays on."""
        done = self._fail_opening(self._opening, why)
        for connection in self.connections():
            done += connection.fail(why) if self.channel.kind is Kind.SERIAL else self._close(connection, why)
        self._deafen()
        if self.channel.kind is not Kind.SERIAL:
            self._retry_at = None
        return done

    # --------------------------------------------------------------------------------------------------- adapter

    def want(self, now: Ns) -> None:
        """Orders a connection, unless one is on its way or the last attempt was just now."""
        if self._retry_at is not None and now < self._retry_at:
            return
        self._retry_at = None
        if self.channel.kind is Kind.TCP_SERVER:
            if not self._listening:
                self._listening = True
                self.orders.append(Listen(self.channel))
        elif self._shared is None:
            self._shared = Connection(self._next_number())
            self.orders.append(Open(self._shared.number, self.channel))

    def opened(self, connection: Connection) -> list[AnyCall]:
        """Mark the connection open; return the calls that waited for it."""
        if connection.state is not State.OPENING:
            return []
        connection.state, self._retry_at = State.OPEN, None
        return self._settle(connection, self._opening)

    def refused(self, connection: Connection, now: Ns) -> list[AnyCall]:
        """After a pause once more, if a call waits then."""
        if connection.state is State.OPENING:
            self._retry_at = now + RETRY
            if self.channel.kind is not Kind.SERIAL:
                self._shared = None
        return []

    def not_listening(self, now: Ns) -> None:
        """As `refused`."""
        self._listening, self._retry_at = False, now + RETRY

    def accepted(self, peer: str) -> tuple[int | None, list[AnyCall]]:
        """A client: for the variable that waits longest, else into the pool; None: not served."""
        living = [connection for connection in self.connections() if not connection.inbox.ended]
        if not self._listening or self.channel.address not in (ANY, peer) or len(living) >= self.channel.clients:
            self.ignored += 1
            return None, []
        connection = Connection(self._next_number())
        connection.state = State.OPEN
        if self._opening:
            return connection.number, self._give(connection, self._opening[0].sio)
        self._pool.append(connection)
        return connection.number, []

    def serve(self, connection: Connection) -> list[AnyCall]:
        """After any change: what can end, ends; an error closes the socket (3.7.1.3)."""
        done, broken = connection.serve()
        if broken:
            return done + self._close(connection, "read or write error, or closed by the partner")
        if connection in self._pool and connection.inbox.ended:
            self._forget_dead()
        return done

    def lost(self, connection: Connection, now: Ns) -> list[AnyCall]:
        """Sockets: read what came, then error.  Serial: the gap is reported once, the port recovers on its own."""
        if connection.state is State.OPENING:
            return self.refused(connection, now)
        if self.channel.kind is not Kind.SERIAL:
            connection.broke()
            return self.serve(connection)
        connection.state, self._retry_at = State.OPENING, now + RETRY
        connection.inbox.mark(Mark.DAMAGED)
        return self.serve(connection) + connection.fail("the serial port was lost")

    def wake(self, now: Ns) -> list[AnyCall]:
        """Ends calls whose time is over, then tries again to open."""
        late = [call for call in self._opening if call.deadline is not None and now >= call.deadline]
        for call in late:
            call.expire(connected=False)
        self._opening = [call for call in self._opening if not call.done]
        for connection in self.connections():
            if expired := connection.expire(now):
                late += expired + self.serve(connection)
        if self._retry_at is not None and now >= self._retry_at and self._wanted():
            self._retry_at = None
            if self.channel.kind is Kind.SERIAL and self._shared is not None:
                self.orders.append(Open(self._shared.number, self.channel))
            else:
                self.want(now)
        return late

    # --------------------------------------------------------------------------------------------------- helpers

    @property
    def _open(self) -> Connection | None:
        """The one that all variables share, once it is established."""
        return self._shared if self._shared is not None and self._shared.state is State.OPEN else None

    def _deafen(self) -> None:
        if self._listening:
            self._listening = False
            self.orders.append(StopListening(self.channel.name))

    def _wanted(self) -> bool:
        return self.channel.kind is Kind.SERIAL or bool(self._opening)

    def _connection_of(self, sio: Sio) -> Connection | None:
        if self.channel.kind is not Kind.TCP_SERVER:
            return self._shared
        if sio not in self._own and self._pool:
            self._own[sio] = self._pool.pop(0)
        return self._own.get(sio)

    def _give(self, connection: Connection, sio: Sio) -> list[AnyCall]:
        """A server's variable gets its client."""
        self._own[sio] = connection
        return self._settle(connection, [call for call in self._opening if call.sio is sio])

    def _forget_dead(self) -> None:
        """Clients that left unasked: without a word at once, with one as many as there are places for clients."""
        dead = [connection for connection in self._pool if connection.inbox.ended]
        spoken = [connection for connection in dead if len(connection.inbox)]
        for connection in dead:
            if connection not in spoken[-self.channel.clients :]:
                self._close(connection, "left unasked")

    def _settle(self, connection: Connection, calls: list[AnyCall]) -> list[AnyCall]:
        """They waited for a connection and wait on it now."""
        self._opening = [call for call in self._opening if call not in calls]
        for call in calls:
            connection.add(call)
        return self.serve(connection)

    def _fail_opening(self, calls: list[AnyCall], why: str) -> list[AnyCall]:
        self._opening = [call for call in self._opening if call not in calls]
        for call in calls:
            call.fail(why)
        return list(calls)

    def _close(self, connection: Connection, why: str) -> list[AnyCall]:
        if self._shared is connection:
            self._shared = None
        self._own = {sio: one for sio, one in self._own.items() if one is not connection}
        self._pool = [one for one in self._pool if one is not connection]
        self.orders.append(Close(connection.number))
        return connection.fail(why)
