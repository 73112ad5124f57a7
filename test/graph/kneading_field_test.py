#!/usr/bin/env python3
"""From kneading hands to the field of the boards: see kneading_field.test."""
import math
import os
import signal
import statistics
import sys
import time
import unittest

import rosbag

import rig_run
from rig_run import wait_until

sys.path.insert(0, os.path.join(rig_run.PACKAGE, 'test', 'emulator'))
import acoustic_field  # noqa: E402  pylint: disable=wrong-import-position
import sonic_surface  # noqa: E402  pylint: disable=wrong-import-position

UPLOAD = 258 * 10 / 230400.0  # s, of a frame on the wire
TOLERANCE = 0.002             # m, from a focal point to its peak
UPSTREAM = ['hand_tracking', 'hand_simulator', 'clay_simulator', 'contact_pressure', 'focal_point_renderer']


def patterns(emulator):
    """(time at which it was uploaded, sources) of each pattern that played."""
    found, last = [], None
    for swap in emulator.since(0):
        front = swap.fronts[0]
        if not swap.sounds or front == last:
            continue
        last = front
        sources = [(x, y, 2.0 * math.pi * value / 32) for (x, y), value in zip(sonic_surface.places(), front)
                   if value != sonic_surface.OFF]
        found.append((swap.when - UPLOAD, sources))
    return found


class KneadingField(unittest.TestCase):
    def test_peaks_lie_at_the_focal_points(self):
        with rig_run.Graph() as graph, sonic_surface.Emulator(os.path.join(graph.folder, 'port')) as emulator:
            recording = graph.record(['/array/focal_points', '/array/state'])
            clock = time.time() - time.monotonic()
            # Slower than recorded: at most one frame comes while another is uploaded.
            rig = graph.rig(dict(hands='bag', file=rig_run.bag('knead'), device='sonic_surface', lockstep='true', head_spl_cap='200',
                                 port=emulator.link, quality='fast'))
            self.assertEqual(rig.wait(120), 0, graph.words())
            graph.recorded(recording)
            with rosbag.Bag(recording[1]) as bag:
                frames = [(t.to_sec() - clock, message.points)
                          for _, message, t in bag.read_messages(topics=['/array/focal_points'])]
            wait_until(emulator.silent_for_good, 5, 'silence in the end')
        self.assertEqual(emulator.faults(), 0)
        played = patterns(emulator)
        self.assertGreater(len(played), 20, 'patterns')
        import pickle; pickle.dump(([(c, [(q.position.x, q.position.y, q.position.z, q.intensity) for q in p]) for c, p in frames], played), open('/tmp/e2e.pickle', 'wb'))
        distances = []
        for when, sources in played:
            # The newest frame before the upload; one that came within 8 ms of it may have been too late, or just in time.
            before = [points for came, points in frames if came <= when]
            close = [points for came, points in frames if abs(came - when) < 0.008]
            best = None
            for points in before[-1:] + close:
                found = [math.dist(acoustic_field.peak(sources, (p.position.x, p.position.y, p.position.z))[0],
                                   (p.position.x, p.position.y, p.position.z)) for p in points]
                if found and (best is None or max(found) < max(best)):
                    best = found
            self.assertIsNotNone(best, 'a pattern that nobody asked for')
            distances += best
        print('%d patterns, %d focal points, distance of the peak: median %.2f mm, 99 %% %.2f mm, longest %.2f mm' %
              (len(played), len(distances), 1e3 * statistics.median(distances),
               1e3 * sorted(distances)[int(0.99 * (len(distances) - 1))], 1e3 * max(distances)))
        self.assertLess(max(distances), TOLERANCE)


if __name__ == '__main__':
    rig_run.main('kneading_field')
