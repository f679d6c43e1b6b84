"""German of a run's reports about its cases, from `configs/texts/conformance-*.toml`.

The page and the lines of the run are in the user's language; JSON, JUnit and traces are in English, so that two reports can be compared.
"""

import functools
import re
from collections.abc import Mapping
from typing import cast

from gateway.conformance.reporting.document import Json, cases_of
from gateway.conformance.reporting.words_de import GERMAN
from gateway.files.find import PACKAGED
from gateway.files.texts import spoken

SENTENCES = ("reason", "expected", "got")
NEEDED = "not run: the preamble needs {}, which is {} ({})"
NOT_RUN = re.compile(r"not run: the preamble needs (\S+), which is (\S+) \((.*)\)", re.DOTALL)


@functools.cache
def text_files() -> tuple[str, ...]:
    """Names of the files: a suite that is added brings its own."""
    return tuple(sorted(path.stem for path in (PACKAGED / "texts").glob("conformance-*.toml")))


def verdict_text(sentence: str, language: str) -> str:
    """A sentence about a case, in that language; as it is where it has no German."""
    if language != "de":
        return sentence
    if found := NOT_RUN.fullmatch(sentence):  # the other one's reason is a sentence of its own, which may be one of these again
        return GERMAN[NEEDED].format(found[1], found[2], verdict_text(found[3], language))
    return spoken(*text_files()).german(sentence)


def in_german(found: Mapping[str, object]) -> Json:
    """A report with German sentences: reasons, expected and received values, names of times, remarks, assumptions."""
    pics = cast(Json, found.get("pics") or {})
    assumed = [verdict_text(str(each), "de") for each in cast(list[object], pics.get("assumed", []))]
    return {**found, "cases": [_case(each) for each in cases_of(found)], "pics": {**pics, "assumed": assumed}}


def _case(case: Json) -> Json:
    said: Json = {key: verdict_text(str(case[key]), "de") for key in SENTENCES}
    measures = [{**each, "what": verdict_text(str(each["what"]), "de")} for each in cast(list[Json], case["measures"])]
    remarks = [verdict_text(str(each), "de") for each in cast(list[object], case.get("remarks", []))]
    return {**case, **said, "measures": measures, "remarks": remarks}
