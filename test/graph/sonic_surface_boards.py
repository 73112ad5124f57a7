"""Emulated SonicSurface boards and the driver that plays on them, for the tests of that device. A module of tests."""
import math
import os
import sys
import tempfile
import time
import unittest

import rospy

import rig_run
from array_stream import Driver, States, Stream
from rig_run import wait_until

sys.path.insert(0, os.path.join(rig_run.PACKAGE, 'test', 'emulator'))
import sonic_surface  # noqa: E402  pylint: disable=wrong-import-position
from sonic_surface import OFF, STOCK, Emulator

FRAME = 258 * 10 / 230400.0  # s, of a frame on the wire
# Clocks off, two silent frames for the board, two for one that was deselected, clocks on, the board selected.
SILENCE = (b'\x96' + b''.join(2 * (board + b'\xfe' + bytes([32] * 256) + b'\xfd') for board in (b'\xc0', b'\xc1')) +
           b'\x97\xc0')
LOUD = dict(pressure_cap=1e6, head_spl_cap=200.0)  # caps that nothing reaches: every channel plays
SLACK = 0.25  # s, that a busy machine may take longer


def phases(x, y, z, levels=32):
    """Phase level of each channel that focuses there, not rounded: sound must set off earlier where it has farther to
    go."""
    wavelength = 331.3 * math.sqrt(1 + 20.0 / 273.15) / 40000.0
    return [-math.dist((x, y, z), (cx, cy, 0.0)) / wavelength * levels % levels for cx, cy in sonic_surface.places()]


class Boards(unittest.TestCase):
    """Cases with emulated boards. Focal points come from `stream`, words of the array are in `states`."""

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

    def renew_stream(self):
        type(self).stream = self.stream = Stream()
