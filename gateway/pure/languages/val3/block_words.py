"""Words that open and close blocks, and which of them a misspelt word was meant to be: a slip in it is one fault, not two."""

import re

from gateway.pure.languages.base.near import nearest

CLOSERS = {"endif": "if", "endwhile": "while", "until": "do", "endfor": "for", "endswitch": "switch"}
OPENERS = {opener: closer for closer, opener in CLOSERS.items()}
SHOWN = {"endif": "endIf", "endwhile": "endWhile", "endfor": "endFor", "endswitch": "endSwitch"}
OTHERS = ("else", "elseif", "case", "default", "break", "call", "return", "begin", "end", "taskcreate", "taskcreatesync")
_TWO_WORDS = re.compile(r"\s*end\s+(if|while|for|switch)\s*$", re.IGNORECASE)
_FIRST = re.compile(r"\s*(\w+)(?:\s*$|\s+[\w!(\"]|\()")


def shown(word: str) -> str:
    """A closing word as the manual writes it."""
    return SHOWN.get(word, word)


def end_in_two_words(line: str) -> str:
    """The closing word that `end if` was meant to be; "" for another line."""
    found = _TWO_WORDS.match(line)
    return f"end{found[1].lower()}" if found else ""


def meant_word(line: str) -> tuple[str, bool]:
    """The word of a block that a faulty line begins with, and whether it is certain: the word as such, or one that is like it."""
    if closer := end_in_two_words(line):
        return closer, True
    found = _FIRST.match(line)
    word = found[1].lower() if found else ""
    if word in OPENERS or word in CLOSERS or word in OTHERS or not word:
        return word, True
    if word == "fi":
        return "if", False
    return nearest(word, (*OPENERS, *CLOSERS, *OTHERS)), False
