#!/usr/bin/env python3
"""The tool that finds a person's threshold: see staircase_graph.test."""
import math
import os
import subprocess
import sys
import tempfile
import threading
import unittest

import rospy
import yaml
from std_msgs.msg import String
from tactile_clay.msg import RenderingReport

import rig_run
from array_stream import Driver

STAIRCASE = os.path.join(rig_run.build_space(), 'devel', 'lib', 'tactile_clay', 'staircase')
THRESHOLD = 1.0  # mN, of the observer, who feels all that is above it and nothing below


def setUpModule():
    rospy.init_node('staircase_test')


class Observer:
    """Feels forces, reads what the tool says, and answers by its topic."""

    def __init__(self, process):
        self.process, self.forces, self.interval, self.lines = process, {1: 0.0, 2: 0.0}, 0, []
        self.lock = threading.Lock()
        self.answers = rospy.Publisher('staircase/answer', String, queue_size=1)
        self.subscriber = rospy.Subscriber('array/rendering', RenderingReport, self.feel)

    def feel(self, report):
        with self.lock:
            if self.interval:
                self.forces[self.interval] = max(self.forces[self.interval], report.force)

    def listen(self):
        for line in self.process.stdout:
            self.lines.append(line)
            word = line.strip()
            with self.lock:
                if word in ('1', '2'):
                    self.interval = int(word)
                elif word.startswith('In which interval'):
                    felt = {interval: force for interval, force in self.forces.items() if force > THRESHOLD}
                    # Who feels nothing says 1, which is right by chance.
                    self.answers.publish(String(data=str(max(felt, key=felt.get) if felt else 1)))
                    self.forces, self.interval = {1: 0.0, 2: 0.0}, 0


class Staircase(unittest.TestCase):
    def run_tool(self, *words):
        return subprocess.Popen([sys.executable, STAIRCASE, *words], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                                stderr=subprocess.STDOUT, text=True)

    def test_finds_the_threshold_of_an_observer_at_an_array(self):
        with tempfile.TemporaryDirectory() as folder, Driver('simulated_array'), Driver('focal_point_renderer'):
            path = os.path.join(folder, 'person.yaml')
            with self.run_tool(path, '--trials', '16', '--interval', '0.3', '--seed', '2') as tool:
                observer = Observer(tool)
                observer.listen()
            self.assertEqual(tool.returncode, 0, ''.join(observer.lines))
            with open(path) as file:
                person = yaml.safe_load(file)
            self.assertLess(abs(math.log10(person['felt_threshold'] / THRESHOLD)), 0.3, person)
            self.assertAlmostEqual(person['felt_gain'], person['felt_threshold'] / 0.4, delta=0.01)

    def test_says_what_is_missing(self):
        with self.run_tool('person.yaml') as tool:
            self.assertEqual(tool.communicate()[0], 'staircase: no focal_point_renderer or no array runs, expected '
                             'both\n')
        self.assertEqual(tool.returncode, 1)


if __name__ == '__main__':
    rig_run.main('staircase_graph')
