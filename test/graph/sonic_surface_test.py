#!/usr/bin/env python3
"""The SonicSurface device on a pseudo-terminal: see sonic_surface.test."""
import math
import os
import random
import re
import signal
import statistics
import subprocess
import sys
import tempfile
import time
import unittest

import rospy
from tactile_clay.msg import ArrayDrive

import rig_run
from array_stream import PROGRAM, PROGRAMS, Driver, States, Stream, focus
from rig_run import wait_until

sys.path.insert(0, os.path.join(rig_run.PACKAGE, 'test', 'emulator'))
import acoustic_field  # noqa: E402  pylint: disable=wrong-import-position
import sonic_surface  # noqa: E402  pylint: disable=wrong-import-position
from modulation_test import FIELD, patch  # noqa: E402  pylint: disable=wrong-import-position
from sonic_surface import OFF, STOCK, TACTILE, Emulator

FRAME = 258 * 10 / 230400.0  # s, of a frame on the wire
# Clocks off, two silent frames for the board, two for one that was deselected, clocks on, the board selected.
SILENCE = (b'\x96' + b''.join(2 * (board + b'\xfe' + bytes([32] * 256) + b'\xfd') for board in (b'\xc0', b'\xc1')) +
           b'\x97\xc0')
LOUD = dict(pressure_cap=1e6, head_spl_cap=200.0)  # caps that nothing reaches: every channel plays
CALIBRATE = os.path.join(rig_run.build_space(), 'devel', 'lib', 'tactile_clay', 'calibrate_board')
SLACK = 0.25  # s, that a busy machine may take longer


def phases(x, y, z, levels=32):
    """Phase level of each channel that focuses there, not rounded: sound must set off earlier where it has farther to
    go."""
    wavelength = 331.3 * math.sqrt(1 + 20.0 / 273.15) / 40000.0
    return [-math.dist((x, y, z), (cx, cy, 0.0)) / wavelength * levels % levels for cx, cy in sonic_surface.places()]


class SonicSurface(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rospy.init_node('sonic_surface_test')
        cls.folder = tempfile.mkdtemp(prefix='sonic_surface_')
        cls.stream, cls.states = Stream(), States()
        cls.addClassCleanup(cls.stream.stop)

    def setUp(self):
        self.stream.reset()

    def rig(self, boards=1, firmware=STOCK, options='', sounding=True, **parameters):
        """An emulator and a driver that plays on it; both end with the test."""
        emulator = Emulator(os.path.join(self.folder, self._testMethodName), boards, firmware)
        self.enterContext(emulator)
        driver = self.drive(emulator, 'boards=%d firmware=%s %s' % (boards, firmware, options), **parameters)
        if sounding:
            wait_until(emulator.sounds, 20, 'a sound; the driver says\n' + driver.words())
        return emulator, driver

    def drive(self, emulator, options='', **parameters):
        driver = Driver(device='sonic_surface', port=emulator.link, device_options=options, **dict(LOUD, **parameters))
        return self.enterContext(driver)

    def enterContext(self, manager):  # of unittest since Python 3.11
        entered = manager.__enter__()
        self.addCleanup(manager.__exit__, None, None, None)
        return entered

    def expect_silence(self, emulator, since, limit):
        wait_until(emulator.silent_for_good, 10, 'silence of both buffers')
        last = emulator.last_sound()
        print('silent %.0f ms after, expected %.0f' % (1e3 * (last - since), 1e3 * limit))
        self.assertLess(last - since, limit)
        self.assertEqual(emulator.faults(), 0)
        # It stays so.
        count = len(emulator.since(since))
        time.sleep(0.3)
        self.assertTrue(emulator.silent_for_good())
        self.assertFalse(any(swap.sounds for swap in emulator.since(since)[count:]))

    def expect_phases(self, front, board, expected, levels=32, step=1):
        for channel, (value, level) in enumerate(zip(front[board], expected)):
            nearest = round(level) % levels
            tie = abs(level % 1 - 0.5) < 0.01
            self.assertTrue(value == step * nearest or tie and value != OFF,
                            'channel %d: %d, expected %.3f' % (channel, value, step * level))

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

    def field(self, emulator, point):
        """Pa at a point, of the last pattern that sounds."""
        board = emulator.boards[0]
        with emulator.lock:
            before, board.front = board.front, next(list(s.fronts[0]) for s in reversed(emulator.swaps) if s.sounds)
            phases, board.front = board.drive(), before
        return acoustic_field.pressure([(x, y, p) for (x, y),
                                        p in zip(sonic_surface.places(), phases) if p is not None], point)

    def test_transducers_the_other_way_round(self):
        """A third of them flipped: a calibration by a microphone finds them, and its file gives the whole field."""
        point, microphone, dice = (0.02, -0.01, 0.17), (0.01, 0.02, 0.25), random.Random(3)
        flipped = set(dice.sample(range(256), 85))
        readings, corrections = (os.path.join(self.folder, name) for name in ('readings.csv', 'corrections.csv'))
        reference = 36
        with open(readings, 'w') as file:
            file.write('channel,reference,level,amplitude\n')
            for channel in set(range(256)) - {reference}:
                for level in (0, 8, 16, 24):
                    pair = [places + (phase + math.pi * (n in flipped),)
                            for n, phase in ((reference, 0.0), (channel, level * math.pi / 16))
                            for places in [sonic_surface.places()[n]]]
                    file.write('%d,%d,%d,%.5f\n' % (channel, reference, level,
                                                   acoustic_field.pressure(pair, microphone) * dice.uniform(0.97,
                                                                                                            1.03)))
        words = subprocess.run([CALIBRATE, 'compute', readings, corrections, '--microphone', *map(str, microphone)],
                               check=True,
                               stdout=subprocess.PIPE, universal_newlines=True).stdout
        self.assertIn('%d have the opposite polarity' % (85 if reference not in flipped else 256 - 85), words)
        self.stream.points = [focus(*point, intensity=1.0)]
        found = {}
        for name, of, options in (('right', set(), ''), ('flipped', flipped, ''),
                                  ('corrected', flipped, 'corrections=' + corrections)):
            emulator = self.enterContext(Emulator(os.path.join(self.folder, name)))
            emulator.boards[0].flipped = of
            driver = self.drive(emulator, options)
            wait_until(lambda: sum(OFF not in swap.fronts[0] for swap in emulator.since(0)) > 20, 20,
                       'the whole board\n' + driver.words())
            found[name] = self.field(emulator, point)
            driver.__exit__()
            emulator.__exit__()
        print('right %(right).0f Pa, a third flipped %(flipped).0f, corrected %(corrected).0f' % found)
        self.assertLess(found['flipped'], 0.5 * found['right'])
        self.assertGreater(found['corrected'], 0.98 * found['right'])

    def test_calibration_plays_pairs(self):
        """Two channels at a time, in four phases, and silence in the end."""
        with Emulator(os.path.join(self.folder, 'calibrated')) as emulator:
            table = os.path.join(self.folder, 'played.csv')
            tool = subprocess.Popen([CALIBRATE, 'play', table, '--port', emulator.link, '--channels', '7', '200'],
                                    stdin=subprocess.PIPE,
                                    stdout=subprocess.PIPE, universal_newlines=True)
            heard = []
            for _ in range(8):
                words = ''
                while not words.endswith('? '):
                    heard_now = tool.stdout.read(1)
                    self.assertTrue(heard_now, 'calibrate_board ended after: ' + words)
                    words += heard_now
                heard.append({n: v for n, v in enumerate(emulator.boards[0].front) if v != OFF})
                tool.stdin.write('%d\n' % len(heard))
                tool.stdin.flush()
            self.assertEqual(tool.wait(10), 0)
            tool.stdin.close()
            tool.stdout.close()
            self.assertEqual(heard, [{36: 0, channel: level} for channel in (7, 200) for level in (0, 8, 16, 24)])
            wait_until(emulator.silent_for_good, 10, 'silence')
        with open(table) as file:
            self.assertEqual(file.read().split()[1], '7,36,0,1.0')

    def bench(self, emulator, *words):
        """What `array_test` says, without a master, line by line; and the patterns that the boards played."""
        since = time.monotonic()
        done = subprocess.run([os.path.join(PROGRAMS, 'array_test'), 'device:=sonic_surface', 'port:=' + emulator.link,
                               *words],
                              env=dict(os.environ, ROS_MASTER_URI='http://localhost:1'), timeout=60,
                              stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, check=False, universal_newlines=True)
        self.assertEqual(done.returncode, 0, done.stdout)
        wait_until(emulator.silent_for_good, 10, 'silence in the end')
        return done.stdout.splitlines(), [swap.fronts[0] for swap in emulator.since(since) if swap.sounds]

    def expect_reading(self, front, line, microphone):
        playing = [(x, y, 2 * math.pi * value / 32) for (x, y),
                   value in zip(sonic_surface.places(), front) if value != OFF]
        told = float(re.search(r'should read ([0-9.]+) Pa', line).group(1))
        self.assertAlmostEqual(told / acoustic_field.pressure(playing, microphone), 1, delta=0.02)

    def test_bench(self):
        """Without a graph: one channel alone, a focus, a sweep, and what a microphone should read of each."""
        emulator = self.enterContext(Emulator(os.path.join(self.folder, 'bench')))
        quiet = ('modulation_frequency:=0', 'head_spl_cap:=200', 'pressure_cap:=1000000')
        for channel in (7, 200):
            lines, fronts = self.bench(emulator, 'test:=channels', 'channel:=%d' % channel, 'dwell:=0.3', *quiet)
            self.assertEqual({tuple(n for n, value in enumerate(front) if value != OFF) for front in fronts},
                             {(channel,)})
            self.assertIn('channel %d ' % channel, lines[-1])
            self.expect_reading(fronts[-1], lines[-1], (0.0, 0.0, 0.2))
        lines, fronts = self.bench(emulator, 'test:=focus', 'microphone:=0.01 0.02 0.18', 'dwell:=0.05', *quiet)
        self.expect_reading(fronts[-1], lines[-1], (0.01, 0.02, 0.18))
        self.expect_phases([fronts[-1]], 0, phases(0.01, 0.02, 0.18))
        lines, fronts = self.bench(emulator, 'test:=sweep', 'dwell:=0.2', *quiet)
        self.assertEqual(len([line for line in lines if line.startswith('focus at')]), 17)
        self.expect_phases([fronts[-1]], 0, phases(0.04, 0.0, 0.2))
        self.expect_reading(fronts[-1], lines[-1], (0.0, 0.0, 0.2))
        # The safety gate has the last word.
        lines, _ = self.bench(emulator, 'test:=focus', 'dwell:=0.05', 'pressure_cap:=500', 'head_spl_cap:=200')
        self.assertIn('made weaker by pressure', lines[-1])
        self.assertEqual(emulator.faults(), 0)

    # How it becomes silent.

    def test_points_that_end(self):
        emulator, _ = self.rig()
        self.stream.points = []
        self.expect_silence(emulator, time.monotonic(), 0.1 + SLACK)

    def test_stream_that_ends(self):
        """Stale after 100 ms; the gate's rule, and the device's own hold behind it."""
        for options, timeout, limit in (('', 0.1, 0.1), ('', 10.0, 0.2), ('hold=10', 0.1, 0.1)):
            with self.subTest(options=options, stale_timeout=timeout):
                emulator, driver = self.rig(options=options, stale_timeout=timeout)
                self.stream.stop()
                self.expect_silence(emulator, self.stream.last_sent, limit + SLACK)
                driver.__exit__()
                emulator.__exit__()
                self.renew_stream()

    def renew_stream(self):
        type(self).stream = self.stream = Stream()

    def test_stream_that_ends_without_limits_sounds_on(self):
        emulator, _ = self.rig(options='hold=10', stale_timeout=10.0)
        self.stream.stop()
        self.addCleanup(self.renew_stream)
        time.sleep(1.0)
        self.assertTrue(any(swap.sounds for swap in emulator.since(time.monotonic() - 0.3)))

    def test_ends(self):
        for name in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            with self.subTest(name):
                emulator, driver = self.rig()
                since = time.monotonic()
                driver.process.send_signal(name)
                self.expect_silence(emulator, since, 0.5 + SLACK)
                self.assertEqual(driver.process.wait(5), 0)
                emulator.__exit__()

    def test_killed(self):
        """kill -9 of the driver and of its process group: the guard process silences the boards."""
        for kill in (os.kill, os.killpg):
            with self.subTest(kill.__name__):
                self.stream.modulation_frequency = 0.0  # sounds without a pause
                emulator, driver = self.rig()
                since = time.monotonic()
                kill(driver.process.pid, signal.SIGKILL)
                self.expect_silence(emulator, since, 2 * FRAME + SLACK)
                emulator.__exit__()

    def test_killed_without_guard_sounds_on(self):
        emulator, driver = self.rig(options='guard=false')
        self.stream.modulation_frequency = 0.0
        time.sleep(0.3)
        driver.process.kill()
        driver.process.wait()
        time.sleep(0.5)
        self.assertTrue(emulator.sounds(), 'closing the port alone silences nothing')

    def test_hangs(self):
        """A driver that is stopped: the guard silences the boards; when it goes on, so does the sound."""
        self.stream.modulation_frequency = 0.0  # sounds without a pause
        emulator, driver = self.rig()
        since = time.monotonic()
        driver.process.send_signal(signal.SIGSTOP)
        self.expect_silence(emulator, since, 0.25 + SLACK)
        driver.process.send_signal(signal.SIGCONT)
        wait_until(emulator.sounds, 10, 'a sound')

    def guard(self, driver):
        """Number of the guard process of a driver."""
        found = subprocess.run(['ps', '-o', 'pid=,comm=', '--ppid', str(driver.process.pid)], stdout=subprocess.PIPE,
                               check=True,
                               universal_newlines=True).stdout.split()
        self.assertEqual(found[1::2], ['silence_guard'])
        return int(found[0])

    def test_guard_that_is_killed(self):
        """The driver silences the boards itself, says so, and stays silent: nobody would silence them if it died
        too."""
        self.stream.modulation_frequency = 0.0  # sounds without a pause
        emulator, driver = self.rig()
        since = time.monotonic()
        os.kill(self.guard(driver), signal.SIGKILL)
        self.expect_silence(emulator, since, 0.25 + SLACK)
        _, state = self.states.wait(lambda state: not state.emitting)
        self.assertIn('the guard process is gone', state.silent_reason)
        time.sleep(0.5)
        self.assertTrue(emulator.silent_for_good())

    def test_guard_that_is_frozen(self):
        """Silent until the guard answers again."""
        self.stream.modulation_frequency = 0.0
        emulator, driver = self.rig()
        guard = self.guard(driver)
        since = time.monotonic()
        os.kill(guard, signal.SIGSTOP)
        self.expect_silence(emulator, since, 0.25 + SLACK)
        _, state = self.states.wait(lambda state: not state.emitting)
        self.assertIn('the guard process does not answer', state.silent_reason)
        os.kill(guard, signal.SIGCONT)
        wait_until(emulator.sounds, 10, 'a sound')
        # And a driver that ends is not held up by a guard that is frozen.
        os.kill(guard, signal.SIGSTOP)
        driver.process.send_signal(signal.SIGINT)
        self.assertEqual(driver.process.wait(5), 0)
        self.assertTrue(emulator.silent_for_good())

    def test_unplugged_and_plugged_in(self):
        emulator, driver = self.rig()
        since = time.monotonic()
        emulator.unplug()
        _, state = self.states.wait(lambda state: not state.emitting, since)
        _, state = self.states.wait(lambda state: 'gone' in state.silent_reason, since)
        self.assertIn(emulator.link, state.silent_reason)
        time.sleep(1.5)
        emulator.power_cycle()
        again = time.monotonic()
        emulator.received.clear()
        emulator.plug()
        self.states.wait(lambda state: state.emitting, again)
        wait_until(emulator.sounds, 10, 'a sound after plugging in')
        self.assertEqual(bytes(emulator.received[:len(SILENCE)]), SILENCE)
        self.assertEqual(emulator.faults(), 0)
        told = [line for line in driver.lines if emulator.link in line]
        self.assertEqual(len(told), 1, ''.join(driver.lines))
        self.assertIn('is gone', told[0])

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
        self.refused(['device_options', 'temperature', '/array_driver/temperature'], port='/nowhere',
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
