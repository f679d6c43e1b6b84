"""A shipped cell as its owner completes it for metal: target "machine" and [safety] filled in."""

import re

GIVEN = {
    "emergency_stop": '"safety relay -K20"',
    "sto_wired": "true",
    "guard": '"fence with interlock -S31"',
    "limit_switches": '"hard-wired into the drives"',
    "risk_assessment": '"RA-2026-014"',
    "last_stop_test": "2026-11-20",
}


def on_a_machine(text: str) -> str:
    """The text of the cell file; comments and lines stay where they are."""
    text, count = re.subn(r'(target\s*= )"simulation"', r'\1"machine"', text, count=1)
    for key, value in GIVEN.items():
        text, found = re.subn(rf"(?m)^(?:# )?({key} *= )[^ \n]+", rf"\g<1>{value}", text, count=1)
        count += found
    assert count == 1 + len(GIVEN), "the shipped cell names every field"
    return text
