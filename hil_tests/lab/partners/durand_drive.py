"""A CiA 402 drive's objects on `durand`, a CANopen device we did not write: enough for a master to start it up."""

import threading

import can
from durand import CANBusNetwork, Node, Record, Variable, set_scheduler
from durand.datatypes import DatatypeEnum as DT
from durand.node import NodeCapabilities
from durand.scheduler import SyncScheduler

OBJECTS = (  # index, type, access, value
    (0x6007, DT.INTEGER16, "rw", 1),
    (0x605A, DT.INTEGER16, "rw", 2),
    (0x605E, DT.INTEGER16, "rw", 2),
    (0x6040, DT.UNSIGNED16, "rw", 0),
    (0x6041, DT.UNSIGNED16, "ro", 0x0250),
    (0x6060, DT.INTEGER8, "rw", 0),
    (0x6061, DT.INTEGER8, "ro", 0),
    (0x6064, DT.INTEGER32, "ro", 4711),
    (0x6077, DT.INTEGER16, "ro", 0),
    (0x607A, DT.INTEGER32, "rw", 0),
    (0x60F4, DT.INTEGER32, "ro", 0),
    (0x60FD, DT.UNSIGNED32, "ro", 4),
    (0x6502, DT.UNSIGNED32, "ro", 1 << 7),
)


class DurandDrive:
    """One node on a python-can bus; its mode display follows the mode, nothing else changes."""

    def __init__(self, channel: str, node: int, *, vendor: int = 0x1234, watches: bool = True) -> None:
        self._scheduler = SyncScheduler()  # its timers (heartbeat) need somebody to run them
        set_scheduler(self._scheduler)
        self._stopped = False
        threading.Thread(target=self._run, daemon=True).start()
        self.bus = can.Bus(interface="broker", channel=channel)
        self.network = CANBusNetwork(self.bus)
        self.node = Node(self.network, node, capabilities=NodeCapabilities(1, 4, 4))
        dictionary = self.node.object_dictionary
        dictionary.write(0x1000, 0, 402, downloaded=False)
        for sub, value in ((1, vendor), (2, 0x402), (3, 1), (4, 99)):
            dictionary.write(0x1018, sub, value, downloaded=False)
        for index, kind, access, value in OBJECTS:
            dictionary[index] = Variable(kind, access, value, name=f"{index:04X}h")
        if watches:
            record = Record(name="Consumer heartbeat time")
            record[1] = Variable(DT.UNSIGNED32, "rw", 0, name="Consumer heartbeat time 1")
            dictionary[0x1016] = record
        dictionary.update_callbacks[(0x6060, 0)].add(lambda mode: dictionary.write(0x6061, 0, mode, downloaded=False))
        self.node.nmt.reset()

    def object(self, index: int, sub: int = 0) -> object:
        """Return the value of this entry."""
        return self.node.object_dictionary.read(index, sub)

    def _run(self) -> None:
        try:
            self._scheduler.run()
        except can.CanError:  # a heartbeat that was due when the bus was closed
            if not self._stopped:
                raise

    def stop(self) -> None:
        self._stopped = True
        dictionary = self.node.object_dictionary
        dictionary.write(0x1017, 0, 0, downloaded=False)
        self._scheduler.stop()
        self.network.stop()
        self.bus.shutdown()
