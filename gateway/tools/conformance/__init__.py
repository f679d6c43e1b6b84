"""The tools of `axisgate conformance`, one function each."""

from gateway.tools.conformance.run import run_suite
from gateway.tools.conformance.tools import compare_reports, list_suites, new_case, new_pics, play_mutants, verify_folder

__all__ = ["compare_reports", "list_suites", "new_case", "new_pics", "play_mutants", "run_suite", "verify_folder"]
