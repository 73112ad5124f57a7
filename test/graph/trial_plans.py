"""Cases of trial_test.py that run no rig: plans and staircases. A module, no program."""
import math
import os
import random
import shutil
import statistics
import sys
import tempfile
import unittest

import rig_run

sys.path.insert(0, os.path.join(rig_run.PACKAGE, 'scripts'))
from rig_tools import Fault
from trial_plan import Plan
from trial_staircase import Staircase

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
