#!/usr/bin/env python3
"""The SonicSurface device on a pseudo-terminal: see sonic_surface.test."""
import math
import os
import random
import re
import statistics
import subprocess
import sys
import time

import rospy
from tactile_clay.msg import ArrayDrive

import rig_run
import sonic_surface_calibration
import sonic_surface_silence
from array_stream import PROGRAM, Driver, focus
from modulation_test import FIELD, patch
from rig_run import wait_until
from sonic_surface_boards import FRAME, SILENCE, phases

sys.path.insert(0, os.path.join(rig_run.PACKAGE, 'test', 'emulator'))
from sonic_surface import OFF, STOCK, TACTILE, Emulator  # noqa: E402  pylint: disable=wrong-import-position


class SonicSurface(sonic_surface_calibration.Calibration, sonic_surface_silence.Silence):
    # What is played.

    def test_stock_bytes(self):
        """A frame is C0, FE, 256 phases of the wiring, FD; before it all is silenced, and nothing else is sent but
        swaps."""
        self.stream.points = [focus(0.02, -0.01, 0.16, intensity=1.0)]
        emulator, _ = self.rig()
        wait_until(lambda: len(emulator.since(0)) > 200, 20, '200 swaps')
        received = bytes(emulator.received)
        self.assertEqual(received[:len(SILENCE)], SILENCE)
        full = [s for s in emulator.since(0) if s.sounds and OFF not in s.fronts[0]]
        self.expect_phases(full[-1].fronts, 0, phases(0.02, -0.01, 0.16))
        frame = b'\xc0\xfe' + bytes(full[-1].fronts[0]) + b'\xfd'
        self.assertIn(frame, received)
        self.assertEqual(set(received.split(frame)[-1]) - {0xFD}, set())
        self.assertEqual(emulator.faults(), 0)

    def test_field_bytes(self):
        """Every pattern of a field that is sent is one that the gate judged and `array/drive` tells, byte for byte."""
        drives = []
        subscriber = rospy.Subscriber('array/drive', ArrayDrive, drives.append)
        self.addCleanup(subscriber.unregister)
        self.stream.points, self.stream.modulation = patch(), FIELD
        emulator, _ = self.rig(modulation='field')
        wait_until(lambda: len(emulator.since(0)) > 400, 20, '400 swaps')
        received = bytes(emulator.received)
        self.assertEqual(received[:len(SILENCE)], SILENCE)
        frames = re.findall(rb'\xc0\xfe([\x00-\x20]{256})\xfd', received[len(SILENCE):], re.DOTALL)
        sent = [frame for frame in frames if frame != bytes([OFF] * 256)]
        told = {bytes(OFF if amplitude == 0 else round(phase * 32 / (2 * math.pi)) % 32
                      for phase, amplitude in zip(drive.phase, drive.amplitude)) for drive in drives}
        self.assertGreater(len(sent), 20)
        self.assertEqual([frame for frame in sent if frame not in told], [])
        self.assertGreater(len(set(sent[-1])), 16, 'phases of a field, not of a plane wave')
        played = {bytes(swap.fronts[0]) for swap in emulator.since(0) if swap.sounds}
        self.assertEqual(played - set(sent), set())
        self.assertEqual(emulator.faults(), 0)

    def test_stock_modulation(self):
        """Swaps with a silent buffer, 400 a second for 200 Hz, half of the time silent."""
        emulator, _ = self.rig()
        time.sleep(0.3)
        start = time.monotonic()
        time.sleep(2.0)
        swaps = emulator.since(start)
        self.assertEqual([a.sounds != b.sounds for a, b in zip(swaps, swaps[1:])], [True] * (len(swaps) - 1))
        # The median, for a busy machine wakes the driver late now and then.
        rate = 0.5 / statistics.median(b.when - a.when for a, b in zip(swaps, swaps[1:]))
        print('modulation: %.1f Hz, expected 200' % rate)
        self.assertAlmostEqual(rate, 200.0, delta=10.0)

    def test_intensity_switches_off_channels(self):
        """Half of the amplitude: half of the channels."""
        self.stream.points = [focus(intensity=0.5)]
        emulator, _ = self.rig()
        time.sleep(0.5)
        on = sum(value != OFF for value in [s for s in emulator.since(0) if s.sounds][-1].fronts[0])
        self.assertAlmostEqual(on, 128, delta=2)

    def test_two_boards(self):
        """Each board gets the phases of its own place, and both swap at once."""
        self.stream.points = [focus(0.1, 0.0, 0.2, intensity=1.0)]
        emulator, _ = self.rig(boards=2)
        time.sleep(0.5)
        full = [s for s in emulator.since(0) if s.sounds and all(OFF not in front for front in s.fronts)]
        self.expect_phases(full[-1].fronts, 0, phases(0.1, 0.0, 0.2))
        self.expect_phases(full[-1].fronts, 1, phases(0.1 - 0.168, 0.0, 0.2))
        self.assertEqual(emulator.faults(), 0)

    def test_tactile_firmware(self):
        """16 phases, modulation by the board at 1250/6 Hz, no byte that this firmware does not know."""
        self.stream.points = [focus(0.0, 0.03, 0.18, intensity=1.0)]
        emulator, driver = self.rig(firmware=TACTILE)
        time.sleep(0.5)
        self.assertIn('expected firmware_corrections', driver.words())
        self.assertAlmostEqual(emulator.boards[0].modulation(), 1250.0 / 6)
        full = [s for s in emulator.since(0) if s.sounds and OFF not in s.fronts[0]]
        self.expect_phases(full[-1].fronts, 0, phases(0.0, 0.03, 0.18, 16), 16, 2)
        self.assertEqual(emulator.faults(), 0)

    def newest_wins(self, most, **rig):
        self.stream.modulation_frequency = rig.pop('frequency')
        moving = iter(range(10**9))
        points = [[focus(1e-3 * step, 0.0, 0.17)] for step in range(-40, 41)]
        emulator, _ = self.rig(**rig)
        start = time.monotonic()
        before = len(emulator.received)
        while time.monotonic() < start + 2.0:
            self.stream.points = points[next(moving) % len(points)]
            time.sleep(0.005)
        frames = (len(emulator.received) - before) / 258 / rig.get('boards', 1) / 2.0
        print('%.1f frames a second, at most %.1f; longest queue %.1f ms' % (frames, most, 1e3 * emulator.lag))
        self.assertLessEqual(frames, most * 1.02)
        self.assertGreater(frames, 10)
        # Silence is two frames for each of the two boards that may hear; no more than that ever stands before the wire.
        self.assertLess(emulator.lag, 4.4 * FRAME)
        # And the last thing asked for is what plays in the end.
        self.stream.points = [focus(0.05, 0.05, 0.2, intensity=1.0)]
        time.sleep(0.5)
        full = [s for s in emulator.since(0) if s.sounds][-1]
        board = 0
        self.expect_phases(full.fronts, board, phases(0.05, 0.05, 0.2))

    def test_newest_wins_unmodulated(self):
        self.newest_wins(89.3, frequency=0.0)

    def test_newest_wins_modulated(self):
        self.newest_wins(89.3, frequency=200.0)

    def test_newest_wins_two_boards(self):
        self.newest_wins(44.7, frequency=200.0, boards=2)

    def test_more_points_than_it_takes(self):
        """Phases of hundreds of points would take seconds, in which no emergency stop was heard."""
        emulator, _ = self.rig()
        for count, passes in ((100, False), (16, True), (17, False)):
            self.stream.points = [focus(0.02 * (n % 4) - 0.03, 0.02 * (n // 4 % 4) - 0.03, 0.2, number=n)
                                  for n in range(count)]
            self.states.wait(lambda state: state.emitting if passes else 'at most 16' in state.silent_reason)
        wait_until(emulator.silent_for_good, 10, 'silence of both buffers')

    def test_rises_from_silence_after_a_pause(self):
        """By the slew, however loud it was before."""
        def channels(swaps):
            return [sum(value != OFF for value in swap.fronts[0]) for swap in swaps if swap.sounds]
        emulator, _ = self.rig(intensity_slew=0.5)
        wait_until(lambda: channels(emulator.since(0))[-1:] > [120], 20, 'half of the channels')
        self.stream.stop()
        wait_until(emulator.silent_for_good, 10, 'silence of both buffers')
        since = time.monotonic()
        self.renew_stream()
        wait_until(lambda: channels(emulator.since(since)), 10, 'a sound')
        self.assertLess(channels(emulator.since(since))[0], 64)

    # Whatever was sent before.

    def test_boards_are_put_right(self):
        """From any state: silent after opening, a sound from each board of the driver, silent in the end."""
        dice = random.Random(11)
        for boards, firmware, there in ((1, STOCK, 1), (1, STOCK, 2), (2, STOCK, 2), (1, TACTILE, 1)):
            for state in ('power on', 'left deselected', 'scrambled', 'scrambled'):
                with self.subTest(boards=boards, firmware=firmware, there=there, state=state):
                    self.stream.points = []
                    emulator = self.enterContext(Emulator(os.path.join(self.folder, 'boards'), there, firmware))
                    for board in emulator.boards:
                        board.power_on()
                        if state == 'scrambled':
                            board.scramble(dice)
                    if state == 'left deselected' and firmware == STOCK:
                        for byte in [0xC0, 0xFE] + [5] * 256 + [0xC1, 0xFE] + [9] * 256 + [0xFD]:
                            for board in emulator.boards:
                                board.feed(byte)
                        self.assertFalse(emulator.boards[0].selected)
                    driver = self.drive(emulator, 'boards=%d firmware=%s' % (boards, firmware))
                    self.states.wait(lambda state: state.silent_reason == 'no focal points')
                    wait_until(emulator.silent_for_good, 10, 'silence after opening\n' + driver.words())
                    self.stream.points = [focus(0.02, 0.0, 0.17, 1.0)]
                    wait_until(lambda: all(board.sounds() for board in emulator.boards[:boards]), 10,
                               'a sound of each board')
                    self.assertFalse(any(board.sounds() for board in emulator.boards[boards:]))
                    driver.__exit__()
                    wait_until(emulator.silent_for_good, 10, 'silence in the end')
                    self.assertTrue(all(board.clocks for board in emulator.boards) and emulator.boards[0].selected)
                    self.assertEqual(emulator.faults(), 0)
                    emulator.__exit__()

    # Wrong use.

    def refused(self, expected, **parameters):
        with Driver(device='sonic_surface', **parameters) as driver:
            self.assertEqual(driver.process.wait(20), 1)
        lines = [line for line in driver.lines if line.strip()]
        self.assertEqual(len(lines), 1, driver.words())
        for words in expected:
            self.assertIn(words, lines[0])

    def test_wrong_options(self):
        self.refused(['no port', 'serial port'], port='')
        self.refused(['/dev/null', 'no terminal'], port='/dev/null')
        self.refused(['/nowhere', 'cannot be opened'], port='/nowhere')
        self.refused(['boards', "'3'", '1, 2'], port='/nowhere', device_options='boards=3')
        self.refused(['tactile', 'boards'], port='/nowhere', device_options='boards=2 firmware=tactile')
        self.refused(['hold', "'-1'"], port='/nowhere', device_options='hold=-1')
        self.refused(['board', 'secondary', 'one board'], port='/nowhere', device_options='boards=2 board=secondary')
        self.refused(['corrections', '/nowhere.csv'], port='/nowhere', device_options='corrections=/nowhere.csv')
        self.refused(['second_corrections', 'boards=2'], port='/nowhere',
                     device_options='second_corrections=/nowhere.csv')
        # One temperature, for the device and its gate.
        self.refused(['/array_driver/device_options', "parameter 'temperature' of the node"], port='/nowhere',
                     device_options='temperature=45')
        # The gate of a real array has no exceptions, and it is refused before its port is opened.
        self.refused(['gate_without', "'pressure'", "'sonic_surface' is real"], port='/nowhere',
                     gate_without=['pressure'])

    def test_port_in_use(self):
        emulator, _ = self.rig()
        done = subprocess.run([PROGRAM, '__name:=second', '_device:=sonic_surface', '_port:=' + emulator.link],
                              timeout=20,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False, errors='replace')
        self.assertEqual(done.returncode, 1)
        self.assertIn('in use', done.stdout)
        self.assertTrue(emulator.sounds() or emulator.since(time.monotonic() - 0.3), 'the first one goes on')


if __name__ == '__main__':
    rig_run.main('sonic_surface')
