"""Can axisgate replace the old controller?  Ten answers, then yes, no, or with what; each reason names its source.

"Replaces" means: takes over the listed functions, to the listed evidence level.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from enum import IntEnum

from gateway.files.texts import read_texts
from gateway.pure.reports.sentences import joined


class Verdict(IntEnum):
    """The worst one of all answers counts."""

    YES = 0
    WITH = 1  # possible with the addition named by the reason
    NO = 2


@dataclass(frozen=True, slots=True)
class Asked:
    """One question; `answers`: word -> its meaning, empty if a number or a list is expected."""

    key: str
    text: str
    answers: Mapping[str, str]
    free: str = ""  # form of a free answer


@dataclass(frozen=True, slots=True)
class Reason:
    """Consequence of one answer."""

    key: str
    answer: str
    verdict: Verdict
    text: str


class BadAnswer(ValueError):
    """An answer that is none of the question's."""


TEXTS = read_texts("assess")


def _asked(key: str, *answers: str) -> Asked:
    meanings = {answer: TEXTS.said(f"a.{key}.{answer}") if f"a.{key}.{answer}" in TEXTS.ids() else "" for answer in answers}
    return Asked(key, TEXTS.said(f"q.{key}"), meanings, "" if answers else TEXTS.said(f"free.{key}"))


ASKED = (
    _asked("control", "rho3", "reis", "val3", "other"),
    _asked("p15"),
    _asked("axes"),
    _asked("drives", "servodyn", "analog", "new", "other"),
    _asked("plc", "rk512", "3964r", "can", "bits", "internal", "modbus", "none"),
    _asked("pic", "yes", "no"),
    _asked("baps", "yes", "no", "positions"),
    _asked("backups", "yes", "printed", "no"),
    _asked("sister", "yes", "no"),
    _asked("risk"),
)
CAN_BOARDS = (3, 5, 6)
LOOKS = {"p15": (r"-|\d{1,2}( *, *\d{1,2})*", "numbers with commas, or -"), "axes": (r"[1-9]\d?", "a number from 1 to 99")}


def judge(asked: Asked, answer: str) -> None:
    """Raises BadAnswer naming the valid answers."""
    if asked.answers and answer not in asked.answers:
        raise BadAnswer(f"{asked.key} = {answer or '(nothing)'}: one of {', '.join(asked.answers)}")
    if not asked.answers and not answer:
        raise BadAnswer(f"{asked.key}: {asked.free} is needed")
    if asked.key in LOOKS:
        pattern, words = LOOKS[asked.key]
        if not re.fullmatch(pattern, answer.strip()):
            raise BadAnswer(f"{asked.key} = {answer}: {words}")


def assess(answers: Mapping[str, str]) -> list[Reason]:
    """A reason for each of the ten answers, in their order; raises BadAnswer naming the valid answers."""
    for asked in ASKED:
        judge(asked, answers.get(asked.key, ""))
    found = [_control(answers), _boards(answers), _axes(answers), *_by_table(answers), _risk(answers)]
    order = [asked.key for asked in ASKED]
    return sorted(found, key=lambda reason: order.index(reason.key))


def verdict(reasons: list[Reason]) -> Verdict:
    """The overall verdict: that of the worst part."""
    return max(reason.verdict for reason in reasons)


def _control(answers: Mapping[str, str]) -> Reason:
    control = answers["control"]
    return Reason("control", control, Verdict.YES if control == "rho3" else Verdict.WITH, TEXTS.said(f"r.control.{control}"))


def _boards(answers: Mapping[str, str]) -> Reason:
    answer = answers["p15"].strip()
    if answer == "-":
        return Reason("p15", answer, Verdict.YES, TEXTS.said("r.p15.none"))
    boards = [int(part) for part in answer.split(",")]
    strange = [number for number in boards if number not in CAN_BOARDS]
    if strange:
        return Reason("p15", answer, Verdict.WITH, TEXTS.said("r.p15.strange", strange[0]))
    return Reason("p15", answer, Verdict.YES, TEXTS.said("r.p15.can", joined([TEXTS.said(f"r.board.{number}") for number in boards])))


def _axes(answers: Mapping[str, str]) -> Reason:
    answer = answers["axes"].strip()
    count = int(answer)
    if count > 32:
        return Reason("axes", answer, Verdict.NO, TEXTS.said("r.axes.many"))
    return Reason("axes", answer, *((Verdict.WITH, TEXTS.said("r.axes.buses")) if count > 12 else (Verdict.YES, TEXTS.said("r.axes.yes"))))


_TABLE: Mapping[str, Mapping[str, Verdict]] = {
    "drives": {"servodyn": Verdict.WITH, "analog": Verdict.NO, "new": Verdict.YES, "other": Verdict.NO},
    "plc": {
        "rk512": Verdict.YES, "3964r": Verdict.YES, "can": Verdict.YES, "bits": Verdict.WITH, "internal": Verdict.WITH,
        "modbus": Verdict.YES, "none": Verdict.WITH,
    },
    "pic": {"yes": Verdict.WITH, "no": Verdict.YES},
    "baps": {"yes": Verdict.WITH, "no": Verdict.YES, "positions": Verdict.YES},
    "backups": {"yes": Verdict.YES, "printed": Verdict.WITH, "no": Verdict.WITH},
    "sister": {"yes": Verdict.YES, "no": Verdict.WITH},
}  # fmt: skip


def _by_table(answers: Mapping[str, str]) -> list[Reason]:
    found = []
    for key, rows in _TABLE.items():
        own = key in ("pic", "baps") and answers[key] == "yes"  # which programs run depends on the control they were written for
        kinds = {"rho3": "", "reis": ".reis", **({"val3": ".val3"} if key == "baps" else {})}
        control = kinds.get(answers["control"], ".other") if own else ""
        found.append(Reason(key, answers[key], rows[answers[key]], TEXTS.said(f"r.{key}.{answers[key]}{control}")))
    return found


def _risk(answers: Mapping[str, str]) -> Reason:
    name = answers["risk"].strip()
    if name.lower() in ("nobody", "no", "-", "niemand", "nein"):
        return Reason("risk", name, Verdict.NO, TEXTS.said("r.risk.none"))
    return Reason("risk", name, Verdict.YES, TEXTS.said("r.risk.yes", name))
