#!/usr/bin/env python3
"""Arrays whose roslaunch or master is dead or frozen: see supervisors.test."""
import os
import signal
import subprocess
import sys
import time
import unittest

import rospy
from tactile_clay.msg import ArrayState

import rig_run
from array_stream import PROGRAM, Stream
from rig_run import wait_until

LIMIT = 1.0   # s, in which the array has to be silent
SLACK = 0.25  # s, that a busy machine may take longer
SUPERVISED = ['/simulated_array', '/array_driver', '/manager']
ALONE = '/alone'  # its launch says that it needs nobody
LAUNCH = '''
<launch>
  <node name="simulated_array" pkg="tactile_clay" type="simulated_array"/>
  <node name="array_driver" pkg="tactile_clay" type="array_driver"><param name="device" value="debug"/></node>
  <node name="manager" pkg="tactile_clay" type="nodelet_manager"/>
  <node name="nodelet" pkg="nodelet" type="nodelet" args="load tactile_clay/array_driver manager"/>
  <param name="nodelet/device" value="debug"/>
  <node name="alone" pkg="tactile_clay" type="array_driver">
    <param name="device" value="debug"/>
    <param name="supervisors" value="none"/>
  </node>
</launch>
'''


class Supervisors(unittest.TestCase):
    """One story, in which the master dies at the end."""

    def setUp(self):
        self.graph = rig_run.Graph()
        self.addCleanup(self.graph.__exit__)
        self.graph.__enter__()
        os.environ['ROS_MASTER_URI'] = self.graph.uri
        rospy.init_node('supervisors_test', disable_signals=True)
        self.states = {}
        rospy.Subscriber('array/state', ArrayState, self.receive, queue_size=100)
        self.stream = Stream()
        self.addCleanup(self.stream.stop)
        self.words = open(os.path.join(self.graph.folder, 'words'), 'w+b')
        self.addCleanup(self.words.close)

    def receive(self, state):
        self.states.setdefault(state._connection_header['callerid'], []).append((time.monotonic(), state))

    def emitting(self, node):
        """Whether it has emitted in the last quarter of a second."""
        recent = [state for when, state in self.states.get(node, []) if when > time.monotonic() - 0.25]
        return bool(recent) and recent[-1].emitting

    def expect_sound(self, nodes):
        wait_until(lambda: all(self.emitting(node) for node in nodes), 30, 'a sound of ' + ', '.join(nodes))

    def expect_silence(self, what, nodes, reason):
        """`what` silences the nodes with that reason within a second, and nothing but them."""
        since = time.monotonic()
        what()
        wait_until(lambda: not any(self.emitting(node) for node in nodes), 5, 'silence of all')
        time.sleep(0.5)
        for node in nodes:
            last = max(when for when, state in list(self.states[node]) if state.emitting)
            print('%s: %s is silent after %.0f ms' % (reason, node, 1e3 * (last - since)))
            self.assertLess(last - since, LIMIT + SLACK, node)
            self.assertIn(reason, self.states[node][-1][1].silent_reason)
        self.assertTrue(self.emitting(ALONE) or ALONE in nodes)

    def start(self, command):
        return self.graph.start(command, stdout=self.words, stderr=subprocess.STDOUT)

    def said(self):
        self.words.seek(0)
        return self.words.read().decode(errors='replace')

    def test_story(self):
        master, = self.graph.processes
        path = os.path.join(self.graph.folder, 'arrays.launch')
        with open(path, 'w') as launch:
            launch.write(LAUNCH)
        roslaunch = self.start(['roslaunch', '--screen', path])
        nodes = SUPERVISED + [ALONE]
        self.expect_sound(nodes)

        # A machine that is busy loses nobody.
        with subprocess.Popen([sys.executable, '-c', 'while True: pass']) as one, \
                subprocess.Popen([sys.executable, '-c', 'while True: pass']) as two:
            since = time.monotonic()
            time.sleep(3.0)
            one.kill()
            two.kill()
        missed = [state.silent_reason for node in nodes for when, state in self.states[node]
                  if when > since and ('master' in state.silent_reason or 'roslaunch' in state.silent_reason)]
        self.assertEqual(missed, [])

        self.expect_silence(lambda: master.send_signal(signal.SIGSTOP), SUPERVISED, 'the master')
        master.send_signal(signal.SIGCONT)
        self.expect_sound(nodes)
        self.expect_silence(lambda: roslaunch.send_signal(signal.SIGSTOP), SUPERVISED, 'frozen')
        roslaunch.send_signal(signal.SIGCONT)
        self.expect_sound(nodes)
        # A node that was started by hand has no roslaunch to lose.
        by_hand = self.start([PROGRAM, '__name:=by_hand', '_device:=debug'])
        self.expect_sound(nodes + ['/by_hand'])
        orphans = subprocess.run(['ps', '-o', 'pid=', '--ppid', str(roslaunch.pid)], stdout=subprocess.PIPE, check=True,
                                 universal_newlines=True).stdout.split()
        self.addCleanup(lambda: [os.kill(int(pid), signal.SIGKILL) for pid in orphans])
        self.expect_silence(roslaunch.kill, SUPERVISED, 'is dead')
        self.expect_sound([ALONE, '/by_hand'])
        self.expect_silence(master.kill, ['/by_hand'], 'the master')
        master.wait()
        self.assertTrue(self.emitting(ALONE))
        self.assertIn('the array goes on, as ~supervisors says', self.said())
        # Another master at the same address knows nobody.
        self.start(['rosmaster', '--core', '-p', str(self.graph.port)])
        wait_until(lambda: 'does not know this node' in self.states['/by_hand'][-1][1].silent_reason, 10,
                   'a word of the new master')
        self.assertTrue(self.emitting(ALONE))
        self.assertIsNone(by_hand.poll())


class WrongUse(unittest.TestCase):
    def test_an_unknown_supervisor(self):
        with rig_run.Graph() as graph:
            done = subprocess.run([PROGRAM, '_device:=debug', '_supervisors:=everybody'], stdout=subprocess.PIPE,
                                  stderr=subprocess.STDOUT, timeout=20, check=False, errors='replace',
                                  env=graph.environment)
        self.assertEqual(done.returncode, 1)
        self.assertIn("unknown 'everybody', expected roslaunch, master", done.stdout)


if __name__ == '__main__':
    rig_run.main('supervisors')
