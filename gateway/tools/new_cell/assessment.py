"""Can axisgate take the old control's place?  Ten answers, then yes, no, or with what; each reason names what it rests on.

"Replaces" means: takes over the listed functions, to the listed evidence level.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from enum import IntEnum


class Verdict(IntEnum):
    """The worst one of all answers counts."""

    YES = 0
    WITH = 1  # can be done with what the reason names
    NO = 2


@dataclass(frozen=True, slots=True)
class Asked:
    """One question; `answers`: word -> what it means, empty where a number or a list is asked."""

    key: str
    text: str
    answers: Mapping[str, str]
    free: str = ""  # what a free answer looks like


@dataclass(frozen=True, slots=True)
class Reason:
    """What one answer means."""

    key: str
    answer: str
    verdict: Verdict
    text: str


class BadAnswer(ValueError):
    """An answer that is none of the question's."""


ASKED = (
    Asked("control", "Which control is it?", {
        "rho3": "Bosch rho 3.0, 3.1, 3.2", "reis": "Reis ROBOTstar V", "val3": "Staubli with VAL 3", "other": "another one",
    }),
    Asked("p15", "rho 3: which boards stand in the P15 list (numbers; - for none or another control)?", {}, "numbers with commas, or -"),
    Asked("axes", "How many axes does it move?", {}, "a number from 1 to 99"),
    Asked("drives", "What moves them?", {
        "servodyn": "SERVODYN-GC boosters on CAN that stay", "analog": "drives with an analog set value that stay",
        "new": "new CiA 402 drives on CAN", "other": "another drive bus",
    }),
    Asked("plc", "What couples the PLC?", {
        "rk512": "3964R with RK512 or BUEP64", "3964r": "3964R without RK512", "can": "CAN I/O blocks", "bits": "24 V contacts",
        "internal": "the rho 3's own PIC or CL300 in its rack", "modbus": "a new PLC with Modbus", "none": "no PLC",
    }),
    Asked("pic", "Does a PIC program run in the control?", {"yes": "", "no": ""}),
    Asked("baps", "Do motion programs run in it (BAPS, RSV, VAL 3)?", {"yes": "", "no": "", "positions": "only positions, the PLC leads"}),
    Asked("backups", "Are there backups of parameters, programs and points?", {"yes": "", "printed": "on paper", "no": ""}),
    Asked("sister", "Is the same cell still alive somewhere, or this control itself?", {"yes": "", "no": ""}),
    Asked("risk", "Who signs the risk assessment of the change?", {}, "a name, or nobody"),
)  # fmt: skip

CAN_BOARDS = {3: "CAN module", 5: "narrow servo board with CAN", 6: "wide servo board with CAN"}


def assess(answers: Mapping[str, str]) -> list[Reason]:
    """A reason for each of the ten answers, in their order; raises BadAnswer naming what is allowed."""
    for asked in ASKED:
        answer = answers.get(asked.key, "")
        if asked.answers and answer not in asked.answers:
            raise BadAnswer(f"{asked.key} = {answer or '(nothing)'}: one of {', '.join(asked.answers)}")
        if not asked.answers and not answer:
            raise BadAnswer(f"{asked.key}: {asked.free} is needed")
    found = [_control(answers), _boards(answers), _axes(answers), *_by_table(answers), _risk(answers)]
    order = [asked.key for asked in ASKED]
    return sorted(found, key=lambda reason: order.index(reason.key))


def verdict(reasons: list[Reason]) -> Verdict:
    """The whole: its worst part."""
    return max(reason.verdict for reason in reasons)


def _control(answers: Mapping[str, str]) -> Reason:
    control = answers["control"]
    texts = {
        "rho3": (Verdict.YES, "rho 3: signals, PLC functions, serial devices, CAN and motion semantics from its release manual"),
        "reis": (
            Verdict.WITH,
            "ROBOTstar V: its signal view, markers and motion rules; no program language, no weld or oscillation functions",
        ),
        "val3": (Verdict.WITH, "VAL 3: its I/O, serial channels and motion rules; no program language"),
        "other": (
            Verdict.WITH,
            "another control: only what its PLC sees can be matched; read docs/guide/signals.md and compare word by word",
        ),
    }
    return Reason("control", control, *texts[control])


def _boards(answers: Mapping[str, str]) -> Reason:
    answer = answers["p15"].strip()
    if answer == "-":
        return Reason("p15", answer, Verdict.YES, "no P15 list: nothing to match")
    if not re.fullmatch(r"\d{1,2}( *, *\d{1,2})*", answer):
        raise BadAnswer(f"p15 = {answer}: numbers with commas, or -")
    boards = [int(part) for part in answer.split(",")]
    strange = [number for number in boards if number not in CAN_BOARDS]
    if not strange:
        return Reason(
            "p15",
            answer,
            Verdict.YES,
            f"{', '.join(CAN_BOARDS[number] for number in boards)}: its drives and I/O blocks are reached over CAN",
        )
    return Reason("p15", answer, Verdict.WITH, f"board {strange[0]} is no CAN board: the axes behind it need new drives on CAN")


def _axes(answers: Mapping[str, str]) -> Reason:
    answer = answers["axes"].strip()
    if not re.fullmatch(r"[1-9]\d?", answer):
        raise BadAnswer(f"axes = {answer}: a number from 1 to 99")
    count = int(answer)
    if count > 32:
        return Reason("axes", answer, Verdict.NO, "a cell has 32 axes at most")
    if count > 12:
        return Reason(
            "axes", answer, Verdict.WITH, "more than 12 axes need more than two buses; `axisgate bus load` says what cycle time fits"
        )
    return Reason("axes", answer, Verdict.YES, "six axes on each CAN bus, two buses at 2 ms measured on emulated drives")


_TABLE: Mapping[str, Mapping[str, tuple[Verdict, str]]] = {
    "drives": {
        "servodyn": (
            Verdict.WITH,
            "the layout of SERVODYN telegrams is not published: listen to the living control first (axisgate bus infer)",
        ),
        "analog": (Verdict.NO, "axisgate has no analog set values: new drives on CAN first"),
        "new": (Verdict.YES, "CiA 402 in CSP; measure your drive's stop at bus loss (axisgate drive loss-test)"),
        "other": (Verdict.NO, "only SERVODYN-GC and CiA 402 on CAN are driven"),
    },
    "plc": {
        "rk512": (Verdict.YES, "the PLC program stays: RK512 over 3964R, blocks as they are"),
        "3964r": (Verdict.YES, "raw 3964R blocks are declared as [[telegram]]"),
        "can": (Verdict.YES, "CAN I/O blocks with the old identifiers"),
        "bits": (Verdict.WITH, "24 V contacts need a CANopen 401 or Modbus coupler ([[io]])"),
        "internal": (Verdict.WITH, "the PLC in the old rack goes with it: its program moves to a PLC outside"),
        "modbus": (Verdict.YES, "Modbus TCP or RTU with the old signals under their addresses"),
        "none": (Verdict.WITH, "somebody has to give commands: a PLC, the page, or a program of the cell"),
    },
    "pic": {
        "yes": (Verdict.WITH, "axisgate runs no PIC program: its logic moves to a PLC; timers, counters and I/O are at the interface"),
        "no": (Verdict.YES, "no PIC program to move"),
    },
    "baps": {
        "yes": (Verdict.WITH, "axisgate runs no BAPS, RSV or VAL 3 source: rewrite the motions as programs of the cell or position tables"),
        "no": (Verdict.YES, "no motion programs to move"),
        "positions": (Verdict.YES, "positions by number are a table of the cell"),
    },
    "backups": {
        "yes": (Verdict.YES, "parameters are read by axisgate import p-list"),
        "printed": (Verdict.WITH, "the printed P list is typed into a file once (axisgate import p-list)"),
        "no": (
            Verdict.WITH,
            "print or photograph the parameters (PHG mode 7.8) before the control dies; without them every axis is measured anew",
        ),
    },
    "sister": {
        "yes": (Verdict.YES, "listen before you replace: axisgate learn line, bus infer"),
        "no": (Verdict.WITH, "nothing to listen to: PLC blocks and telegrams come from listings alone; plan time for it"),
    },
}


def _by_table(answers: Mapping[str, str]) -> list[Reason]:
    return [Reason(key, answers[key], *rows[answers[key]]) for key, rows in _TABLE.items()]


def _risk(answers: Mapping[str, str]) -> Reason:
    name = answers["risk"].strip()
    if name.lower() in ("nobody", "no", "-", "niemand"):
        return Reason("risk", name, Verdict.NO, "whoever changes the machine needs a risk assessment first; nobody can sign it later")
    return Reason("risk", name, Verdict.YES, f"{name} signs; its number goes into [safety] risk_assessment")
