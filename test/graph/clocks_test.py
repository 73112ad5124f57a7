#!/usr/bin/env python3
"""Stamps of other clocks: see clocks.test."""
import os
import re
import subprocess
import tempfile
import time
import unittest

import rosbag
import rospy
from tactile_clay.msg import TrackedHand, TrackedHands

import rig_run
from array_stream import Driver, States, Stream

COMPARE = "compare the hosts' clocks"
DAY = 86400.0
LATE = 0.3  # s, of a message on a busy machine


class Clocks(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rospy.init_node('clocks_test')
        cls.states = States()
        cls.stream = Stream()
        cls.addClassCleanup(cls.stream.stop)

    def setUp(self):
        self.stream.reset()
        time.sleep(0.1)  # what was on its way is gone

    def driver(self, check_stamps, age):
        self.stream.age = age
        time.sleep(0.1)
        driver = Driver(device='debug', check_stamps=check_stamps)
        driver.__enter__()
        self.addCleanup(driver.__exit__)
        return driver

    def expect_silence(self, since, *words):
        _, state = self.states.wait(lambda state: 'stale' in state.silent_reason, since)
        for word in words:
            self.assertIn(word, state.silent_reason)
        time.sleep(0.3)
        with self.states.came:
            self.assertFalse([state for when, state in self.states.states if when > since and state.emitting])
        return state.silent_reason

    def test_clocks_that_are_apart(self):
        for check_stamps in ('true', 'auto'):
            for age, way in ((5.0, 'behind'), (-5.0, 'ahead')):
                with self.subTest(check_stamps=check_stamps, age=age):
                    since = time.monotonic()
                    driver = self.driver(check_stamps, age)
                    reason = self.expect_silence(since, COMPARE)
                    self.doCleanups()
                    for words in (reason, driver.words()):
                        told = re.search(r'stamps are ([0-9.]+) s %s' % way, words)
                        self.assertTrue(told, words)
                        self.assertAlmostEqual(float(told.group(1)), abs(age), delta=LATE)

    def test_a_live_stream_keeps_its_age_check(self):
        """As with hands:=topic from a tracker."""
        self.driver('auto', 0.0)
        self.states.wait(lambda state: state.emitting)
        self.stream.age = 0.5
        since = time.monotonic() + 0.1
        self.expect_silence(since)
        self.stream.age = DAY
        self.expect_silence(time.monotonic() + 0.1, COMPARE)
        self.stream.age = 0.0
        self.states.wait(lambda state: state.emitting)

    def test_a_recording_sounds_and_that_is_told(self):
        driver = self.driver('auto', 3 * DAY)
        self.states.wait(lambda state: state.emitting)
        self.doCleanups()
        self.assertIn('taken for those of a recording', driver.words())
        self.assertIn(COMPARE, driver.words())

    def test_a_recording_of_just_now_is_known_by_its_player(self):
        self.stream.hands = None
        self.driver('auto', 20.0)
        self.states.wait(lambda state: COMPARE in state.silent_reason)
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, 'hands.bag')
            with rosbag.Bag(path, 'w') as bag:
                for number in range(180):
                    hands = TrackedHands(hands=[TrackedHand()])
                    hands.header.stamp = rospy.Time.now() - rospy.Duration(20.0 - number / 60.0)
                    bag.write('/hands/tracked', hands, hands.header.stamp)
            player = subprocess.Popen(['rosbag', 'play', '--quiet', path], stdin=subprocess.DEVNULL,
                                      start_new_session=True)
            self.addCleanup(player.wait)
            self.states.wait(lambda state: state.emitting)
            player.wait()

    def test_wrong_use(self):
        with Driver(device='debug', check_stamps='sometimes') as driver:
            self.assertEqual(driver.process.wait(20), 1)
        self.assertIn("expected true, false or auto, got 'sometimes'", driver.words())


if __name__ == '__main__':
    rig_run.main('clocks')
