#!/usr/bin/env python3
"""Recorded hands through the whole graph: see recordings.test."""
import gzip
import json
import math
import unittest

import rig_run


def frames_of(path):
    """Number of frames in a recording; other lines are the tracker's events."""
    with gzip.open(path, 'rt') as lines:
        return sum('timestamp' in json.loads(line) for line in lines if line.strip())


class Recordings(unittest.TestCase):
    def play(self, name):
        path = rig_run.recording(name)
        run = rig_run.Run(dict(rig_run.LOCKSTEP, hands='leap_recording', file=path, quality='fast'))
        self.assertEqual((run.code, run.left), (0, []), run.words)
        self.assertNotIn('Traceback', run.words)
        stamps = run.messages.stamps('/hands/tracked')
        self.assertEqual(len(stamps), frames_of(path))
        self.assertEqual(stamps, sorted(set(stamps)))
        for topic in rig_run.CHAIN:
            self.assertEqual(run.messages.stamps(topic), stamps, topic)
        self.assertGreater(max(len(message.hands) for message in run.messages['/hands/tracked']), 0)
        for message in run.messages['/array/focal_points']:
            for point in message.points:
                p = point.position
                self.assertTrue(all(map(math.isfinite, (p.x, p.y, p.z, point.pressure, point.intensity))), point)
        for state in run.messages['/array/state']:
            self.assertNotIn('non-finite', state.silent_reason)
        touching = sum(bool(message.points) for message in run.messages['/array/focal_points'])
        print('%s: %d frames, %d touching' % (name, len(stamps), touching))
        return touching


def case(name):
    return lambda self: self.play(name)


for recording in rig_run.RECORDINGS:
    setattr(Recordings, 'test_' + recording, case(recording))

if __name__ == '__main__':
    rig_run.main('recordings')
