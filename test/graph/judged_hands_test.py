#!/usr/bin/env python3
"""Hands that are no hands, and a lockstep run that waits: see judged_hands.test."""
import copy
import os
import signal
import subprocess
import time
import unittest

import rosbag
import rospy
from sensor_msgs.msg import PointCloud2
from tactile_clay.msg import ArrayState, TrackedHands

import rig_run
from array_stream import PROGRAMS
from rig_run import wait_until

LITTLE = range(21, 26)  # joints of the little finger
RATE = 60.0


def column(cloud, name):
    """Values of an unsigned column of a cloud."""
    field = next(f for f in cloud.fields if f.name == name)
    return [int.from_bytes(cloud.data[i * cloud.point_step + field.offset:][:4], 'little') for i in range(cloud.width)]


class Judged(unittest.TestCase):
    """hand_simulator alone, on hands that another program publishes."""

    @classmethod
    def setUpClass(cls):
        rospy.init_node('judged_hands_test')
        cls.hand = rig_run.Messages(rig_run.bag('press_finger'))['/hands/tracked'][0].hands[0]
        cls.words = open(os.path.join(os.environ['ROS_HOME'], 'hand_simulator.words'), 'w+')
        cls.addClassCleanup(cls.words.close)
        cls.node = subprocess.Popen([os.path.join(PROGRAMS, 'hand_simulator'), '_live_input:=true'],
                                    stdin=subprocess.DEVNULL,
                                    stdout=cls.words, stderr=subprocess.STDOUT)
        cls.addClassCleanup(cls.node.wait)
        cls.addClassCleanup(cls.node.terminate)
        cls.skins = {}
        cls.subscriber = rospy.Subscriber('hands/skin', PointCloud2, lambda m: cls.skins.setdefault(m.header.stamp, m))
        cls.publisher = rospy.Publisher('hands/tracked', TrackedHands, queue_size=100, tcp_nodelay=True)
        wait_until(lambda: cls.publisher.get_num_connections() > 0 and cls.subscriber.get_num_connections() > 0, 20,
                   'a skin')

    def told(self):
        self.words.seek(0)
        return self.words.read()

    def send(self, hands, stamp=None, moved=0.0):
        """Publishes, returns the skin. Moved by `moved` m, as a live hand trembles."""
        hands = copy.deepcopy(hands)
        for hand in hands:
            for joint in hand.joints:
                joint.position.y += moved
        message = TrackedHands(hands=hands)
        message.header.stamp = stamp or rospy.Time.now()
        message.header.frame_id = 'world'
        self.skins.pop(message.header.stamp, None)
        self.publisher.publish(message)
        wait_until(lambda: message.header.stamp in self.skins, 10, 'an answer')
        self.assertIsNone(self.node.poll())
        return self.skins[message.header.stamp]

    def test_what_is_no_hand_has_no_skin(self):
        whole = self.send([self.hand]).width
        self.assertGreater(whole, 500)
        def at_origin(hand):
            for joint in hand.joints:
                joint.position.x = joint.position.y = joint.position.z = 0.0
        def in_millimetres(hand):
            for joint in hand.joints:
                joint.position.x, joint.position.y, joint.position.z = (
                    1e3 * v for v in (joint.position.x, joint.position.y, joint.position.z))
        def as_the_other(hand):
            hand.side = 1 - hand.side
        def reversed_joints(hand):
            hand.joints = list(reversed(hand.joints))
        for spoil in (at_origin, in_millimetres, as_the_other, reversed_joints):
            with self.subTest(spoil.__name__):
                hand = copy.deepcopy(self.hand)
                spoil(hand)
                self.assertEqual(self.send([hand]).width, 0)
        self.assertRegex(self.told(), r'right hand \d+ left out: .*expected')
        time.sleep(0.1)
        self.assertEqual(self.send([self.hand], moved=1e-4).width, whole)

    def test_a_finger_that_was_not_located_has_no_skin(self):
        whole = self.send([self.hand], moved=2e-4)
        for radius in (0.0, 0.008):
            hand = copy.deepcopy(self.hand)
            hand.radii = list(hand.radii)
            for k in LITTLE:
                hand.joints[k].position.x = hand.joints[k].position.y = hand.joints[k].position.z = 0.0
                hand.radii[k] = radius
            less = self.send([hand], moved=3e-4 + radius)
            self.assertGreater(less.width, 0.7 * whole.width)
            self.assertTrue(set(LITTLE) & set(column(whole, 'region')))
            self.assertFalse(set(LITTLE) & set(column(less, 'region')))
        self.assertEqual(self.send([self.hand], moved=4e-4).width, whole.width)

    def test_radii_that_nobody_knows_are_those_of_an_adult(self):
        whole = self.send([self.hand], moved=5e-4)
        hand = copy.deepcopy(self.hand)
        hand.radii = [0.0] * 26
        self.assertEqual(self.send([hand], moved=6e-4).width, whole.width)

    def test_a_hand_that_jumps_is_there_from_its_second_sample_on(self):
        start = rospy.Time.now()
        # At most 20 m/s; by their stamps there are 10 ms between two samples.
        widths = [self.send([self.hand], start + rospy.Duration(0.01 * k), 1e-3 + jump).width > 0
                  for k, jump in enumerate((0.0, 1e-5, 0.5, 0.50001, 0.0, 0.5, 0.0))]
        self.assertEqual(widths, [True, True, False, True, False, False, False])

    def test_a_live_hand_that_is_only_repeated_is_let_go(self):
        def widths(stamp_of, moved_of):
            result, start = [], time.monotonic()
            for k in range(18):
                time.sleep(max(0.0, start + k / RATE - time.monotonic()))
                result.append((time.monotonic() - start, self.send([self.hand], stamp_of(), moved_of(k)).width))
            return result
        trembling = widths(rospy.Time.now, lambda k: 2e-3 + 1e-6 * k)
        self.assertTrue(all(width > 0 for _, width in trembling), trembling)
        still = widths(rospy.Time.now, lambda k: 3e-3)
        print('a still hand has its skin for %.0f ms' % (1e3 * max(t for t, width in still if width > 0)))
        self.assertLess(max(t for t, width in still if width > 0), 0.1)
        self.assertEqual(still[-1][1], 0)
        time.sleep(1.1)  # lines are throttled
        self.send([self.hand], moved=3e-3)
        self.assertIn('the tracker is frozen', self.told())
        # A device without a clock: the same stamp for ever.
        stamp = rospy.Time(7)
        standing = widths(lambda: stamp, lambda k: 3.5e-3)
        self.assertEqual(standing[-1][1], 0, standing)
        # A tracker whose stamps count from its start.
        uptime = iter(range(1000))
        standing = widths(lambda: rospy.Time(1000, 10000000 * next(uptime)), lambda k: 4e-3)
        self.assertEqual(standing[-1][1], 0, standing)

    def test_a_hand_that_rosbag_plays_may_stand_still(self):
        stamps = [rospy.Time(2000, 10000000 * k) for k in range(60)]
        path = os.path.join(os.environ['ROS_HOME'], 'still.bag')
        with rosbag.Bag(path, 'w') as bag:
            for stamp in stamps:
                message = TrackedHands(hands=[self.hand])
                message.header.stamp = stamp
                message.header.frame_id = 'world'
                bag.write('/hands/tracked', message, stamp)
        player = subprocess.Popen(['rosbag', 'play', '-q', '-d', '2', path], stdin=subprocess.DEVNULL)
        self.addCleanup(player.wait)
        self.addCleanup(player.terminate)
        wait_until(lambda: stamps[-1] in self.skins, 30, 'the end of the bag')
        seen = [self.skins[stamp].width for stamp in stamps if stamp in self.skins]
        self.assertGreater(len(seen), 50)
        self.assertTrue(all(seen), seen)


class Waits(unittest.TestCase):
    def test_a_run_that_waits_names_the_node_that_does_not_answer(self):
        with rig_run.Graph() as graph:
            for name, value in (('lockstep', True), ('answer_patience', 2.0), ('file', rig_run.bag('press_finger')),
                                ('graph', ['hands/tracked', 'hands/skin', 'clay/contacts', 'array/state'])):
                graph.master().setParam('/test', '/hand_tracking/' + name, value)
            graph.master().setParam('/test', '/hand_simulator/lockstep', True)
            graph.start([os.path.join(PROGRAMS, 'hand_simulator')])
            for words in (['clay', 'hands/skin', 'clay/contacts', '5'],
                          ['array', 'clay/contacts', 'array/state', '100']):
                graph.start([os.path.abspath(__file__), '--relay'] + words)
            rig_run.wait_until(lambda: all(graph.subscribed(topic)
                                           for topic in ('/hands/tracked', '/hands/skin', '/clay/contacts')),
                               30.0, 'the nodes')
            path = os.path.join(graph.folder, 'words')
            with open(path, 'w') as words:
                tracking = graph.start([os.path.join(PROGRAMS, 'hand_tracking')], stdout=words,
                                       stderr=subprocess.STDOUT)
            self.assertEqual(tracking.wait(40), 1)
            with open(path) as words:
                self.assertRegex(words.read(), 'lockstep: no answer on /array/state to frame 6 within 2 s: '
                                 '/clay got it as /hands/skin and has not sent /clay/contacts')


def relay(name, source, sink, count):
    """Stands in for a node of the rig: passes on the first `count` samples."""
    rospy.init_node(name)
    kind = {'array/state': ArrayState}.get(sink, PointCloud2)
    publisher = rospy.Publisher(sink, kind, queue_size=100)
    left = iter(range(count))
    def receive(message):
        if next(left, None) is not None:
            answer = kind()
            answer.header.stamp = message.header.stamp
            publisher.publish(answer)
    rospy.Subscriber(source, PointCloud2, receive, queue_size=100)
    rospy.spin()


class Played(unittest.TestCase):
    """hand_tracking alone, which plays a recording by the clock."""

    def test_samples_that_are_released_late_stay_as_far_apart_as_they_were(self):
        """Stamps of now would be microseconds apart, and the hands too fast: they tore the clay."""
        stamps = []
        subscriber = rospy.Subscriber('/played/hands/tracked', TrackedHands,
                                      lambda m: stamps.append(m.header.stamp.to_nsec()))
        self.addCleanup(subscriber.unregister)
        node = subprocess.Popen([os.path.join(PROGRAMS, 'hand_tracking'), '__ns:=played', '_source:=bag',
                                 '_file:=' + rig_run.bag('knead')], stdin=subprocess.DEVNULL)
        self.addCleanup(node.wait)
        self.addCleanup(node.terminate)
        wait_until(lambda: stamps, 20, 'a sample')
        for _ in range(4):
            os.kill(node.pid, signal.SIGSTOP)
            time.sleep(0.2)
            os.kill(node.pid, signal.SIGCONT)
            time.sleep(0.4)
        apart = [later - earlier for earlier, later in zip(stamps, stamps[1:])]
        self.assertGreater(len(apart), 60)
        for distance in apart:  # some may be overtaken on their way
            periods = 1e-9 * distance * RATE
            self.assertGreater(periods, 0.9)
            self.assertAlmostEqual(periods, round(periods), delta=0.1)


if __name__ == '__main__':
    import sys
    if '--relay' in sys.argv:
        at = sys.argv.index('--relay') + 1
        relay(*sys.argv[at:at + 3], int(sys.argv[at + 3]))
    else:
        rig_run.main('judged_hands')
