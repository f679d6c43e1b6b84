"""What foreign stations and independent geometry found wrong with serial lines and motion, and the test that shows each sentence untrue.

A sentence is a key of SENTENCES, a test `file::function` below hil_tests.  Look here first where one of them seems to be true again.
"""

import ast
import functools

import pytest

from hil_tests.purity import ROOT

TOOLS = "unit/gateway/conformance/serial/test_words.py"
TTYS = "rig/line_tools/test_foreign_ttys.py"
REST = "requirements/p3964r/test_rest_of_a_block.py"
OPEN = "requirements/p3964r/test_open_choices.py"
POLE = "properties/test_pole_lines.py"
SLOW = "unit/motion/program/test_slow_programs.py"
ROUND = "unit/motion/program/test_rounding_is_never_slower.py"
FIGURES = "unit/motion/program/test_figures_by_text.py"
SERVER = "unit/gateway/services/test_tool_server.py"

SENTENCES: dict[str, tuple[str, ...]] = {
    # ---- serial lines
    "a command behind an untaken reaction gets the old command's reaction": (
        "properties/test_rk512_broken_dialogues.py::test_each_reaction_answers_its_own_command",
        "requirements/rk512/test_station.py::test_a_new_command_withdraws_the_reaction_under_way",
    ),
    "a tool takes the reaction that a partner without priority kept for the answer to its command": (
        "unit/gateway/conformance/serial/test_transfer.py::test_a_reaction_somebody_left_untaken_is_not_the_answer_to_the_next_command",
        "unit/gateway/conformance/serial/test_transfer.py::test_a_reaction_kept_since_before_the_tool_was_there_is_passed_over_where_it_does_not_fit",
    ),
    "with no pause all later answers are shifted by one": (
        "properties/test_rk512_broken_dialogues.py::test_each_reaction_answers_its_own_command",
    ),
    "a long job that begins anew is told a sequence error": (
        "properties/test_rk512_broken_dialogues.py::test_a_plc_that_starts_again_in_a_long_job_gets_no_sequence_error",
        "requirements/rk512/test_station.py::test_a_first_telegram_after_an_untaken_reaction_begins_anew_and_a_follow_on_goes_on",
    ),
    "an empty read counts as a hang-up": (
        f"{TTYS}::test_settings_somebody_else_changes_do_not_hang_the_port_up",
        f"{TTYS}::test_a_far_end_that_goes_away_is_reported_at_once",
    ),
    "fetch and send fail on a real tty": (f"{TTYS}::test_fetch_and_send",),
    "probe fails on a real tty": (f"{TTYS}::test_the_probe_runs_to_its_end",),
    "diagnose fails on a real tty": (f"{TTYS}::test_diagnose_finds_nothing_wrong",),
    "monitor and its taps fail on a real tty": (f"{TTYS}::test_monitor_of_one_port_and_of_two_taps",),
    "learn fails on a real tty": (f"{TTYS}::test_learn_from_living_taps",),
    "doctor serial fails on a real tty": (f"{TTYS}::test_doctor_measures_an_echo",),
    "taps of a shadow fail on a real tty": (f"{TTYS}::test_taps_of_a_shadow_hear_both_sides",),
    "the tools fail at a UART of the machine": (
        f"{TTYS}::test_a_real_uart_is_silent_and_not_gone",
        f"{TTYS}::test_the_tools_at_a_real_uart_do_not_call_it_gone",
    ),
    "the last DLE of a tool is lost when the next tool opens a tty that a program serves": (
        "unit/drivers/ports/test_tty_of_a_program.py::test_the_last_characters_of_one_user_are_not_lost_when_the_next_one_opens_it",
    ),
    "probe --write announces words behind a refused FETCH and sends none": (f"{TOOLS}::test_nothing_is_written_that_was_not_read",),
    "probe --write sends into a block that should be missing": (f"{TOOLS}::test_a_missing_block_that_is_there_is_not_written_into",),
    "FF of a foreign pty is taken for a mark": (
        f"{TTYS}::test_fetch_and_send",
        "rig/serial/test_line_process.py::test_a_foreign_program_at_a_side_that_offers_marks_reads_characters_as_they_are",
        "rig/serial/test_line_process.py::test_a_plain_side_reads_characters_as_they_are",
    ),
    "marks come unasked": (
        "unit/drivers/ports/test_pty_marks.py::test_a_port_asks_for_marks_until_it_is_closed",
        "unit/drivers/ports/test_pty_marks.py::test_a_foreign_program_that_locks_the_whole_pty_asks_for_nothing",
    ),
    "STX in the burst behind garbage is not answered": (f"{REST}::test_a_wish_in_the_burst_behind_garbage_is_answered_at_once_and_once",),
    "STX within ZVZ of a burst that was passed over is not answered": (
        f"{REST}::test_a_lone_stx_among_stray_characters_is_a_wish_one_with_company_is_not",
        f"{REST}::test_a_wish_behind_the_end_of_a_block_in_one_burst_is_granted_when_the_line_is_quiet",
    ),
    "cp341 is back later than 2 s behind garbage": (
        "properties/test_behind_garbage.py::test_a_foreign_station_is_served_within_two_seconds_of_any_garbage",
        f"{REST}::test_a_strict_sender_is_served_within_two_seconds_of_any_garbage",
    ),
    "an acknowledgement before our own count does not count": (
        "requirements/p3964r/test_7_1_sending.py::test_an_acknowledgement_shortly_before_a_late_report_counts_by_the_length_of_the_block",
        "rig/sources/test_early_acknowledgement.py::test_the_tools_take_it_with_their_format",
        "rig/sources/test_early_acknowledgement.py::test_a_usb_device_that_speaks_serial_itself_answers_at_once_and_a_uart_cannot",
    ),
    "an acknowledgement before our own count does not count in a cell": (
        "rig/sources/test_early_acknowledgement.py::test_a_running_cell_takes_it",
        f"{TTYS}::test_a_cell_with_a_paced_format_takes_the_early_acknowledgement",
    ),
    "profile linux does not take DLE x, or 4,000 bytes": (
        f"{OPEN}::test_linux_drops_a_lone_dle_and_takes_what_follows",
        f"{OPEN}::test_linux_takes_4000_characters_and_sends_256",
        "requirements/p3964r/test_linux_discipline.py::test_blocks_of_4000_characters_are_taken",
    ),
    "profile linux does not yield in a repeat": (
        f"{OPEN}::test_linux_with_priority_receives_in_the_first_conflict_of_a_repeat",
        "requirements/p3964r/test_linux_discipline.py::test_with_priority_it_yields_in_a_repeat_and_both_blocks_arrive",
    ),
    "raw telegrams end at 138 characters whatever the profile": (
        "unit/gateway/cell_file/test_telegram_checks.py::test_a_telegram_may_be_as_long_as_a_block_of_its_lines_profile",
    ),
    "receive.length-over is FAIL": (f"{TOOLS}::test_a_longer_buffer_than_the_profile_s_is_a_warning",),
    "services show no life for 250 ms under a flood": (
        "unit/gateway/test_flooded_line.py::test_one_turn_of_a_flooded_line_is_bounded",
        f"{SERVER}::test_however_many_tools_ask_one_of_them_is_answered_a_turn",
        f"{SERVER}::test_a_name_that_is_unknown_costs_a_large_cell_no_more_than_a_small_one",
        "unit/gateway/web/test_line_tap.py::test_of_a_flooded_line_the_newest_characters_are_kept_and_no_more",
        "rig/death/test_floods.py::test_tools_and_modbus_clients_that_flood_end_nothing",
    ),
    "run --record writes whatever a flood brings": (
        "unit/journal/test_bounded_file.py::test_a_flood_stays_within_its_bound_and_the_newest_is_kept",
        "unit/journal/test_bounded_file.py::test_each_part_of_a_line_s_journal_begins_with_its_head",
    ),
    "'1 connection attempts'": (f"{TOOLS}::test_one_attempt_is_one",),
    "64 words are told under --words 32": (f"{TOOLS}::test_the_titles_name_the_words_that_are_allowed",),
    "a partner that polls is told a USB latency timer": (f"{TOOLS}::test_a_partner_that_polls_has_no_usb_timer",),
    "'its buffer is full' for a block that is too long": (f"{TOOLS}::test_a_block_too_long_is_no_full_buffer",),
    "monitor is silent on a quiet line": (f"{TOOLS}::test_a_monitor_says_that_nothing_comes",),
    "learn takes our own test blocks for the partner's": (f"{TOOLS}::test_our_own_test_blocks_teach_nothing",),
    # ---- motion
    "a line past the wrist pole passes check with a jump of half a turn": (
        f"{POLE}::test_every_line_beside_the_wrist_pole_is_run_where_its_joints_can_follow_it_and_reported_where_not",
        "unit/motion/kinematics/test_arm.py::test_a_path_takes_the_nearer_of_the_two_wrists_however_far_a_step_is",
    ),
    "smooth lines beside the pole are refused, or their way back": (
        f"{POLE}::test_every_line_beside_the_wrist_pole_is_run_where_its_joints_can_follow_it_and_reported_where_not",
        f"{POLE}::test_a_line_exactly_through_the_pole_goes_straight_on_and_one_from_or_into_it_as_well",
    ),
    "check, plot and cell differ beside the pole": (
        "unit/motion/program/test_pole_lines_in_a_cell.py::test_check_plot_and_cell_agree_on_lines_beside_the_pole",
    ),
    "a small radius takes longer than the stop": (f"{ROUND}::test_one_corner",),
    "many tiny rounded moves take longer than with stops": (
        f"{ROUND}::test_rows_of_tiny_moves",
        f"{ROUND}::test_corners_that_become_known_while_the_axes_run",
    ),
    "check refuses rounded lines that a cell runs": (
        f"{SLOW}::test_many_rounded_lines_known_at_once_are_handed_on_in_parts_as_those_known_one_by_one",
        f"{SLOW}::test_what_check_says_of_three_minutes_of_curve_of_an_arm_is_what_a_cell_does",
    ),
    "three minutes of curve are refused": (f"{SLOW}::test_three_minutes_of_curve_pass_check_and_planner_and_their_law_is_made_in_slices",),
    "a row of more than 505 splines dies in a cell": (
        "unit/motion/program/test_long_rows_in_a_cell.py::test_600_splines_run_in_a_cell",
        "unit/motion/program/test_long_rows_in_a_cell.py::test_a_fault_in_a_long_row_names_its_line_and_nothing_moves",
    ),
    "a law without an end is a traceback of arange": (f"{SLOW}::test_what_would_take_endless_is_reported_and_no_law_is_tried",),
    "a URDF of seven joints ends in a singular matrix": (
        "unit/motion/kinematics/test_seven_joints.py::test_poses_are_reached_from_near_and_from_far_away",
        "unit/motion/kinematics/test_seven_joints.py::test_a_line_is_run_straight_within_the_limits_and_one_too_long_is_reported",
        "unit/motion/kinematics/test_urdf_files.py::test_what_is_wrong_with_a_urdf_is_said",
    ),
    "numbers of NumPy are no numbers": ("unit/motion/paths/test_splines.py::test_tolerance_and_tension_are_numbers_of_any_kind",),
    "the smaller of pathaccel and pathdecel counts for both": (
        "unit/motion/program/test_accel_and_decel.py::test_the_way_speeds_up_with_pathaccel_and_slows_down_with_pathdecel",
    ),
    "program text is slower than the bench": (
        f"{FIGURES}::test_the_wide_u_of_a_portal",
        f"{FIGURES}::test_the_u_of_an_arm_takes_its_short_legs_whole",
        f"{FIGURES}::test_the_contour",
    ),
    "block_search 5 and 11 exceed 1.05 of the jerk limit": (
        "unit/motion/program/test_block_search.py::test_ends_of_the_path_that_move_on_keep_the_jerk",
    ),
}


@functools.cache
def functions_of(file: str) -> frozenset[str]:
    tree = ast.parse((ROOT / "hil_tests" / file).read_text())
    return frozenset(node.name for node in tree.body if isinstance(node, ast.FunctionDef))


@pytest.mark.parametrize("sentence", SENTENCES)
def test_a_sentence_has_the_tests_that_show_it_untrue(sentence: str) -> None:
    missing = [test for test in SENTENCES[sentence] if test.partition("::")[2] not in functions_of(test.partition("::")[0])]
    assert SENTENCES[sentence] and not missing


def test_the_property_of_the_pole_is_played_with_ten_thousand_lines() -> None:
    assert "AXISGATE_POLE_LINES=$(or $(POLE),10000)" in (ROOT / "Makefile").read_text()
