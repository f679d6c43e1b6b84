"""LSS slave: node number and bit rate given over the bus.  Source: CiA 305."""

from collections.abc import Callable

from protocols.base.machine import Frame
from protocols.canopen import lss
from protocols.canopen.lss import Identity, Mode, Service

_SELECT = (Service.SELECT_VENDOR, Service.SELECT_PRODUCT, Service.SELECT_REVISION, Service.SELECT_SERIAL)
_IDENTIFY = (
    *(Service.IDENTIFY_VENDOR, Service.IDENTIFY_PRODUCT, Service.IDENTIFY_REVISION_LOW, Service.IDENTIFY_REVISION_HIGH),
    *(Service.IDENTIFY_SERIAL_LOW, Service.IDENTIFY_SERIAL_HIGH),
)
_INQUIRE = {Service.INQUIRE_VENDOR: 0, Service.INQUIRE_PRODUCT: 1, Service.INQUIRE_REVISION: 2, Service.INQUIRE_SERIAL: 3}
_WRONG_RATES = frozenset(index for index, rate in enumerate(lss.BIT_RATES) if rate is None)


class LssSlave:
    """`active` is the node number in force, `pending` the one after the next reset of communication."""

    def __init__(self, identity: Identity, node: int, may_listen: Callable[[], bool]) -> None:
        self.identity, self.active, self.pending, self.stored = identity, node, node, node
        self.bit_rate_index = self.stored_rate_index = 0
        self.mode = Mode.WAITING
        self.memory_broken = False
        self._may_listen = may_listen  # the services but the global switch are there in NMT state stopped and without a node number too
        self._selecting = self._identifying = self._scanned = 0

    def take_over(self) -> int:
        """Reset of communication: the pending number counts from now on."""
        self.active = self.pending
        self.mode = Mode.WAITING
        self._selecting = self._identifying = self._scanned = 0
        return self.active

    def power_on(self) -> None:
        """The stored number and rate are restored."""
        self.pending, self.bit_rate_index = self.stored, self.stored_rate_index

    def handle(self, data: bytes) -> list[Frame]:
        if len(data) != 8 or not self._may_listen():
            return []
        try:
            service = Service(data[0])
        except ValueError:
            return []
        number = lss.number_of(data)
        if service is Service.SWITCH_GLOBAL:
            return self._switch(data[1])
        if service in _SELECT:
            return self._select(_SELECT.index(service), number)
        if service in _IDENTIFY:
            return self._identify(_IDENTIFY.index(service), number)
        if service is Service.IDENTIFY_UNCONFIGURED:
            return [lss.answer(Service.UNCONFIGURED)] if self.unconfigured else []
        if service is Service.FASTSCAN:
            return self._fastscan(number, data[5], data[6], data[7])
        return self._configure(service, number, data) if self.mode is Mode.CONFIGURATION else []

    @property
    def unconfigured(self) -> bool:
        return self.active == lss.UNCONFIGURED_NODE and self.pending == lss.UNCONFIGURED_NODE

    def _switch(self, mode: int) -> list[Frame]:
        if mode in (Mode.WAITING, Mode.CONFIGURATION):
            self.mode = Mode(mode)
        return []

    def _select(self, part: int, number: int) -> list[Frame]:
        """Four requests in their order; one that does not fit starts the search again."""
        if self.mode is not Mode.WAITING:
            return []
        self._selecting = part + 1 if part == self._selecting and number == self.identity[part] else 0
        if self._selecting < len(_SELECT):
            return []
        self._selecting, self.mode = 0, Mode.CONFIGURATION
        return [lss.answer(Service.SELECTED)]

    def _identify(self, part: int, number: int) -> list[Frame]:
        own = self.identity
        fitting = (
            *(own.vendor == number, own.product == number, own.revision >= number),
            *(own.revision <= number, own.serial >= number, own.serial <= number),
        )[part]
        self._identifying = part + 1 if part == self._identifying and fitting else 0
        if self._identifying < len(_IDENTIFY):
            return []
        self._identifying = 0
        return [lss.answer(Service.IDENTIFIED)]

    def _fastscan(self, number: int, bit_check: int, sub: int, following: int) -> list[Frame]:
        if not self.unconfigured or self.mode is not Mode.WAITING or (bit_check > 31 and bit_check != lss.CONFIRM_SCAN):
            return []
        if bit_check == lss.CONFIRM_SCAN:
            self._scanned = 0
            return [lss.answer(Service.IDENTIFIED)]
        if sub != self._scanned or sub > 3 or following > 3:
            return []
        if self.identity[sub] >> bit_check != number >> bit_check:
            return []
        self._scanned = following
        if bit_check == 0 and following < sub:  # all four numbers are found: this slave is selected
            self.mode, self._scanned = Mode.CONFIGURATION, 0
        return [lss.answer(Service.IDENTIFIED)]

    def _configure(self, service: Service, number: int, data: bytes) -> list[Frame]:
        if service in _INQUIRE:
            return [lss.answer(service, self.identity[_INQUIRE[service]])]
        match service:
            case Service.INQUIRE_NODE:
                return [lss.answer(service, self.active)]
            case Service.CONFIGURE_NODE:
                good = 1 <= data[1] <= 127 or data[1] == lss.UNCONFIGURED_NODE
                self.pending = data[1] if good else self.pending
                return [lss.answer(service, lss.OK if good else lss.OUT_OF_RANGE)]
            case Service.CONFIGURE_BIT_TIMING:
                good = data[1] == 0 and data[2] < len(lss.BIT_RATES) and data[2] not in _WRONG_RATES
                self.bit_rate_index = data[2] if good else self.bit_rate_index
                return [lss.answer(service, lss.OK if good else lss.OUT_OF_RANGE)]
            case Service.STORE:
                if self.memory_broken:
                    return [lss.answer(service, lss.STORE_FAILED)]
                self.stored, self.stored_rate_index = self.pending, self.bit_rate_index
                return [lss.answer(service, lss.OK)]
            case _:
                return []  # activating a bit rate is the controller's work, not the frames'
