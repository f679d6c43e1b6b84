"""Date of a virtual run: the same in every run (AX-725)."""

import datetime

from gateway.pure.languages.base.requests import Ns

START = datetime.datetime(2020, 1, 1)


def date_at(now: Ns) -> datetime.datetime:
    """Date and time of a moment of the run."""
    return START + datetime.timedelta(microseconds=now // 1000)
