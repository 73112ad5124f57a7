#!/usr/bin/env python3
"""The safety gate in front of a live array: see array_driver.test."""
import math
import time
import unittest

import rospy
from std_srvs.srv import Trigger
from tactile_clay.msg import TrackedHand

import rig_run
from array_stream import PATIENCE, Driver, States, Stream, focus


class ArrayDriver(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rospy.init_node('array_driver_test')
        cls.states = States()
        driver = Driver(device='debug', array_pose='0 0 -0.15 0 0 0', head_point='-0.4 0 0.45')
        driver.__enter__()
        cls.addClassCleanup(driver.__exit__)
        for service in ('stop', 'reset'):
            rospy.wait_for_service('array_driver/' + service, PATIENCE)

    def setUp(self):
        self.stream = Stream()
        self.addCleanup(self.stream.stop)
        self.wait(lambda state: state.emitting)

    def wait(self, condition, since=None):
        return self.states.wait(condition, since)

    def call(self, name):
        answer = rospy.ServiceProxy('array_driver/' + name, Trigger)()
        self.assertTrue(answer.success, answer.message)

    def expect_silence(self, reason):
        return self.wait(lambda state: not state.emitting and reason in state.silent_reason)[1]

    def test_what_comes_in_time_is_emitted(self):
        _, before = self.wait(lambda state: state.emitting)
        _, after = self.wait(lambda state: state.emitting and state.frames_sent > before.frames_sent + 30)
        self.assertEqual((after.device, after.silent_reason), ('debug', ''))
        self.assertLess(after.latency, 0.1)
        self.assertTrue(math.isfinite(after.head_spl) and after.head_spl > 0)

    def test_no_points_is_silence(self):
        self.stream.points = []
        self.expect_silence('no focal points')

    def test_a_stream_that_ends_is_silenced(self):
        self.stream.stop()
        came, state = self.wait(lambda state: not state.emitting, self.stream.last_sent)
        self.assertIn('stale', state.silent_reason)
        self.assertLess(came - self.stream.last_sent, 0.25)

    def test_points_that_are_late_are_not_emitted(self):
        self.stream.age = 0.5
        self.assertGreater(self.expect_silence('stale').frames_late, 0)
        self.stream.age = 0.0
        self.wait(lambda state: state.emitting)

    def test_stop_is_latched_until_reset(self):
        self.addCleanup(self.call, 'reset')
        self.call('stop')
        stopped = time.monotonic()
        self.expect_silence('emergency stop')
        # Half a second of good points changes nothing.
        self.wait(lambda state: time.monotonic() > stopped + 0.5)
        with self.states.came:
            self.assertFalse([state for came, state in self.states.states if came > stopped + 0.05 and state.emitting])
        self.call('reset')
        self.wait(lambda state: state.emitting)

    def test_bad_points_are_not_emitted(self):
        nan, infinity = float('nan'), float('inf')
        for name, points, frame, reason in (
                ('NaN', [focus(), focus(x=nan)], 'array', 'non-finite'),
                ('infinite', [focus(z=infinity)], 'array', 'non-finite'),
                ('far away', [focus(y=0.5)], 'array', 'outside the workspace'),
                ('behind the array', [focus(z=-0.1)], 'array', 'outside the workspace'),
                ('too strong', [focus(intensity=1.5)], 'array', 'intensity'),
                ('too many', [focus(number=n) for n in range(257)], 'array', 'at most 256'),
                ('intensity NaN', [focus(intensity=nan)], 'array', 'non-finite'),
                ('other frame', [focus()], 'world', 'world')):
            with self.subTest(name):
                self.stream.points, self.stream.frame = points, frame
                self.assertGreater(self.expect_silence(reason).frames_rejected, 0)
                self.stream.points, self.stream.frame = [focus()], 'array'
                self.wait(lambda state: state.emitting)

    def test_without_a_hand_nothing_is_emitted(self):
        self.stream.hands = []
        self.assertGreater(self.expect_silence('hand lost: no hand').frames_rejected, 0)
        self.stream.hands = [TrackedHand()]
        self.wait(lambda state: state.emitting)
        self.stream.hands = None  # as if the tracker had died
        self.expect_silence('hand lost: no word')

    def test_level_at_the_head_keeps_to_its_cap(self):
        self.stream.points = [focus(intensity=1.0)]
        _, state = self.wait(lambda state: state.emitting and state.head_spl > 109.0)
        self.assertLessEqual(state.head_spl, 110.0)


class Rules(unittest.TestCase):
    """Each rule of the gate, left out alone: what it holds back is emitted."""

    @classmethod
    def setUpClass(cls):
        cls.states = States()

    def sounds(self, offend, without):
        """Whether a driver goes on to emit, at full strength, after `offend` has changed its stream."""
        loud = dict(pressure_cap=1e5, head_spl_cap=200.0)
        with Driver(device='debug', gate_without=without, **loud):
            stream = Stream()
            try:
                self.states.wait(lambda state: state.emitting)
                offend(stream)
                time.sleep(0.4)
                _, state = self.states.wait(lambda _: True)
                return state.emitting
            finally:
                stream.stop()

    def expect(self, rule, offend):
        self.assertFalse(self.sounds(offend, []), 'the whole gate')
        self.assertTrue(self.sounds(offend, [rule]), 'the gate without ' + rule)

    def test_stale(self):
        self.expect('stale', lambda stream: setattr(stream, 'age', 0.5))

    def test_hand_lost(self):
        self.expect('hand_lost', lambda stream: setattr(stream, 'hands', []))

    def test_workspace(self):
        self.expect('workspace', lambda stream: setattr(stream, 'points', [focus(y=0.3)]))

    def test_emergency_stop(self):
        self.expect('emergency_stop', lambda _: rospy.ServiceProxy('array_driver/stop', Trigger)())

    def test_head_level(self):
        def level(without):
            with Driver(device='debug', gate_without=without):
                stream = Stream()
                try:
                    stream.points = [focus(intensity=1.0)]
                    time.sleep(1.0)
                    return self.states.wait(lambda state: state.emitting)[1].head_spl
                finally:
                    stream.stop()
        self.assertLessEqual(level(['pressure']), 110.0)
        self.assertGreater(level(['pressure', 'head_level']), 115.0)

    def test_unknown_rule(self):
        with Driver(device='debug', gate_without=['everything']) as driver:
            self.assertEqual(driver.process.wait(20), 1)
        self.assertIn("unknown rule 'everything'", driver.words())


if __name__ == '__main__':
    rig_run.main('array_driver')
