"""Cases of sonic_surface_test.py about single channels: calibration, and the bench. A module, no program."""
import math
import os
import random
import re
import subprocess
import sys
import time

import rig_run
from array_stream import PROGRAMS, focus
from rig_run import wait_until
from sonic_surface_boards import Boards, phases

sys.path.insert(0, os.path.join(rig_run.PACKAGE, 'test', 'emulator'))
import acoustic_field  # noqa: E402  pylint: disable=wrong-import-position
import sonic_surface  # noqa: E402  pylint: disable=wrong-import-position
from sonic_surface import OFF, Emulator

CALIBRATE = os.path.join(rig_run.build_space(), 'devel', 'lib', 'tactile_clay', 'calibrate_board')


class Calibration(Boards):
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
