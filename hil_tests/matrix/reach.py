"""Which part of a running gateway reaches a function: a cell, a motion program, a command, or only a test (API only).

cell: the processes of a run, without what reads motion programs; program: with it; command: the commands of axisgate.
"""

import functools
from collections import Counter
from collections.abc import Iterable, Mapping

from gateway.registry import CELL_CHECKS
from hil_tests.matrix.callgraph import CallGraph

KINDS = ("cell", "program", "command", "API only")
PROCESSES = ("gateway.processes.", "gateway.cycle.", "gateway.services.", "gateway.simulation.", "gateway.shadow.")
COMMANDS = "gateway.commands."
PLANNER = "gateway.processes.planner"  # serves motion programs and nothing else
PROGRAMS = "motion.program"
VAL3 = "gateway.pure.languages.val3"
ASSEMBLED = {  # what programs of a language call is found by its name when they run
    f"{VAL3}.machine:Machine._names": (
        *((f"{VAL3}.{module}", "") for module in ("numbers", "strings", "arrays")),
        *(
            (f"{VAL3}.builtin_{module}", prefix)
            for module in ("geometry", "io", "libraries", "moves", "pages", "robot", "tasks")
            for prefix in ("f_", "trsf_product", "trsf_inverse", "joint_sum", "joint_difference")
        ),
    ),
    f"{VAL3}.translate:ProgramTranslator._statement": ((f"{VAL3}.translate", "ProgramTranslator._do_"),),
    **{  # the registry's rows name modules, which are imported by that name
        f"gateway.checks:{function}": tuple((f"gateway.checks.{name}", table) for name in CELL_CHECKS)
        for function, table in (("cross_faults", "CHECKS"), ("notices", "NOTES"))
    },
    "gateway.pure.languages.baps2.translation:Unit.load": (("gateway.pure.languages.baps2.values", ""),),
}


@functools.cache
def product() -> CallGraph:
    """All of the product's sources, read once."""
    return CallGraph(assembled=ASSEMBLED)


@functools.cache
def kinds() -> Mapping[str, str]:
    """Of everything the product defines, by "module:qualname": one of KINDS."""
    graph = product()
    mains = {name: f"{name}:main" for name, module in graph.modules.items() if "main" in module.nodes}
    processes = [main for name, main in mains.items() if name.startswith(PROCESSES)]
    commands = [main for name, main in mains.items() if name.startswith(COMMANDS)]
    found = {f"{module.name}:{name}": "API only" for module in graph.modules.values() for name in module.nodes}
    found |= dict.fromkeys(graph.reached([*processes, *commands]), "command")
    found |= dict.fromkeys(graph.reached(processes), "program")
    found |= dict.fromkeys(graph.reached([main for main in processes if main != mains[PLANNER]], _of_programs), "cell")
    return found


def _of_programs(module: str) -> bool:
    return module in (PLANNER, PROGRAMS) or module.startswith(f"{PROGRAMS}.")


def reach_of(functions: Iterable[str], of: Mapping[str, str]) -> str:
    """The nearest of what comes to these functions, with how many of them it is when it is not all; "" for none."""
    count = Counter(of.get(function, "API only") for function in functions)
    nearest = next((kind for kind in KINDS if count[kind]), "")
    others = count["API only"] if nearest != "API only" else 0
    return f"{nearest} ({count.total() - others} of {count.total()})" if others else nearest
