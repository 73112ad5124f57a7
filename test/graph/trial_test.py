#!/usr/bin/env python3
"""Sessions of trials: see trial.test."""
import csv
import hashlib
import math
import os
import random
import shutil
import signal
import statistics
import struct
import subprocess
import sys
import tempfile
import unittest

import rosbag
import rospy
import yaml
from sensor_msgs.msg import PointCloud2, PointField
from std_msgs.msg import Header, String
from tactile_clay.msg import ArrayState, TrackedHands

import rig_run

sys.path.insert(0, os.path.join(rig_run.PACKAGE, 'scripts'))
from rig_tools import Fault, run_rig
from trial_plan import Plan, Staircase
from trial_summary import Summary, trim

TRIAL = os.path.join(rig_run.build_space(), 'devel', 'lib', 'tactile_clay', 'trial')
PLAN = """session: softness
participant: p01
seed: 7
duration: 0.4
start: at_once
bag: {skin: false, compression: lz4}
rig: {hands: bag, file: hands.bag, scene: press, quality: fast, lockstep: true}
blocks:
  - name: materials
    start: ask
    instruction: Press the block.
    conditions:
      - {name: soft, material: putty}
      - {name: hard, material: dough}
  - name: gain
    answers: ['yes', 'no']
    staircase: {key: focal_point_renderer/full_scale_pressure, scale: log, start: 4e5, low: 1e5, high: 1e6,
                steps: [2], detected: 'yes', harder: up, trials: 2}
"""
SIDE, REGION = 1, 9  # right hand, bone of the index finger that begins at its distal joint


def cloud(stamp, points):
    names = ('x', 'y', 'z', 'fx', 'fy', 'fz', 'index', 'vx', 'vy', 'vz', 'hand', 'region', 'area')
    whole = ('index', 'hand', 'region')
    fields = [PointField(name, 4 * k, PointField.UINT32 if name in whole else PointField.FLOAT32, 1)
              for k, name in enumerate(names)]
    code = '<' + ''.join('I' if name in whole else 'f' for name in names)
    step = 4 * len(names)
    return PointCloud2(header=Header(stamp=stamp, frame_id='world'), height=1, width=len(points), fields=fields,
                       point_step=step, row_step=step * len(points), is_dense=True,
                       data=b''.join(struct.pack(code, *point) for point in points))


class Plans(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.mkdtemp(prefix='trial_test_')
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)
        shutil.copy(rig_run.bag('press_finger'), os.path.join(self.folder, 'hands.bag'))

    def plan(self, text=PLAN):
        path = os.path.join(self.folder, 'plan.yaml')
        with open(path, 'w') as file:
            file.write(text)
        return Plan(path, rig_run.PACKAGE)

    def test_what_is_wrong_is_told_with_its_line(self):
        for old, new, line, words in (
                ('seed: 7', 'seed: -7', 3, "'seed' is -7, expected a whole number from 0"),
                ('seed: 7', 'seed: 7\nseed: 8', 4, "the key 'seed' comes twice"),
                ('seed: 7', 'seeds: 7', 3, "unknown key 'seeds', expected one of answers, bag, blocks"),
                ('p01', '../p01', 2, "'participant' is '../p01', expected a name of letters"),
                ('session: softness\n', '', 1, "'session' is missing"),
                ('duration: 0.4\n', '', 8, "'blocks[0].duration' is missing, expected the duration"),
                ('material: dough', 'matter: dough', 14, "unknown key 'matter', expected NODE/parameter or an"),
                ('material: dough', 'record: a.bag', 14, "'record' is given by the session, expected it as 'bag'"),
                ('name: hard', 'name: soft', 14, "two conditions of block 'materials' are both called 'soft'"),
                ('lz4', 'zip', 6, "'bag.compression' is 'zip', expected one of none, lz4, bz2"),
                ('skin: false', 'skin: 0', 6, "'bag.skin' is 0, expected true or false"),
                ("detected: 'yes'", 'detected: maybe', 18, "'blocks[1].staircase.detected' is 'maybe', expected"),
                ('steps: [2]', 'steps: [0.5]', 18, 'expected numbers above 1'),
                ('start: 4e5', 'start: 4e7', 17, "'blocks[1].staircase.start' is 4e+07, expected it from 'low'"),
                ("['yes', 'no']", "['no', 'never']", 16, 'expected texts that begin with different letters'),
                ('name: gain', 'name: materials', 15, "'blocks[1].name' is 'materials', which another block has"),
                ('blocks:', 'blocks: [', 9, 'expected YAML')):
            with self.subTest(words), self.assertRaises(Fault) as caught:
                self.assertIn(old, PLAN)
                self.plan(PLAN.replace(old, new, 1))
            self.assertRegex(str(caught.exception), r'plan.yaml:%d: ' % line)
            self.assertIn(words, str(caught.exception))
            self.assertNotIn('\n', str(caught.exception))

    def test_no_file_is_read_for_ever(self):
        def refused(path, words):
            with self.assertRaises(Fault) as caught:
                Plan(path, rig_run.PACKAGE)
            self.assertIn(words, str(caught.exception))
            self.assertIn(path, str(caught.exception))

        pipe = os.path.join(self.folder, 'pipe.yaml')
        os.mkfifo(pipe)
        refused(pipe, 'is not a regular file')
        large = os.path.join(self.folder, 'large.yaml')
        with open(large, 'wb') as file:
            file.truncate((16 << 20) + 1)
        refused(large, 'expected at most 16777216')
        lists = ''.join('k%d: &k%d [%s]\n' % (k, k, ', '.join(['*k%d' % (k - 1)] * 10)) for k in range(1, 9))
        for text, words in (('[' * 100000, 'hundreds of levels deep'),
                            (PLAN + 'k0: &k0 [x]\n' + lists, 'more than 200000 values'),
                            ('blocks: &a [*a]\n', 'more than 200000 values')):
            with self.subTest(words), self.assertRaises(Fault) as caught:
                self.plan(text)
            self.assertIn(words, str(caught.exception))

    def test_the_rig_is_asked_about_every_condition(self):
        self.plan().check_rig(os.environ)
        for old, new, line, words in (
                ('material: dough', 'material: granite', 14, "condition 'hard': material 'granite' not found"),
                ('material: dough', 'max_points: 0', 14, "max_points '0': expected a number from 1"),
                ('key: focal_point_renderer/full', 'key: focal_point_renderer/half', 15,
                 "parameter 'focal_point_renderer/half_scale_pressure' is not known, expected one of"),
                ('material: dough', 'clay_simulator/modelling_clay/viscosity: -1', 14,
                 "parameter 'clay_simulator/modelling_clay/viscosity'"),
                ('material: dough', 'clay/viscosity: 1', 14, "unknown node 'clay', expected one of"),
                ('quality: fast', 'quality: best', 13, "quality 'best' not found")):
            with self.subTest(words), self.assertRaises(Fault) as caught:
                self.plan(PLAN.replace(old, new, 1)).check_rig(os.environ)
            self.assertIn('plan.yaml:%d: block ' % line, str(caught.exception))
            self.assertIn(words, str(caught.exception))

    def test_the_order_comes_from_the_seed(self):
        text = PLAN.replace('    conditions:', '    repetitions: 20\n    practice: 3\n    conditions:', 1)
        order = self.plan(text).order()['materials']
        self.assertEqual(order, self.plan(text).order()['materials'])
        self.assertNotEqual(order, self.plan(text.replace('seed: 7', 'seed: 8')).order()['materials'])
        self.assertEqual([one['practice'] for one in order], [True] * 3 + [False] * 40)
        names = [one['condition'] for one in order[3:]]
        for k in range(20):  # each repetition has each condition
            self.assertEqual(sorted(names[2 * k:2 * k + 2]), ['hard', 'soft'])
        self.assertGreater(len({tuple(names[2 * k:2 * k + 2]) for k in range(20)}), 1)

    def test_factors_are_crossed(self):
        start, end = PLAN.index('    conditions:'), PLAN.index('  - name: gain')
        factors = '    factors: {material: [putty, dough], modulation: [am, stm], max_points: [1, 4, 8]}\n'
        block = self.plan(PLAN[:start] + factors + PLAN[end:]).blocks[0]
        self.assertEqual(len(block['conditions']), 12)
        self.assertEqual(block['conditions'][1]['name'], 'putty_am_4')
        self.assertEqual(block['conditions'][11]['settings']['max_points'], 8)
        self.assertEqual(block['conditions'][11]['settings']['scene'], 'press')


class Staircases(unittest.TestCase):
    """An observer who detects with a probability 1 / (1 + e^(-(x - m) / s)): that is p at x = m + s ln(p / (1 - p)).
    Levitt (1971), Table I: 1 up 2 down converge on p = 0.5^(1/2), 1 up 3 down on 0.5^(1/3)."""
    MIDDLE, SLOPE, RUNS = 10.0, 1.0, 400

    def thresholds(self, down, harder='down'):
        chance = random.Random(3)
        for _ in range(self.RUNS):
            start = 14.0 if harder == 'down' else 6.0
            stair = Staircase(dict(key='x', start=start, low=-100.0, high=100.0, down=down, up=1,
                                   steps=[2.0, 1.0, 0.5], harder=harder, scale='linear', reversals=24, trials=1000))
            while not stair.done():
                felt = stair.value - self.MIDDLE if harder == 'down' else self.MIDDLE - stair.value
                stair.take(chance.random() < 1.0 / (1.0 + math.exp(-felt / self.SLOPE)))
            yield stair.threshold()

    def expected(self, down):
        p = 0.5 ** (1.0 / down)
        return self.SLOPE * math.log(p / (1.0 - p))

    def test_they_find_the_threshold_of_a_simulated_observer(self):
        # Within half of the smallest step.
        for down in (2, 3):
            found = statistics.fmean(self.thresholds(down))
            self.assertAlmostEqual(found, self.MIDDLE + self.expected(down), delta=0.25)
        self.assertAlmostEqual(statistics.fmean(self.thresholds(2, 'up')), self.MIDDLE - self.expected(2), delta=0.25)

    def test_a_known_course(self):
        stair = Staircase(dict(key='x', start=8.0, low=1.0, high=16.0, steps=[4.0, 2.0], down=2, up=1, harder='down',
                               scale='log', reversals=3, trials=50))
        course = []
        for detected in (True, True, True, True, False, True, True, False):
            stair.take(detected)
            course.append(stair.value)
        # Down by 4; at the bound; the first reversal, from there by 2; down again; up.
        self.assertEqual(course, [8, 2, 2, 1, 2, 2, 1, 2])
        self.assertEqual(stair.reversals, [1, 2, 1])
        self.assertTrue(stair.done())
        self.assertAlmostEqual(stair.threshold(), math.sqrt(2.0))


class Summaries(unittest.TestCase):
    """A finger pushes with 2 N down at 0.1 m/s for a second: 0.2 J; another hand lies still with 1 N."""

    def setUp(self):
        self.folder = tempfile.mkdtemp(prefix='trial_test_')
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)
        self.bag = os.path.join(self.folder, 'run.bag')
        with rosbag.Bag(self.bag, 'w') as bag:
            for k in range(101):
                stamp = rospy.Time(1000 + k // 50, k % 50 * 20000000)
                points = [(0, 0, 0, 0, 0, 1.5, 7, 0, 0, -0.1, SIDE, REGION, 1e-4),
                          (0, 0, 0, 0, 0, 0.5, 8, 0, 0, -0.1, SIDE, REGION, 2e-4)]
                points = points if 0 < k <= 50 else []
                still = [(0, 0, 0, 0, 0.6, 0.8, 9, 0, 0, 0, 0, 0, 5e-4)]
                bag.write('/lab/hands/tracked', TrackedHands(header=Header(stamp=stamp)), stamp)
                bag.write('/lab/clay/contacts', cloud(stamp, points + (still if k > 50 else [])), stamp)
                state = ArrayState(header=Header(stamp=stamp), emitting=k > 50, head_spl=k, latency=1e-3 * k,
                                   frames_late=k // 40)
                bag.write('/lab/array/state', state, stamp)

    def test_numbers_of_a_known_run(self):
        told = dict(Summary(self.bag).rows())
        for name, expected in dict(
                seconds=2.0, right_index_contact_s=1.0, right_index_force_mean_N=2.0, right_index_force_max_N=2.0,
                right_index_area_mean_cm2=3.0, right_hand_force_max_N=2.0, right_thumb_contact_s=0.0,
                right_work_mJ=200.0, left_palm_contact_s=1.0, left_palm_force_mean_N=1.0, left_palm_area_max_cm2=5.0,
                left_work_mJ=0.0, work_mJ=200.0, head_level_max_dB=100.0, frames_emitting=50, frames_late=2,
                latency_p50_ms=50.0, latency_p99_ms=99.0).items():
            self.assertAlmostEqual(told[name], expected, delta=1e-4 * max(1.0, expected), msg=name)

    def test_a_part_of_a_bag(self):
        new = os.path.join(self.folder, 'part.bag')
        trim(self.bag, new, 0.5, 1.0)
        told = dict(Summary(new).rows())
        self.assertAlmostEqual(told['seconds'], 0.5, delta=1e-6)
        self.assertAlmostEqual(told['right_index_contact_s'], 0.5, delta=1e-6)
        for start, path, words in ((0.5, new, 'exists already'), (3.0, new + '2', 'is after its end')):
            with self.assertRaisesRegex(Fault, words):
                trim(self.bag, path, start, 4.0)


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
        rig_run.wait_until(there, 60, 'phase %s of trial %d' % (phase, number))

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
