#!/usr/bin/env python3
"""Sessions of trials: see trial.test."""
import csv
import hashlib
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import unittest

import rosbag
import rospy
import yaml
from std_msgs.msg import String

import rig_run
from trial_plans import PLAN, Plans, Staircases  # noqa: F401  pylint: disable=unused-import
from trial_summaries import Summaries  # noqa: F401  pylint: disable=unused-import

sys.path.insert(0, os.path.join(rig_run.PACKAGE, 'scripts'))
from rig_tools import Fault, run_rig

TRIAL = os.path.join(rig_run.build_space(), 'devel', 'lib', 'tactile_clay', 'trial')


class Rigs(unittest.TestCase):
    def test_a_trial_whose_chain_lost_a_node_is_none(self):
        with tempfile.TemporaryDirectory() as folder:
            def run(node):
                line = 'tactile_clay: %s was frozen, and is started again' % node
                run_rig(['echo', line], dict(os.environ), folder, os.path.join(folder, 'log'))
            with self.assertRaisesRegex(Fault, 'the run is not complete: .*clay_simulator was frozen'):
                run('clay_simulator')
            run('hand_surface')  # which is for the eye


class Sessions(unittest.TestCase):
    """A session, killed between and within trials, with an observer who answers."""

    @classmethod
    def setUpClass(cls):
        rospy.init_node('observer', disable_signals=True)

    def setUp(self):
        self.folder = tempfile.mkdtemp(prefix='trial_test_')
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)
        shutil.copy(rig_run.bag('press_finger'), os.path.join(self.folder, 'hands.bag'))
        self.plan = os.path.join(self.folder, 'plan.yaml')
        with open(self.plan, 'w') as file:
            file.write(PLAN)
        self.session = os.path.join(self.folder, 'softness', 'p01')
        self.words = os.path.join(self.folder, 'words')
        self.states, self.instructions = [], []
        self.answer = rospy.Publisher('trial/answer', String, queue_size=10)
        subscribers = [rospy.Subscriber('trial/state', String, lambda m: self.states.append(yaml.safe_load(m.data))),
                       rospy.Subscriber('trial/instruction', String, lambda m: self.instructions.append(m.data))]
        self.addCleanup(lambda: [one.unregister() for one in subscribers])

    def start(self):
        self.states.clear()
        words = open(self.words, 'ab')
        self.addCleanup(words.close)
        process = subprocess.Popen([TRIAL, self.plan], stdin=subprocess.DEVNULL, stdout=words, stderr=subprocess.STDOUT,
                                   start_new_session=True)
        self.addCleanup(lambda: process.poll() is None and process.kill())
        return process

    def said(self):
        with open(self.words) as words:
            return words.read()

    def until(self, phase, number, process):
        def there():
            self.assertIsNone(process.poll(), self.said())
            return any((state['phase'], state.get('trial')) == (phase, number) for state in self.states)
        try:
            rig_run.wait_until(there, 60, 'phase %s of trial %d' % (phase, number))
        except AssertionError as fault:
            raise AssertionError('%s; states: %s; said: %s' % (fault, self.states, self.said())) from None

    def kill(self, process):
        os.kill(process.pid, signal.SIGKILL)
        process.wait()

    def rows(self):
        with open(os.path.join(self.session, 'trials.csv'), newline='') as file:
            return list(csv.DictReader(file))

    def bags(self):
        return {name: hashlib.sha256(open(os.path.join(self.session, name), 'rb').read()).hexdigest()
                for name in os.listdir(self.session) if '.bag' in name}

    def test_a_session_that_is_killed_goes_on(self):
        process = self.start()
        self.until('waiting', 1, process)
        self.answer.publish('start')
        self.until('waiting', 2, process)
        self.kill(process)  # between
        self.assertEqual([row['trial'] for row in self.rows()], ['1'])
        first = self.bags()
        self.assertEqual(len(first), 1)
        process = self.start()
        self.until('waiting', 2, process)
        self.answer.publish('start')
        rig_run.wait_until(lambda: len(self.bags()) == 2, 60, 'a bag')
        self.kill(process)  # within
        process = self.start()
        self.until('waiting', 2, process)
        self.answer.publish('start')
        for number in (3, 4):
            self.until('answer', number, process)
            value = [state for state in self.states if state.get('trial') == number][-1]['value']
            self.answer.publish('perhaps')
            self.answer.publish('yes' if value < 6e5 else 'no')
        self.assertEqual(process.wait(60), 0, self.said())
        self.check(first)

    @staticmethod
    def tell(*words):
        return subprocess.run([TRIAL, *words], capture_output=True, text=True, timeout=60, check=True).stdout

    def check(self, first):
        rows = self.rows()
        self.assertEqual([row['trial'] for row in rows], ['1', '2', '3', '4'])
        self.assertEqual({row['condition'] for row in rows[:2]}, {'soft', 'hard'})
        self.assertEqual([row['answer'] for row in rows], ['', '', 'yes', 'yes'])
        self.assertEqual([float(row['focal_point_renderer/full_scale_pressure']) for row in rows[2:]], [4e5, 4e5])
        bags = self.bags()
        self.assertEqual({name: bags[name] for name in first}, first, 'overwritten')
        for row in rows:
            self.assertIn(row['bag'], bags)
            with rosbag.Bag(os.path.join(self.session, row['bag'])) as bag:
                self.assertEqual(bag.get_compression_info().compression, 'lz4')
                topics = bag.get_type_and_topic_info().topics
                self.assertNotIn('/hands/skin', topics)
                self.assertGreater(topics['/clay/contacts'].message_count, 20)
                told = [yaml.safe_load(m.data) for _, m, _ in bag.read_messages('/rig/description')]
                self.assertEqual(told[0]['parameters']['clay_simulator']['material'], row['material'])
        self.assertTrue([name for name in bags if '_unfinished_1.bag' in name], bags)
        self.assertIn('Press the block.', self.instructions)
        self.assertIn("answer 'perhaps' left out, expected yes or no", self.said())
        with open(os.path.join(self.session, 'order.yaml')) as file:
            self.assertEqual(yaml.safe_load(file)['seed'], 7)
        listed = self.tell('list', self.session)
        self.assertIn('session softness of p01, seed 7: 4 of at most 4 trials are done', listed)
        told = self.tell('summarise', self.session)
        self.assertEqual(len([line for line in told.splitlines() if 'work on the clay' in line]), 4)
        with open(self.plan, 'a') as plan:
            plan.write('# another one\n')
        done = subprocess.run([TRIAL, self.plan], stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=60,
                              check=False)
        self.assertEqual(done.returncode, 1)
        self.assertIn('is not the plan with which the session in', done.stderr)


if __name__ == '__main__':
    rig_run.main('trial')
