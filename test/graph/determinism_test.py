#!/usr/bin/env python3
"""Bit-identical focal points: see determinism.test."""
import unittest

import rig_run

MAX_POINTS = 4


def knead(**arguments):
    # Both hands are in the clay after 3.5 s.
    return rig_run.Run(dict(rig_run.LOCKSTEP, modulation='am', hands='bag', file=rig_run.bag('knead'), quality='fast',
                            duration='3.5', max_points=str(MAX_POINTS), **arguments))


class Determinism(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.first = knead(threads='1')

    def expect_same(self, run):
        self.assertEqual(run.code, 0, run.words)
        self.assertEqual(run.left, [])
        for topic in ('/clay/contacts', '/hands/pressure', '/array/focal_points'):
            # Bytes 0-3 are the sequence number that roscpp counts for each publisher.
            mine, theirs = ([data[4:] for data in r.messages.bytes[topic]] for r in (self.first, run))
            self.assertEqual(len(mine), len(theirs), topic)
            different = [i for i, pair in enumerate(zip(mine, theirs)) if pair[0] != pair[1]]
            self.assertEqual(different, [], 'frames of %s that differ' % topic)

    def test_the_run_is_worth_comparing(self):
        self.assertEqual(self.first.code, 0, self.first.words)
        points = self.first.messages['/array/focal_points']
        self.assertEqual(len(points), 210)
        self.assertGreater(len([1 for message in points if len(message.points) == MAX_POINTS]), 30)

    def test_never_more_than_max_points(self):
        self.assertLessEqual(max(len(m.points) for m in self.first.messages['/array/focal_points']), MAX_POINTS)

    def test_same_again(self):
        self.expect_same(knead(threads='1'))

    def test_same_with_two_threads(self):
        self.expect_same(knead(threads='2'))

    def test_same_as_nodelets(self):
        self.expect_same(knead(threads='2', nodelets='true'))


if __name__ == '__main__':
    rig_run.main('determinism')
