"""The suites: one row each."""

import importlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, cast

from gateway.conformance.framework.base import Tester
from gateway.conformance.framework.run import Session
from gateway.conformance.suites.opening import Opened
from gateway.conformance.suites.questions import (
    BOOSTER,
    BOOSTER_KEYS,
    CANOPEN,
    CANOPEN_KEYS,
    DRIVE,
    DRIVE_KEYS,
    LINE,
    LINE_KEYS,
    MODBUS,
    MODBUS_KEYS,
    Question,
)
from gateway.pure.conformance.purpose import Purpose


@dataclass(frozen=True, slots=True)
class Suite:
    """One suite.  session: a device opened for it; mutants: module with MUTANTS and VARIANTS."""

    name: str
    version: str
    title: str
    title_de: str
    purposes: Callable[[], Sequence[Purpose[Tester]]]
    session: Callable[[Opened], Session]
    questions: Sequence[Question]
    peers: str
    keys: frozenset[str]  # of the bench file, that act
    frames: bool = False  # a CAN bus; else characters

    @property
    def pics_keys(self) -> Mapping[str, str]:
        return {question.key: question.kind for question in self.questions}

    def sim(self) -> object:
        """The emulated device of `url = "sim"`: the first correct one of its peers."""
        return importlib.import_module(self.peers).VARIANTS[0].make()


REFUSES = ("CO301_SDO_BO_01", "CO301_DIC_BV_06", "CO301_ERR_BV_22")  # judge an abort though they are not BI


def _behind_aborts(purposes: Sequence[Purpose[Tester]]) -> Sequence[Purpose[Tester]]:
    """Cases that judge aborts depend on the case of their form: one wrong form is one FAIL."""
    form = "CO301_SDO_BI_12"

    def behind(one: Purpose[Tester]) -> Purpose[Tester]:
        wants = one.id != form and (one.group == "BI" or one.id in REFUSES)
        return replace(one, preamble=(*one.preamble, form)) if wants else one

    return [behind(one) for one in purposes]


def _behind_actual_values(purposes: Sequence[Purpose[Tester]]) -> Sequence[Purpose[Tester]]:
    """Every case counts on an actual value for each SYNC: a booster that leaves some out FAILs where they are counted."""
    first, counted = "SERVO_CYC_BV_01", "SERVO_CYC_TI_01"
    return [one if one.id in (first, counted) else replace(one, preamble=(*one.preamble, counted)) for one in purposes]


def _generic(*parts: object) -> Sequence[Purpose[Tester]]:
    """The tester of a suite is that of its session; a purpose never meets another one."""
    return [cast(Purpose[Tester], purpose) for part in parts for purpose in cast(Any, part).all]


def _p3964r() -> Sequence[Purpose[Tester]]:
    from gateway.conformance.suites.p3964r import conflicts, failures, lasting, receive_times, repeats, send, sequence, supply

    return _generic(
        *(receive_times.RCV, lasting.RCV, send.REACTS, failures.SND, repeats.SND, lasting.SND, conflicts.CON, repeats.CON, lasting.CON),
        *(sequence.SEQ, repeats.SEQ, supply.SUP),
    )


def _rk512() -> Sequence[Purpose[Tester]]:
    from gateway.conformance.suites.rk512 import active, refusals, supply, targets

    return _generic(refusals.PAS, targets.PAS, active.ACT, supply.SUP)


def _modbus_tcp() -> Sequence[Purpose[Tester]]:
    from gateway.conformance.suites.modbus.answers import TCP_ANS
    from gateway.conformance.suites.modbus.content import CON
    from gateway.conformance.suites.modbus.effects import TCP_EFF
    from gateway.conformance.suites.modbus.functions import FUN
    from gateway.conformance.suites.modbus.lengths import LEN
    from gateway.conformance.suites.modbus.streams import TCP
    from gateway.conformance.suites.modbus.supply import TCP_SUP

    return _generic(FUN, LEN, CON, TCP_EFF, TCP_ANS, TCP, TCP_SUP)


def _modbus_rtu() -> Sequence[Purpose[Tester]]:
    from gateway.conformance.suites.modbus.answers import RTU_ANS
    from gateway.conformance.suites.modbus.content import RTU_CON
    from gateway.conformance.suites.modbus.effects import RTU_EFF
    from gateway.conformance.suites.modbus.framing import RTU
    from gateway.conformance.suites.modbus.functions import RTU_FUN
    from gateway.conformance.suites.modbus.lengths import RTU_LEN
    from gateway.conformance.suites.modbus.station import STA
    from gateway.conformance.suites.modbus.supply import RTU_SUP

    return _generic(RTU_FUN, RTU_LEN, RTU_CON, RTU_EFF, RTU, RTU_ANS, STA, RTU_SUP)


def _canopen301() -> Sequence[Purpose[Tester]]:
    from gateway.conformance.suites.canopen301 import (
        dictionary,
        history,
        keep,
        life,
        network,
        pdo,
        pdo_states,
        pdo_wrong,
        sdo,
        sdo_wrong,
        series,
        settings,
        supply,
        transfers,
        watching,
    )

    return _behind_aborts(
        _generic(
            sdo.SDO,
            sdo_wrong.REFUSED,
            transfers.MORE,
            dictionary.DIC,
            transfers.NAMES,
            network.NMT,
            watching.LIFE,
            life.ERR,
            watching.WATCH,
            watching.GUARD,
            watching.BEATS,
            history.ERR,
            pdo.PDO,
            pdo_states.SENT,
            history.EVENT,
            pdo_states.HEARD,
            pdo_wrong.RULES,
            pdo_states.MAPPED,
            keep.STO,
            settings.SETTINGS,
            settings.FORGETS,
            settings.SHEET,
            settings.SERVER,
            series.BEATS,
            series.PDOS,
            keep.LSS,
            network.TRC,
            supply.SUP,
            history.SUP,
        )
    )


def _cia402() -> Sequence[Purpose[Tester]]:
    from gateway.conformance.suites.cia402 import (
        bounds,
        effects,
        faults,
        interpolation,
        lasting,
        modes,
        other_modes,
        positioning,
        power,
        setpoints,
        supply,
    )

    return _generic(
        *(power.PWR, lasting.PWR, faults.FLT, lasting.FLT, modes.MOD, lasting.MOD, positioning.POS, lasting.POS, modes.VEL, lasting.VEL),
        *(bounds.FLT, effects.KEPT, effects.WIDE, bounds.POS, setpoints.POS, bounds.VEL, effects.MOTOR, effects.EFFECT),
        *(faults.OPT, effects.OPTIONS, modes.HOM, lasting.HOM, effects.STOPPED, modes.CYC, lasting.CYC, bounds.CYC),
        *(interpolation.CYC, other_modes.PWR, other_modes.OPT, other_modes.HOM, supply.SUP),
    )


def _servodyn() -> Sequence[Purpose[Tester]]:
    from gateway.conformance.suites.servodyn import cycle, faults, motion, phase, power, stops

    return _behind_actual_values(
        _generic(
            *(cycle.CYC, power.PWR, stops.PWR, faults.FLT, stops.FLT, motion.MOV, phase.PHASE, phase.SWING, stops.RUNS),
            *(motion.PAR, power.SUP),
        )
    )


def _interop() -> Sequence[Purpose[Tester]]:
    from gateway.conformance.suites.interop.cases import ALL

    return cast(Sequence[Purpose[Tester]], ALL)


def _line(rk512: bool | None) -> Callable[[Opened], Session]:
    def make(opened: Opened) -> Session:
        from gateway.conformance.suites.line_session import LineSession
        from gateway.conformance.suites.supply import line_supply

        session = LineSession(opened.wire(), opened.bench, opened.pics, rk512, opened.say, opened.seed, opened.witness)
        session.tester.supply = line_supply(opened, session.tester, session.rewired)
        return cast(Session, session)

    return make


def _modbus(rtu: bool) -> Callable[[Opened], Session]:
    def make(opened: Opened) -> Session:
        from gateway.conformance.suites.modbus.session import ModbusSession

        return cast(Session, ModbusSession(opened, rtu))

    return make


def _node(opened: Opened) -> Session:
    from gateway.conformance.suites.can.session import NodeSession

    return cast(Session, NodeSession(opened))


def _drive(opened: Opened) -> Session:
    from gateway.conformance.suites.cia402.session import open_drive

    return cast(Session, open_drive(opened))


def _booster(opened: Opened) -> Session:
    from gateway.conformance.suites.servodyn.session import BoosterSession

    return cast(Session, BoosterSession(opened))


SUITES: dict[str, Suite] = {
    suite.name: suite
    for suite in (
        Suite(
            "3964r",
            "1.0",
            "3964R, both roles",
            "3964R, beide Rollen",
            _p3964r,
            _line(False),
            LINE,
            "gateway.conformance.peers.p3964r",
            LINE_KEYS,
        ),
        Suite(
            "rk512",
            "1.0",
            "RK512 on 3964R, both roles",
            "RK512 über 3964R, beide Rollen",
            _rk512,
            _line(True),
            LINE,
            "gateway.conformance.peers.rk512",
            LINE_KEYS,
        ),
        Suite(
            "modbus-tcp",
            "1.0",
            "Modbus TCP server",
            "Modbus-TCP-Server",
            _modbus_tcp,
            _modbus(False),
            MODBUS,
            "gateway.conformance.peers.modbus_tcp",
            MODBUS_KEYS,
        ),
        Suite(
            "modbus-rtu",
            "1.0",
            "Modbus RTU server",
            "Modbus-RTU-Server",
            _modbus_rtu,
            _modbus(True),
            MODBUS,
            "gateway.conformance.peers.modbus_rtu",
            MODBUS_KEYS,
        ),
        Suite(
            "canopen-301",
            "1.0",
            "CANopen device, CiA 301 and LSS",
            "CANopen-Gerät, CiA 301 und LSS",
            _canopen301,
            _node,
            CANOPEN,
            "gateway.conformance.peers.canopen301",
            CANOPEN_KEYS,
            True,
        ),
        Suite(
            "cia402",
            "1.0",
            "drive, CiA 402",
            "Antrieb, CiA 402",
            _cia402,
            _drive,
            DRIVE,
            "gateway.conformance.peers.cia402",
            DRIVE_KEYS,
            True,
        ),
        Suite(
            "servodyn",
            "1.0",
            "SERVODYN booster, axisgate's layout",
            "SERVODYN-Verstärker, Belegung von axisgate",
            _servodyn,
            _booster,
            BOOSTER,
            "gateway.conformance.peers.servodyn",
            BOOSTER_KEYS,
            True,
        ),
        Suite(
            "interop",
            "1.0",
            "3964R and RK512 with the stations of all makers",
            "3964R und RK512 mit den Stationen aller Hersteller",
            _interop,
            _line(None),
            LINE,
            "gateway.conformance.peers.interop",
            LINE_KEYS,
        ),
    )
}
