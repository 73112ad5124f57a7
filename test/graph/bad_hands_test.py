#!/usr/bin/env python3
"""A tracker that fails while a finger presses: see bad_hands.test."""
import math
import unittest

import rig_run
from rig_messages import focal_points, lowest_skin, pressing
from rig_run import input_stamps, lockstep

TOUCHING = 0.038  # m, of the lowest skin over the table: surely in the clay


def samples(name):
    """Hands of each sample of a shipped bag, by stamp, ns."""
    return {stamp: message.hands for stamp, message in
            rig_run.Messages(rig_run.bag(name)).by_stamp('/hands/tracked').items()}


def sane(hand):
    numbers = [n for joint in hand.joints for part, names in ((joint.position, 'xyz'), (joint.orientation, 'xyzw'))
               for n in (getattr(part, name) for name in names)]
    return all(math.isfinite(n) and abs(n) < 10 for n in numbers)


class BadHands(unittest.TestCase):
    def expect_answered(self, name, run):
        self.assertEqual(run.code, 0, run.words)
        self.assertEqual(run.left, [])
        self.assertNotIn('Traceback', run.words)
        for topic in rig_run.CHAIN:
            self.assertEqual(run.messages.stamps(topic), input_stamps(name), topic)

    def test_no_finite_number_no_touch(self):
        run = lockstep('nan')
        self.expect_answered('nan', run)
        points, seen = focal_points(run), samples('nan')
        heights = {stamp: lowest_skin(hands[0]) for stamp, hands in seen.items() if sane(hands[0])}
        touching = set(pressing(heights, TOUCHING))
        bad = good = 0
        for stamp, hands in seen.items():
            if not sane(hands[0]):
                bad += 1
                self.assertEqual(points[stamp], [], 'a broken hand is felt at %d ns' % stamp)
            elif stamp in touching:
                good += 1
                self.assertTrue(points[stamp], 'a good hand is not felt at %d ns' % stamp)
        self.assertGreater(bad, 20)
        self.assertGreater(good, 15)

    def test_one_warning_says_which_joint(self):
        words = lockstep('nan').words
        warnings = [line for line in words.splitlines() if 'left out' in line]
        self.assertTrue(warnings, words)
        self.assertRegex(warnings[0], r'right hand.*index_tip.*position.*nan.*expected finite')
        self.assertLess(len(warnings), 20, 'a warning for each of 40 bad samples is no warning')

    def test_a_lost_hand_is_let_go(self):
        run = lockstep('lost_hand')
        self.expect_answered('lost_hand', run)
        points, seen = focal_points(run), samples('lost_hand')
        loss = min(stamp for stamp, hands in seen.items() if not hands)
        before = max(stamp for stamp, hands in seen.items() if hands)
        self.assertTrue(points[before], 'the hand was not felt even before')
        for stamp in seen:
            if stamp - loss > 150e6:
                self.assertEqual(points[stamp], [], 'felt %.0f ms after the loss' % (1e-6 * (stamp - loss)))

    def test_an_id_that_changes_is_the_same_hand(self):
        run = lockstep('id_change')
        self.expect_answered('id_change', run)
        points, seen = focal_points(run), samples('id_change')
        touching = pressing({stamp: lowest_skin(hands[0]) for stamp, hands in seen.items()}, TOUCHING)
        self.assertEqual(len({seen[stamp][0].id for stamp in touching}), 2)
        for stamp in touching:
            self.assertTrue(points[stamp], 'silent at %d ns' % stamp)
        same = lockstep('press_finger')
        self.assertEqual(*([data[4:] for data in r.messages.bytes['/array/focal_points']] for r in (run, same)))

    def test_nobody_there(self):
        run = lockstep('no_hands')
        self.expect_answered('no_hands', run)
        self.assertEqual(len(run.messages['/array/state']), 121)
        for message in run.messages['/array/focal_points']:
            self.assertEqual(message.points, [])
        for state in run.messages['/array/state']:
            self.assertFalse(state.emitting)


if __name__ == '__main__':
    rig_run.main('bad_hands')
