"""Where the modules of the rig run in a complete run: folders of hil_tests/rig, or modules `folder/file`.

In the order of a run: COMMANDS and the pure tests in two processes (hil_tests/pair.py), at the same time the guests
(hil_tests/rig/uml/lane.py), BESIDE and all modules that are not listed; then, two at a time, what failed there; then ALONE
(hil_tests/host.py).
"""

from collections.abc import Sequence

import pytest

from hil_tests import lanes

RIG = "hil_tests/rig/"
PURE = tuple(f"hil_tests/{folder}/" for folder, lane in lanes.FOLDERS.items() if lane == "pure")
OWN_TIME = (  # in guests with a clock of their own: whole cells that a late cycle would stop; lines that wait for seconds
    *("belts", "planner", "scope", "shadow"),
    *(
        "canopen/test_commissioning.py",
        "canopen/test_commissioning_ends.py",
        "canopen/test_cycle_ring.py",
        "canopen/test_demo_402.py",
        "canopen/test_durand.py",
        "canopen/test_emulator_nodes.py",
        "canopen/test_first_enable.py",
        "canopen/test_judge_p402.py",
        "canopen/test_master_goes_on.py",
        "canopen/test_route_to_a_parameter.py",
        "canopen/test_s5_plays.py",
        "canopen/test_shadow_on_canopen.py",
    ),
    *("line_tools/test_learn_the_demo.py", "line_tools/test_tools_on_a_cable.py", "modbus/test_modbus_probe.py"),
    *("death/test_slow_monitor.py", "rho3/test_rho3_lines.py", "serial/test_line_3964r.py"),
)
COMMANDS = (  # they start or call commands and read files; what they prove depends on no clock
    *("completion", "datfiles", "demo/test_demo_on_a_slow_machine.py", "editor", "motion"),
    *("bridge/test_mapping_command.py", "broker/test_socketcan_refusals.py", "cell/test_commands.py", "sources/test_modbus_source.py"),
    *(
        "house/test_awake.py",
        "house/test_check_modules.py",
        "house/test_commands.py",
        "house/test_cycle_modules.py",
        "house/test_every_command.py",
        "house/test_matrix.py",
    ),
    *("house/test_mutant.py", "house/test_pair.py", "house/test_places.py", "house/test_small_runs.py"),
    *("line_tools/test_any_system.py", "line_tools/test_commands.py", "line_tools/test_export_is_there.py"),
    *("rho3can/test_bus_infer_command.py", "rho3can/test_import_command.py"),
    *("starting/test_make_check.py", "starting/test_new_and_assess.py"),
    *("trace/test_trace_guide.py", "trace/test_tshark.py", "val3_sio/test_guide.py", "web/test_store.py"),
)
BESIDE = (  # real processes that wait more than they compute, with long time limits: they passed under six times the load of the processors
    *(
        "bus_tools",
        "canopen/test_commissioning_on_a_bus.py",
        "canopen/test_emergency_storm.py",
        "canopen/test_endless_upload.py",
        "canopen/test_look_before_talking.py",
        "doctor",
        "monitor",
        "northbound",
        "retain",
        "bench/test_bench_short.py",
    ),
    *("bridge/test_cl300_bits.py", "bridge/test_couplers.py", "bridge/test_example_cells.py", "bridge/test_other_contacts.py"),
    *("bridge/test_pic_timer.py", "broker/test_broker.py", "broker/test_broker_python_can.py", "broker/test_wired_broker.py"),
    *(
        "cycle/test_late_values.py",
        "death/test_requests.py",
        "sources/test_line_roles.py",
        "drives/test_adapter_ports.py",
        "drives/test_listening_only.py",
    ),
    *("drives/test_one_axis_whole.py", "emulator/test_fault_command.py", "image/test_image_death.py", "image/test_image_rules.py"),
    *("modbus/test_mbpoll_run.py", "modbus/test_modbus_cell_run.py", "modbus/test_modbus_judges.py"),
    *("modbus/test_modbus_other_clients.py", "modbus/test_modbus_rtu.py", "modbus/test_modbus_server.py", "modbus/test_modbus_tls.py"),
    *("rho3/test_rho3_guide.py", "serial/test_line_runner.py", "serial/test_rfc2217.py"),
    "programs/test_val3_imported.py",
    *("val3_sio/test_serial.py", "val3_sio/test_tcp_server.py", "val3_sio/test_udp.py"),
    *("bridge/test_route_figures.py", "cell/test_simulated_time_waits.py", "cycle/test_rho3_2_2_one_cycle.py"),
    *("death/test_cycle_dies.py", "death/test_cycle_dies_402.py", "death/test_every_loop_is_watched.py", "death/test_floods.py"),
    *("death/test_line_silence.py", "death/test_output_disk_and_terminal.py", "death/test_services_die.py"),
    *(
        "death/test_terminal_signals.py",
        "death/test_too_many_deaths.py",
        "sources/test_one_tool_in_control.py",
        "sources/test_refused_over_the_line.py",
    ),
    *("drives/test_cell_on_an_adapter.py", "drives/test_two_buses_one_away.py", "emulator/test_emulator_process.py"),
    *("image/test_threads.py", "line_tools/test_foreign_ttys.py", "modbus/test_late_address.py"),
    *("modbus/test_modbus_growth.py", "modbus/test_modbus_links_reported.py", "recording/test_record_and_replay.py"),
    *("rho3can/test_11_1_two_controls.py", "rho3can/test_one_part_is_away.py"),
    *(
        "signals/test_old_control.py",
        "signals/test_reis_cell.py",
        "signals/test_reis_plc.py",
        "signals/test_val3_cell.py",
        "starting/test_first_commands.py",
    ),
    *("starting/test_make_demo.py", "starting/test_wheel.py"),
    *("telegrams/test_order_and_done.py", "trace/test_journal_of_a_real_port.py"),
    *("web/test_changed_users.py", "web/test_hostile_visitors.py", "web/test_page_alarms.py"),
    *("web/test_page_first_steps.py", "web/test_tls.py", "web/test_web_user.py"),
    *("death/test_simulation_dies.py", "death/test_slow_retry.py", "sources/test_own_block_over_rk512.py"),
    *("pythons", "web/test_page_faults.py", "web/test_page_values.py"),
)

LONG = (  # above half a minute each: they start first, so that the run does not wait for one at its end
    *("bench/test_bench_short.py", "cell/test_simulated_time_waits.py", "death/test_requests.py", "death/test_services_die.py"),
    *("death/test_slow_retry.py", "death/test_terminal_signals.py", "line_tools/test_conformance_on_a_pty.py"),
    *("line_tools/test_foreign_ttys.py", "monitor/test_monitor.py", "programs/test_programs_in_a_run.py"),
    *("programs/test_robotstar_guide.py", "programs/test_serial_units_in_a_run.py", "programs/test_val3_guide.py"),
    *("pythons/test_other_pythons.py", "web/test_page_faults.py", "web/test_page_first_steps.py"),
)
ALONE = (  # they measure times, load the machine, or start test runs and guests of their own
    *("broker/test_cycle_reference.py", "death/test_busy_machine.py", "demo/test_demo.py", "emulator/test_servo_reference.py"),
    *("house/test_played_again.py", "image/test_realtime.py", "serial/test_line_process.py", "uml", "web/test_page.py"),
)
NO_OWN_TIME = (  # alone, and never in a guest: processes that use all time, guests, a browser that draws in three dimensions
    *("house/test_played_again.py", "uml/test_guest.py", "web/test_page.py"),
)


def unhurried(item: pytest.Item) -> bool:
    """Return whether it needs neither a quiet machine nor a clock of its own."""
    return item.nodeid.startswith(PURE) or lanes.lane_of(item.nodeid, item.keywords) == "pure" or of_one(item, COMMANDS)


def of_one(item: pytest.Item, places: Sequence[str]) -> bool:
    """Return whether the test is in one of these folders or modules of the rig."""
    module = item.nodeid.partition("::")[0]
    folder, _, rest = module.removeprefix(RIG).partition("/")
    return module.startswith(RIG) and bool(rest) and not {folder, f"{folder}/{rest}"}.isdisjoint(places)
