#!/usr/bin/env python3
"""Scripted hands, and the tools around tracked hands: see hand_tools.test."""
import json
import math
import os
import subprocess
import sys
import tempfile
import time
import unittest

import yaml

import rig_run
from rig_messages import focal_points
from lost_hands_test import RATE, SERVER, leap_frame

TOOLS = os.path.join(rig_run.build_space(), 'devel', 'lib', 'tactile_clay')


def tool(name, *arguments):
    """Exit code, output and errors of a tool, which needs no master."""
    done = subprocess.run([os.path.join(TOOLS, name)] + list(arguments), stdin=subprocess.DEVNULL, timeout=100,
                          stdout=subprocess.PIPE, stderr=subprocess.PIPE, errors='replace', check=False)
    return done.returncode, done.stdout, done.stderr


class Folder(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix='hand_tools_')
        self.addCleanup(folder.cleanup)
        self.folder = folder.name

    def path(self, name):
        return os.path.join(self.folder, name)


class Choreography(Folder):
    def test_every_move_of_the_tour_is_felt(self):
        run = rig_run.Run(dict(rig_run.LOCKSTEP, hands='choreography', file='tour', quality='fast'))
        self.assertEqual((run.code, run.left), (0, []), run.words)
        stamps = run.messages.stamps('/hands/tracked')
        for topic in rig_run.CHAIN:
            self.assertEqual(run.messages.stamps(topic), stamps, topic)
        felt = [1e-9 * (stamp - stamps[0]) for stamp, points in sorted(focal_points(run).items()) if points]
        for move, start, end in (('pinch', 0.0, 6.0), ('press_finger', 6.0, 10.5), ('press_flat', 10.5, 15.0),
                                 ('roll', 15.0, 22.0), ('knead', 22.0, 31.0)):
            seconds = sum(start <= t < end for t in felt) / 60.0
            print('%s is felt for %.2f s' % (move, seconds))
            self.assertGreater(seconds, 0.5, move)
        self.assertGreater(len({hand.id for message in run.messages['/hands/tracked'] for hand in message.hands}), 4)

    def test_one_line_about_a_score_that_is_none(self):
        path = self.path('score.yaml')
        with open(path, 'w') as score:
            score.write('moves:\n  - {move: juggle}\n')
        code, _, errors = tool('preflight', 'hands:=choreography', 'file:=' + path)
        self.assertEqual(code, 1)
        self.assertEqual(len(errors.splitlines()), 1, errors)
        self.assertIn(path + ":2: unknown move 'juggle', expected one of knead", errors)


class RecordHands(Folder):
    def test_a_source_becomes_a_bag_with_its_story(self):
        out = self.path('hands.bag')
        code, words, errors = tool('record_hands', 'hands:=choreography', 'file:=kneading', 'out:=' + out,
                                   'duration:=4',
                                   'tracker_pose:=0.1 0.2 -0.3 0 0 1.5')
        self.assertEqual((code, errors), (0, ''), words)
        recorded = rig_run.Messages(out)
        self.assertEqual(len(recorded['/hands/tracked']), 440)
        self.assertEqual(recorded['/hands/tracked'][0].header.frame_id, 'world')
        story = yaml.safe_load(recorded['/hands/recording'][0].data)
        self.assertEqual((story['source'], story['file'], story['cleaned'], story['frames']),
                         ('choreography', 'kneading', True, 440))
        self.assertEqual(story['tracker_pose'], [0.1, 0.2, -0.3, 0.0, 0.0, 1.5])
        for side in ('left', 'right'):
            self.assertAlmostEqual(story['person_scale'][side], 1.05, delta=0.01)
        transform = recorded['/tf_static'][0].transforms[0]
        self.assertEqual((transform.header.frame_id, transform.child_frame_id), ('world', 'tracker'))
        self.assertAlmostEqual(transform.transform.translation.z, -0.3)
        self.assertAlmostEqual(transform.transform.rotation.z, math.sin(0.75))
        # The same score again is the same bag, and it plays.
        again = self.path('again.bag')
        tool('record_hands', 'hands:=choreography', 'file:=kneading', 'out:=' + again, 'duration:=4',
             'tracker_pose:=0.1 0.2 -0.3 0 0 1.5')
        self.assertEqual(rig_run.Messages(again).bytes, recorded.bytes)
        run = rig_run.Run(dict(rig_run.LOCKSTEP, hands='bag', file=out, quality='fast'))
        self.assertEqual((run.code, run.left), (0, []), run.words)
        self.assertEqual([data[4:] for data in run.messages.bytes['/hands/tracked']],
                         [data[4:] for data in recorded.bytes['/hands/tracked']])

    def test_a_live_tracker_is_recorded_by_its_own_clock(self):
        path = self.path('frames.ndjson')
        hand = rig_run.Messages(rig_run.bag('press_finger'))['/hands/tracked'][0].hands[0]
        with open(path, 'w') as frames:
            frames.writelines(json.dumps(leap_frame(number, hand, 1)) + '\n' for number in range(200))
        server = subprocess.Popen([sys.executable, SERVER, path, '--rate', str(RATE)], stdout=subprocess.PIPE,
                                  stdin=subprocess.DEVNULL, universal_newlines=True)
        self.addCleanup(server.wait)
        self.addCleanup(server.kill)
        self.addCleanup(server.stdout.close)
        url = 'ws://127.0.0.1:%d' % json.loads(server.stdout.readline())['port']
        out = self.path('live.bag')
        start = time.time()
        code, words, errors = tool('record_hands', 'hands:=leap_websocket', 'url:=' + url, 'out:=' + out, 'duration:=2')
        self.assertEqual(code, 0, words + errors)
        recorded = rig_run.Messages(out)
        stamps = [1e-9 * stamp for stamp in recorded.stamps('/hands/tracked')]
        self.assertTrue(start < stamps[0] < stamps[-1] < time.time())
        self.assertAlmostEqual(stamps[-1] - stamps[0], 2.0, delta=0.1)
        # Each is a whole number of the device's frames after the first one, whatever the network did: the offset of the
        # clocks settles with the first samples.
        frames = [(stamp - stamps[-1]) * RATE for stamp in stamps[30:]]
        self.assertLess(max(abs(frame - round(frame)) for frame in frames), 0.12, '2 ms')
        self.assertEqual(yaml.safe_load(recorded['/hands/recording'][0].data)['url'], url)

    def test_bad_input_is_told_in_one_line(self):
        out = 'out:=' + self.path('hands.bag')
        for arguments, words in ((['hands:=choreography'], 'out:='), ([out, 'hands:=telepathy'], 'leap_websocket'),
                                 ([out, 'hands:=choreography', 'file:=nowhere'], 'nowhere'),
                                 ([out, 'tracker_pose:=1 2'], 'tracker_pose'), ([out, 'duration:=long'], 'duration'),
                                 ([out, 'secret:=1'], 'secret'), ([out, 'clean:=maybe'], 'clean'),
                                 ([out, 'url:=http://x'], 'ws://HOST')):
            with self.subTest(arguments):
                code, _, errors = tool('record_hands', *arguments)
                self.assertEqual(code, 1)
                self.assertEqual(len(errors.splitlines()), 1, errors)
                self.assertIn(words, errors)


class CalibrateTracker(Folder):
    MARKS = [(0.1, 0.08, 0.0), (0.1, -0.08, 0.0), (-0.06, 0.02, 0.0)]
    # Of the tracker in world: shifted, and turned about z.
    POSE = (0.03, -0.02, -0.12, 0.0, 0.0, 0.2)

    def touches(self, marks):
        """A recording of a finger that comes down on the marks, one after the other, as the tracker of POSE sees it."""
        hand = rig_run.Messages(rig_run.bag('press_finger'))['/hands/tracked'][0].hands[0]
        home = [(joint.position.x, joint.position.y, joint.position.z) for joint in hand.joints]
        tip, radius = home[10], hand.radii[10]
        lines, number = [], 0
        where = (0.0, 0.0, 0.15)
        for mark in marks:
            goal = (mark[0], mark[1], mark[2] + radius)
            above = (goal[0], goal[1], 0.15)
            for target, steps, rest in ((above, 40, 0), (goal, 30, 60), (above, 30, 0)):
                start = where
                for step in range(1, steps + rest + 1):
                    share = min(1.0, step / steps)
                    where = tuple(a + share * (b - a) for a, b in zip(start, target))
                    for joint, at in zip(hand.joints, home):
                        world = [a - b + c for a, b, c in zip(at, tip, where)]
                        x, y, z = (a - b for a, b in zip(world, self.POSE))
                        c, s = math.cos(self.POSE[5]), math.sin(self.POSE[5])
                        joint.position.x, joint.position.y, joint.position.z = c * x + s * y, -s * x + c * y, z
                    lines.append(json.dumps(leap_frame(number, hand, 1)))
                    number += 1
        path = self.path('touches.ndjson')
        with open(path, 'w') as out:
            out.write('\n'.join(lines) + '\n')
        return path

    def calibrate(self, recording, *arguments):
        points = ', '.join('%g %g %g' % mark for mark in self.MARKS)
        return tool('calibrate_tracker', 'points:=' + points, 'hands:=leap_recording', 'file:=' + recording, *arguments)

    def test_finds_the_pose_and_writes_it_into_the_rig(self):
        out = self.path('rig.yaml')
        with open(os.path.join(rig_run.PACKAGE, 'config', 'rig.yaml')) as rig:
            before = rig.read()
        with open(out, 'w') as rig:
            rig.write(before)
        code, words, errors = self.calibrate(self.touches(self.MARKS), 'out:=' + out)
        self.assertEqual((code, errors), (0, ''), words)
        with open(out) as rig:
            after = rig.read()
        found = yaml.safe_load(after)
        # The person's fingertip is as thick as the anatomy says at the scale that is seen.
        for a, b in zip(found['tracker_pose'], self.POSE):
            self.assertAlmostEqual(a, b, delta=0.001)
        changed = [(a, b) for a, b in zip(before.splitlines(), after.splitlines()) if a != b]
        self.assertEqual(len(changed), 1)
        self.assertRegex(changed[0][1], r'^tracker_pose: \[')
        self.assertEqual(len(before.splitlines()), len(after.splitlines()))
        self.assertRegex(words, r'0\.\d mm rms')

    def test_points_in_another_order_are_not_taken(self):
        out = self.path('rig.yaml')
        code, _, errors = self.calibrate(self.touches([self.MARKS[1], self.MARKS[0], self.MARKS[2]]), 'out:=' + out)
        self.assertEqual(code, 1)
        self.assertEqual(len(errors.splitlines()), 1, errors)
        self.assertIn('were the points touched in this order?', errors)
        self.assertFalse(os.path.exists(out))

    def test_a_touch_is_missing(self):
        code, _, errors = self.calibrate(self.touches(self.MARKS[:2]))
        self.assertEqual(code, 1)
        self.assertIn('only 2 of 3 points were touched', errors)

    def test_bad_points_are_told_in_one_line(self):
        for points, words in (('', '3 at least'), ('0 0 0, 1 0 0', '3 at least'),
                              ('0 0 0, 1 0 0, 2 0 0', 'on one line'),
                              ('0 0 0, 1 0, 0 1 0', 'expected "x y z'), ('0 0 0, 1 0 0, nan 1 0', 'expected "x y z')):
            with self.subTest(points):
                code, _, errors = tool('calibrate_tracker', 'points:=' + points, 'hands:=none')
                self.assertEqual(code, 1)
                self.assertEqual(len(errors.splitlines()), 1, errors)
                self.assertIn(words, errors)


if __name__ == '__main__':
    rig_run.main('hand_tools')
