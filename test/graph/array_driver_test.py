#!/usr/bin/env python3
"""The safety gate in front of a live array: see array_driver.test."""
import math
import threading
import time
import unittest

import rospy
from geometry_msgs.msg import Point
from std_srvs.srv import Trigger
from tactile_clay.msg import ArrayState, FocalPoint, FocalPointArray

import rig_run

PATIENCE = 20.0  # s, for what has no time of its own


def focus(x=0.0, y=0.0, z=0.17, intensity=0.5):
    return FocalPoint(id=1, position=Point(x, y, z), pressure=1000.0, intensity=intensity)


class Stream:
    """Focal points at 60 Hz in a thread of its own, as a renderer sends them."""

    def __init__(self, publisher):
        self.publisher, self.points, self.frame, self.age = publisher, [focus()], 'array', 0.0
        self.running, self.last_sent = True, time.monotonic()
        self.thread = threading.Thread(target=self.run)
        self.thread.start()

    def run(self):
        while self.running:
            message = FocalPointArray(points=self.points, modulation_frequency=200.0)
            message.header.frame_id = self.frame
            message.header.stamp = rospy.Time.now() - rospy.Duration(self.age)
            self.publisher.publish(message)
            self.last_sent = time.monotonic()
            time.sleep(1.0 / 60.0)

    def stop(self):
        self.running = False
        self.thread.join()


class ArrayDriver(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rospy.init_node('array_driver_test')
        cls.states, cls.came = [], threading.Condition()
        cls.subscriber = rospy.Subscriber('array/state', ArrayState, cls.receive)
        cls.publisher = rospy.Publisher('array/focal_points', FocalPointArray, queue_size=1, tcp_nodelay=True)
        for service in ('stop', 'reset'):
            rospy.wait_for_service('array_driver/' + service, PATIENCE)
        rig_run.wait_until(lambda: cls.publisher.get_num_connections() and cls.subscriber.get_num_connections(), PATIENCE,
                           'a connected driver')

    @classmethod
    def receive(cls, state):
        with cls.came:
            cls.states.append((time.monotonic(), state))
            cls.came.notify_all()

    def setUp(self):
        self.stream = Stream(self.publisher)
        self.addCleanup(self.stream.stop)
        self.wait(lambda state: state.emitting)

    def call(self, name):
        answer = rospy.ServiceProxy('array_driver/' + name, Trigger)()
        self.assertTrue(answer.success, answer.message)

    def wait(self, condition, since=None):
        """The first state from now on (or from `since`) that meets the condition, with the time at which it came."""
        since = time.monotonic() if since is None else since
        deadline = time.monotonic() + PATIENCE
        with self.came:
            while True:
                for came, state in self.states:
                    if came >= since and condition(state):
                        return came, state
                if not self.came.wait(deadline - time.monotonic()):
                    self.fail('no such state; the last one:\n%s' % (self.states[-1:] or 'none'))

    def expect_silence(self, reason):
        _, state = self.wait(lambda state: not state.emitting)
        self.assertIn(reason, state.silent_reason)
        return state

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
        with self.came:
            self.assertFalse([state for came, state in self.states if came > stopped + 0.05 and state.emitting])
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
                ('intensity NaN', [focus(intensity=nan)], 'array', 'non-finite'),
                ('other frame', [focus()], 'world', 'world')):
            with self.subTest(name):
                self.stream.points, self.stream.frame = points, frame
                self.assertGreater(self.expect_silence(reason).frames_rejected, 0)
                self.stream.points, self.stream.frame = [focus()], 'array'
                self.wait(lambda state: state.emitting)


if __name__ == '__main__':
    rig_run.main('array_driver')
