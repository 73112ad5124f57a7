#!/usr/bin/env python3
"""The rig with soft hands: see soft_hand.test."""
import collections
import unittest

import rig_run
from rig_messages import array_to_world, columns, distance, focal_points, lowest_skin

Point = collections.namedtuple('Point', 'x y z')

TOP = 0.04  # m, of the red block
APART = TOP + 0.005
RECOIL = 150e6  # ns
INDEX_TIP = 10  # in the order of OpenXR
TIP_POINT, JOINTS = INDEX_TIP - 1, 25  # hands/bones has no palm joint


def press(**arguments):
    return rig_run.Run(dict(rig_run.LOCKSTEP, modulation='am', hands='bag', file=rig_run.bag('press_deeper'),
                            quality='fast',
                            **arguments), topics=rig_run.CHAIN + ['/hands/bones', '/diagnostics', '/tf_static'])


def xyz(point):
    return point.x, point.y, point.z


def lowest_sample(cloud):
    """Height of the lowest sample of the skin over the table, m."""
    return min(z for z, in columns(cloud, 'z'))


class SoftHand(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.soft = press(hand_model='soft', threads='1')

    def test_each_sample_is_answered_and_the_rig_ends(self):
        self.assertEqual((self.soft.code, self.soft.left), (0, []), self.soft.words)
        stamps = rig_run.input_stamps('press_deeper')
        for topic in rig_run.CHAIN:
            self.assertEqual(self.soft.messages.stamps(topic), stamps, topic)

    def test_same_again_with_two_threads_and_nodelets(self):
        again = press(hand_model='soft', threads='2', nodelets='true')
        self.assertEqual((again.code, again.left), (0, []), again.words)
        for topic in ('/hands/skin', '/clay/contacts', '/array/focal_points'):
            # Bytes 0-3 are the sequence number that roscpp counts for each publisher.
            mine, theirs = ([data[4:] for data in run.messages.bytes[topic]] for run in (self.soft, again))
            self.assertEqual(len(mine), len(theirs), topic)
            self.assertEqual([i for i, pair in enumerate(zip(mine, theirs)) if pair[0] != pair[1]], [], topic)

    def test_felt_while_it_presses_and_silent_after(self):
        points = focal_points(self.soft)
        hands = {stamp: m.hands[0] for stamp, m in self.soft.messages.by_stamp('/hands/tracked').items()}
        deepest = min(lowest_skin(hand) for hand in hands.values())
        steady = [stamp for stamp, hand in hands.items() if lowest_skin(hand) < deepest + 1e-5]
        # Firm clay gives back next to nothing: a finger that stops comes off it for a moment
        # (doc/method/soft_hand.md, limits).
        settled = [stamp for stamp in steady if stamp >= min(steady) + RECOIL]
        self.assertGreater(len(settled), 20)
        for stamp in settled:
            self.assertTrue(points[stamp], 'silent at %d ns' % stamp)
        apart = [stamp for stamp, hand in hands.items() if lowest_skin(hand) > APART]
        self.assertGreater(len(apart), 60)
        for stamp in apart:
            self.assertEqual(points[stamp], [], 'at %d ns' % stamp)

    def test_the_clay_holds_the_virtual_finger_back(self):
        skins = self.soft.messages.by_stamp('/hands/skin')
        hands = {stamp: m.hands[0] for stamp, m in self.soft.messages.by_stamp('/hands/tracked').items()}
        deepest = min(lowest_skin(hand) for hand in hands.values())
        steady = [stamp for stamp, hand in hands.items() if lowest_skin(hand) < deepest + 1e-5]
        back = [lowest_sample(skins[stamp]) - lowest_skin(hands[stamp]) for stamp in steady]
        self.assertGreater(min(back), 0.0005)

    def test_pressure_and_focal_points_lie_on_the_tracked_finger(self):
        to_world = array_to_world(self.soft)
        skins = self.soft.messages.by_stamp('/hands/skin')
        points = focal_points(self.soft)
        felt = 0
        for stamp, cloud in self.soft.messages.by_stamp('/hands/pressure').items():
            if not cloud.width:
                self.assertEqual(points[stamp], [])
                continue
            tracked = columns(skins[stamp], 'tracked_x', 'tracked_y', 'tracked_z')
            places = [to_world(Point(*row)) for row in columns(cloud, 'x', 'y', 'z')]
            for place in places:
                self.assertLess(min(distance(place, sample) for sample in tracked), 1e-5)
            for point in points[stamp]:
                place = to_world(point.position)
                # To the skin 3 mm, along it to the next sample, 2 mm apart on a pad.
                self.assertLess(min(distance(place, sample) for sample in places), 0.005)
                felt += 1
        self.assertGreater(felt, 20)

    def test_bones_show_the_tracked_finger_go_on_and_the_virtual_one_stay(self):
        bones = {message.markers[0].header.stamp.to_nsec(): message for message in self.soft.messages['/hands/bones']}
        hands = {stamp: m.hands[0] for stamp, m in self.soft.messages.by_stamp('/hands/tracked').items()}
        self.assertEqual(set(bones), set(hands))
        deepest = min(lowest_skin(hand) for hand in hands.values())
        for stamp, hand in hands.items():
            tips = {marker.ns: marker.points[TIP_POINT] for marker in bones[stamp].markers
                    if len(marker.points) == JOINTS}
            tracked = hand.joints[INDEX_TIP].position
            self.assertLess(distance(xyz(tips['tracked']), xyz(tracked)), 1e-9)
            if lowest_skin(hand) < deepest + 1e-5:
                self.assertGreater(tips['virtual'].z - tips['tracked'].z, 0.0005)

    def test_diagnostics_tell_what_a_frame_costs(self):
        values = [{pair.key: pair.value for pair in status.values} for message in self.soft.messages['/diagnostics']
                  for status in message.status if status.name.endswith('hand skin')]
        self.assertTrue(any(float(value['processor time for a frame, mean, ms']) > 0.0 for value in values), values)

    def test_a_wrong_model_is_one_line(self):
        run = rig_run.Run({'hand_model': 'wax'}, topics=['/hands/skin'])
        self.assertNotEqual(run.code, 0)
        self.assertIn("unknown hand_model 'wax': expected kinematic or soft", run.words)


if __name__ == '__main__':
    rig_run.main('soft_hand')
