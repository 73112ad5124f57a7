#!/usr/bin/env python3
"""What a pressing finger makes of the whole graph: see press.test."""
import struct
import unittest

import rig_run
from rig_messages import array_to_world, distance, focal_points, lowest_skin, pressing
from rig_run import lockstep

INDEX = range(6, 11)  # joints of the index finger
TOP = 0.04            # m, of the red block
# The clay reaches half a particle spacing over the block's nominal top at most, and sinks a little under its weight.
TOUCHING, APART = TOP - 0.002, TOP + 0.005


def hands(run):
    return {stamp: message.hands[0] for stamp, message in run.messages.by_stamp('/hands/tracked').items()}


class Press(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.shallow = lockstep('press_finger')
        cls.deeper = lockstep('press_deeper')

    def test_ends_by_itself_with_code_0(self):
        for run in (self.shallow, self.deeper):
            self.assertEqual(run.code, 0, run.words)
            self.assertEqual(run.left, [])

    def test_silent_before_touch_and_after_leaving(self):
        points = focal_points(self.shallow)
        apart = [stamp for stamp, hand in hands(self.shallow).items() if lowest_skin(hand) > APART]
        self.assertGreater(len(apart), 60)
        for stamp in apart:
            self.assertEqual(points[stamp], [], 'at %d ns' % stamp)

    def test_focal_points_lie_on_the_touching_finger(self):
        points, to_world = focal_points(self.shallow), array_to_world(self.shallow)
        seen = hands(self.shallow)
        touching = pressing({stamp: lowest_skin(hand) for stamp, hand in seen.items()}, TOUCHING)
        self.assertGreater(len(touching), 30)
        for stamp in touching:
            hand = seen[stamp]
            self.assertTrue(points[stamp], 'silent at %d ns while the finger is %.1f mm deep' %
                            (stamp, 1e3 * (TOP - lowest_skin(hand))))
            for point in points[stamp]:
                at = to_world(point.position)
                joints = [hand.joints[joint].position for joint in INDEX]
                nearest = min(distance(at, (p.x, p.y, p.z)) for p in joints)
                self.assertLess(nearest, 0.015, 'a focal point beside the finger, at %s' % (at,))

    def test_deeper_is_stronger(self):
        peak = {}
        for run in (self.shallow, self.deeper):
            pressures = [point.pressure for points in focal_points(run).values() for point in points]
            self.assertTrue(all(pressure > 0 for pressure in pressures))
            peak[run] = max(pressures)
        self.assertGreater(peak[self.deeper], 1.1 * peak[self.shallow])

    def test_each_sample_is_answered_once_with_its_stamp(self):
        for name, run in (('press_finger', self.shallow), ('press_deeper', self.deeper)):
            stamps = rig_run.input_stamps(name)
            self.assertEqual(len(stamps), len(set(stamps)))
            for topic in rig_run.CHAIN:
                self.assertEqual(run.messages.stamps(topic), stamps, '%s of %s' % (topic, name))

    def test_pressure_cloud(self):
        pressed = 0
        for message in self.shallow.messages['/hands/pressure']:
            self.assertEqual(message.header.frame_id, 'array')
            fields = {field.name: field for field in message.fields}
            for name in ('x', 'y', 'z', 'normal_x', 'normal_y', 'normal_z', 'pressure', 'weight'):
                self.assertEqual((fields[name].datatype, fields[name].count), (7, 1), name)  # float32
            self.assertEqual(len(message.data), message.width * message.height * message.point_step)
            for i in range(message.width):
                row = {name: struct.unpack_from('<f', message.data, i * message.point_step + field.offset)[0]
                       for name, field in fields.items()}
                self.assertGreater(row['pressure'], 0)
                self.assertTrue(0 <= row['weight'] <= 1, row)
                # The sample faces the array, the origin of the frame.
                self.assertLess(sum(row[a] * row['normal_' + a] for a in 'xyz'), 0)
                pressed += 1
        self.assertGreater(pressed, 100)

    def test_points_keep_their_ids_in_a_steady_press(self):
        deepest = min(lowest_skin(hand) for hand in hands(self.deeper).values())
        steady = [stamp for stamp, hand in sorted(hands(self.deeper).items()) if lowest_skin(hand) < deepest + 1e-5]
        self.assertGreater(len(steady), 20)
        points = focal_points(self.deeper)
        ids = [{point.id for point in points[stamp]} for stamp in steady]
        self.assertTrue(ids[0])
        self.assertLessEqual(len(set().union(*ids) - ids[0]), 2)
        for now in points.values():
            self.assertLessEqual(len(now), 8)
            self.assertEqual(len({point.id for point in now}), len(now))

    def test_state_tells_what_the_array_does(self):
        points = focal_points(self.shallow)
        for stamp, state in self.shallow.messages.by_stamp('/array/state').items():
            self.assertEqual(state.emitting, bool(points[stamp]))
            self.assertEqual(state.silent_reason == '', state.emitting)
            self.assertEqual((state.frames_rejected, state.frames_late), (0, 0))


if __name__ == '__main__':
    rig_run.main('press')
