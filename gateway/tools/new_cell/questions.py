"""The questions of `axisgate new`, for each kind of cell: key, text, default, and the form of an answer."""

import ipaddress
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

from gateway.pure.cell.modbus import Modbus


class BadAnswer(ValueError):
    """An answer that cannot be used for a cell; the message names key, answer and valid values."""


@dataclass(frozen=True, slots=True)
class Question:
    """`check` returns the answer in the form of the cell; raises ValueError with the allowed values."""

    key: str
    text: str
    default: str
    check: Callable[[str], str]


def _text(answer: str) -> str:
    if not answer or '"' in answer or "\\" in answer or not answer.isprintable():
        raise ValueError("a text without quotes and backslashes")
    return answer


def _number(low: int, high: int) -> Callable[[str], str]:
    def check(answer: str) -> str:
        if not re.fullmatch(r"\d{1,5}", answer) or not low <= int(answer) <= high:
            raise ValueError(f"a number from {low} to {high}")
        return str(int(answer))

    return check


def _one_of(*allowed: str) -> Callable[[str], str]:
    def check(answer: str) -> str:
        if answer not in allowed:
            raise ValueError(f"one of {', '.join(allowed)}")
        return answer

    return check


def _bind(answer: str) -> str:
    host, _, port = answer.rpartition(":")
    if not host or not re.fullmatch(r"\d{1,5}", port) or not 1 <= int(port) <= 65535:
        raise ValueError("HOST:PORT, port 1 to 65535; 127.0.0.1 is only this machine")
    return _text(answer)


def _partner(answer: str) -> str:
    try:
        ipaddress.ip_network(answer, strict=False)
    except ValueError:
        raise ValueError("the address of the PLC, 10.0.0.5, or its network, 10.0.0.0/24; only it may write") from None
    return answer


def _from_elsewhere(answer: str) -> str:
    """For a server that other computers reach: no default, and not this computer."""
    if not answer or ipaddress.ip_network(_partner(answer), strict=False).is_loopback:
        raise ValueError("other computers reach this bind; the address of the PLC that may write is needed, 10.0.0.5")
    return answer


NAME = Question("name", "What is the machine called?", "New cell", _text)
LINE = Question("port", "Serial line to the PLC (/dev/serial/by-id/..., tcp://HOST:PORT, or sim)?", "sim", _text)
AXES = Question("axes", "How many axes (1..6)?", "3", _number(1, 6))
DRIVES = Question("drives", "New CiA 402 drives, or SERVODYN boosters that stay?", "cia402", _one_of("cia402", "servodyn"))
BIND = Question("bind", "Address of the Modbus TCP server?", "127.0.0.1:1502", _bind)
PLC = Question("plc", "Address of the PLC on Modbus TCP (only it may write)?", "127.0.0.1", _partner)

QUESTIONS: Mapping[str, tuple[Question, ...]] = {
    "s5-rk512": (
        NAME,
        LINE,
        Question("profile", "Communication processor (siemens-cp525, siemens-cp340 ...)?", "siemens-cp525", _text),
        AXES,
        Question("db", "Number of the block with the commands (status is the next one)?", "10", _number(2, 253)),
    ),
    "rho3": (
        NAME,
        Question("software", "Software of the rho 3 (TO01 .. TO07)?", "TO05I", _text),
        LINE,
        AXES,
        BIND,
        PLC,
    ),
    "reis": (NAME, LINE, AXES, DRIVES, BIND, PLC),
    "modbus": (
        NAME,
        BIND,
        AXES,
        DRIVES,
        Question("silence", "Stop when the PLC is silent for how many ms?", "500", _number(50, 60000)),
        PLC,
    ),
}  # fmt: skip


def answered(kind: str, given: Mapping[str, str], ask: Callable[[Question], str]) -> dict[str, str]:
    """The answer to each question: given, else asked; an empty one is the default.  Raises BadAnswer."""
    unknown = set(given) - {question.key for question in QUESTIONS[kind]}
    if unknown:
        keys = ", ".join(question.key for question in QUESTIONS[kind])
        raise BadAnswer(f"{', '.join(sorted(unknown))}: not asked for {kind}; its answers are {keys}")
    answers: dict[str, str] = {}
    for each in QUESTIONS[kind]:
        outside = each is PLC and not Modbus("", bind=answers["bind"]).local
        question = replace(each, default="", check=_from_elsewhere) if outside else each
        answer = given[question.key] if question.key in given else ask(question)
        try:
            answers[question.key] = question.check((answer or question.default).strip())
        except ValueError as error:
            raise BadAnswer(f"{question.key} = {answer}: {error}") from error
    return answers
