"""Contacts on a gpiochip of the kernel: gpio-sim in the guest; the simulator's own files say what a line shows and pull it."""

import contextlib
import os
import pathlib
import subprocess
from collections.abc import Iterator

import gpiod
import pytest

from gateway.processes.gpio import AGAIN_NS, Chip
from gateway.pure.buses.contacts import Said
from gateway.pure.cell.cell import Io, IoDevice
from gateway.pure.image.records.cell import Quality
from hil_tests.rig.uml import guest

pytestmark = pytest.mark.vcan

CONFIGFS = pathlib.Path("/sys/kernel/config")
LINES = 8
LAMP, VALVE, DOOR, KEY = 4, 5, 1, 2


class Simulator:
    """One chip of gpio-sim."""

    def __init__(self) -> None:
        self._folder = CONFIGFS / "gpio-sim" / "axisgate"
        bank = self._folder / "bank0"
        bank.mkdir(parents=True)
        (bank / "num_lines").write_text(str(LINES))
        self.plug()

    def plug(self) -> None:
        (self._folder / "live").write_text("1")
        name = (self._folder / "bank0" / "chip_name").read_text().strip()
        self.path = f"/dev/{name}"
        self._lines = pathlib.Path("/sys/devices/platform", (self._folder / "dev_name").read_text().strip(), name)

    def unplug(self) -> None:
        (self._folder / "live").write_text("0")

    def shows(self, line: int) -> bool:
        return (self._lines / f"sim_gpio{line}" / "value").read_text().strip() == "1"

    def pull(self, line: int, *, up: bool) -> None:
        (self._lines / f"sim_gpio{line}" / "pull").write_text("pull-up" if up else "pull-down")

    def close(self) -> None:
        self.unplug()
        (self._folder / "bank0").rmdir()
        self._folder.rmdir()


@pytest.fixture
def simulator() -> Iterator[Simulator]:
    if guest.OWN_TIME not in os.environ:
        pytest.skip("Debian's guest kernel has no gpio-sim; the one that make test builds has (AX-562)")
    if not (CONFIGFS / "gpio-sim").is_dir():
        subprocess.run(["mount", "-t", "configfs", "none", str(CONFIGFS)], check=True)
    with contextlib.closing(Simulator()) as found:
        yield found


def contacts(path: str) -> dict[int, Io]:
    """Two outputs, one of them active low with on_loss 1, and two inputs, one active low."""
    return {
        0: Io("lamp", IoDevice("gpiochip", output=LAMP, chip=path), "cell.ready"),
        1: Io("valve", IoDevice("gpiochip", output=VALVE, chip=path, active_low=True), "cell.ready", on_loss=1),
        2: Io("door", IoDevice("gpiochip", input=DOOR, chip=path), "I 0.0"),
        3: Io("key", IoDevice("gpiochip", input=KEY, chip=path, active_low=True), "I 0.1"),
    }


def test_outputs_are_on_the_lines_and_inputs_come_from_them(simulator: Simulator) -> None:
    with contextlib.closing(Chip(simulator.path, contacts(simulator.path))) as chip:
        for lamp, valve, door, key in ((True, False, True, False), (False, True, False, True), (True, True, True, True)):
            simulator.pull(DOOR, up=door)
            simulator.pull(KEY, up=not key)
            said = chip.turn({0: lamp, 1: valve}, 0)
            assert (simulator.shows(LAMP), simulator.shows(VALVE)) == (lamp, not valve)
            assert said == {n: Said(value, Quality.GOOD) for n, value in enumerate((lamp, valve, door, key))}


def test_a_line_of_another_program_is_reported_and_taken_when_it_is_free(simulator: Simulator, capfd: pytest.CaptureFixture[str]) -> None:
    other = gpiod.request_lines(simulator.path, consumer="another", config={LAMP: None})
    with contextlib.closing(Chip(simulator.path, contacts(simulator.path))) as chip:
        assert chip.turn({0: True, 1: False}, 0) == {}
        assert "a line is in use by another program; gpioinfo names it" in capfd.readouterr().out
        other.release()
        assert chip.turn({0: True, 1: False}, AGAIN_NS // 2) == {}, "asked again once a second, not more"
        assert chip.turn({0: True, 1: False}, AGAIN_NS)[0] == Said(True, Quality.GOOD) and simulator.shows(LAMP)


def test_a_chip_that_is_pulled_is_reported_and_comes_back(
    simulator: Simulator, capfd: pytest.CaptureFixture[str], tmp_path: pathlib.Path
) -> None:
    """Under a link, as udev makes them: a chip pulled while its lines were in use gets another number from the kernel."""
    link = tmp_path / "chip"
    link.symlink_to(simulator.path)
    with contextlib.closing(Chip(str(link), contacts(str(link)))) as chip:
        assert chip.turn({0: True, 1: True}, 0)[0] == Said(True, Quality.GOOD)
        simulator.unplug()
        link.unlink()
        assert chip.turn({0: True, 1: True}, 1) == {}, "no contact is good"
        assert chip.turn({0: True, 1: True}, AGAIN_NS) == {}
        assert "no such gpiochip" in capfd.readouterr().out
        simulator.plug()
        link.symlink_to(simulator.path)
        said = chip.turn({0: True, 1: False}, 2 * AGAIN_NS)
        assert said and said[0] == Said(True, Quality.GOOD), (simulator.path, capfd.readouterr().out)
        assert simulator.shows(LAMP) and simulator.shows(VALVE)
