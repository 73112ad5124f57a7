#!/usr/bin/env python3
"""Messages that nobody should send: see fuzz.test."""
import copy
import os
import subprocess
import time
import unittest

import rospy
from sensor_msgs.msg import PointCloud2
from std_msgs.msg import Header
from tactile_clay.msg import ArrayState, FocalPointArray, TrackedHands
from std_srvs.srv import Trigger

import rig_run
from rig_run import wait_until

PROGRAMS = os.path.join(rig_run.build_space(), 'devel', 'lib', 'tactile_clay')
CHAIN = ['hand_simulator', 'clay_simulator', 'contact_pressure', 'focal_point_renderer', 'simulated_array']
MESSAGES = int(os.environ.get('TACTILE_CLAY_FUZZ_MESSAGES', '150'))  # to each topic
PATIENCE = 30.0      # s
LINES = 1.0          # at most, a second and topic
TOPICS = 17          # that the fuzzer knows


def fuzz(graph, *arguments):
    """Runs the fuzzer. Returns its exit code, its words, and how many s it took."""
    start = time.monotonic()
    done = subprocess.run([os.path.join(PROGRAMS, 'fuzz_topics'), *arguments], env=graph.environment,
                          stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                          timeout=60 + MESSAGES, check=False)
    return done.returncode, done.stdout.decode(errors='replace'), time.monotonic() - start


class Fuzz(unittest.TestCase):
    """The chain of nodes as processes, in the master of the test, in lockstep: the test is the tracker."""

    @classmethod
    def setUpClass(cls):
        rospy.init_node('fuzz_test')
        cls.samples = rig_run.Messages(rig_run.bag('press_finger'))['/hands/tracked']
        cls.answers, cls.points = {}, {}
        rospy.Subscriber('array/state', ArrayState, lambda m: cls.answers.update({m.header.stamp.to_nsec(): m}))
        rospy.Subscriber('array/focal_points', FocalPointArray,
                         lambda m: cls.points.update({m.header.stamp.to_nsec(): m}))
        cls.hands = rospy.Publisher('hands/tracked', TrackedHands, queue_size=10)

    def feel(self):
        """Focal points of each sample of the bag. The clay starts anew."""
        self.answers.clear()
        self.points.clear()
        first = TrackedHands(header=copy.deepcopy(self.samples[0].header))
        first.header.stamp -= rospy.Duration(0.1)
        self.send(first)  # the hands of before leave
        self.assertTrue(rospy.ServiceProxy('clay_simulator/reset', Trigger)().success)
        felt = []
        for sample in self.samples:
            self.send(sample)
            points = self.points[sample.header.stamp.to_nsec()].points
            felt.append([(p.position.x, p.position.y, p.position.z, p.pressure, p.intensity) for p in points])
        return felt

    def send(self, message):
        self.hands.publish(message)
        stamp = message.header.stamp.to_nsec()
        deadline = time.monotonic() + PATIENCE
        while stamp not in self.answers or stamp not in self.points:
            self.assertLess(time.monotonic(), deadline, 'no answer to %d' % stamp)
            time.sleep(0.002)

    def test_processes(self):
        graph = rig_run.Graph()  # its processes only: the master is that of the test
        graph.environment = dict(os.environ, ROS_LOG_DIR=os.path.join(graph.folder, 'log'))
        words = open(os.path.join(graph.folder, 'words'), 'w+', errors='replace')
        try:
            nodes = [graph.start([os.path.join(PROGRAMS, name), '_lockstep:=true', '_quality:=fast'], stdout=words,
                                 stderr=words)
                     for name in CHAIN]
            nodes.append(graph.start([os.path.join(PROGRAMS, 'hand_skeleton')], stdout=words, stderr=words))
            wait_until(lambda: self.hands.get_num_connections() >= 3, PATIENCE, 'the nodes')
            rospy.wait_for_service('clay_simulator/reset', PATIENCE)
            time.sleep(1.0)
            before = self.feel()
            self.assertGreater(len([points for points in before if points]), 10)
            code, said, seconds = fuzz(graph, '--messages', str(MESSAGES), '--rate', '50')
            self.assertEqual(code, 0, said)
            self.assertEqual([node.poll() for node in nodes], [None] * len(nodes))
            # What waits in lockstep is worked on first.
            after = self.feel()
            self.assertEqual(after, before)
            words.seek(0)
            lines = words.read().splitlines()
            self.assertLess(len(lines), LINES * TOPICS * seconds, '\n'.join(lines[-60:]))
            self.assertTrue([line for line in lines if 'left out' in line], lines)
            # A name of a frame makes no lines of its own.
            skin = rospy.Publisher('hands/skin', PointCloud2, queue_size=1)
            told = "skin in frame 'here?[FATAL] there' left out"

            def is_told():
                skin.publish(PointCloud2(header=Header(frame_id='here\n[FATAL] there')))
                with open(words.name, errors='replace') as copy:  # the nodes write where `words` stands
                    return told in copy.read()
            wait_until(is_told, PATIENCE, told)
        finally:
            graph.__exit__()
            words.close()

    def test_nodelets(self):
        with rig_run.Graph() as graph:
            rig = graph.rig(dict(hands='none', nodelets='true', skeleton='true', quality='fast'))
            wait_until(lambda: graph.subscribed('/array/focal_points') and graph.registered('/robot_state_publisher'),
                       PATIENCE, 'the rig')
            time.sleep(3.0)
            started = len(graph.words())
            code, said, seconds = fuzz(graph, '--messages', str(MESSAGES), '--rate', '50')
            self.assertEqual(code, 0, said + graph.words()[-3000:])
            self.assertIsNone(rig.poll(), graph.words())
            lines = graph.words()[started:].splitlines()
            self.assertLess(len(lines), LINES * TOPICS * seconds, '\n'.join(lines[-60:]))
            graph.stop(rig)


if __name__ == '__main__':
    rig_run.main('fuzz')
