#!/usr/bin/env python3
"""The rig with device:=debug: see debug_device.test."""
import unittest

import rig_run
from rig_messages import focal_points
from rig_run import lockstep


class DebugDevice(unittest.TestCase):
    def test_same_focal_points_and_they_are_emitted(self):
        simulated, debug = lockstep('press_finger'), lockstep('press_finger', device='debug')
        self.assertEqual((debug.code, debug.left), (0, []), debug.words)
        self.assertEqual(*([data[4:] for data in run.messages.bytes['/array/focal_points']]
                           for run in (simulated, debug)))
        # A real array may go silent between two frames, when they come too slowly: the first answer counts.
        first = {}
        for state in debug.messages['/array/state']:
            first.setdefault(state.header.stamp.to_nsec(), state)
        points = focal_points(debug)
        self.assertEqual(sorted(first), rig_run.input_stamps('press_finger'))
        self.assertTrue(any(points.values()))
        for stamp, state in first.items():
            self.assertEqual((state.device, state.emitting), ('debug', bool(points[stamp])))
        self.assertIn('debug array: open', debug.words)


if __name__ == '__main__':
    rig_run.main('debug_device')
