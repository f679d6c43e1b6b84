"""What a cell file uses twice: one fault for one mistake (AX-1420), at the line of the second table."""

from hil_tests.unit.gateway.cell_file.test_load import edited, faults_of, keys, text_of


def test_one_node_for_two_axes_is_one_fault() -> None:
    assert keys(faults_of(edited("s5-rk512", ("node = 2, eds", "node = 1, eds")))) == ["axis.Y.drive.node"]


def test_a_name_used_twice_is_reported_at_the_second_table() -> None:
    (fault,) = [fault for fault in faults_of(edited("demo", ('name   = "A2" ', 'name   = "A1" '))) if fault.key == "axis.A1.name"]
    second = next(number for number, line in enumerate(text_of("demo").splitlines(), 1) if line.startswith('name   = "A2"'))
    assert fault.line == second
