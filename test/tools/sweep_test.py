#!/usr/bin/env python3
"""Sweeps of speed_accuracy: sweep_test.py PROGRAM SHARE_FOLDER CLASS, where CLASS is Sweep or Axes."""
import csv
import os
import subprocess
import sys
import tempfile
import unittest

PROGRAM, SHARE, CLASS = sys.argv[1:]
GRID = ['--scene', 'incline', '--share', SHARE, '--duration', '0.1', '--substeps', '1,2', '--iterations', '2',
        '--solver', 'minimise', '--reference', 'minimise:2x4', '--threads', '1']
PLAYS = 2 + 5  # settings, and the reference, with half its step, and that aside along three axes


def sweep(*options):
    return subprocess.run([PROGRAM, *GRID, *options], capture_output=True, text=True, timeout=100, check=False)


def played(run):
    return run.stderr.count(' incline minimise:')


class Sweep(unittest.TestCase):
    """Stopped, shared and merged."""

    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.outcomes = os.path.join(self.folder.name, 'outcomes')

    def rows(self, *options):
        """The CSV without times, which differ, and the run."""
        path = os.path.join(self.folder.name, 'rows.csv')
        run = sweep('--csv', path, *options)
        self.assertEqual(run.returncode, 0, run.stderr)
        with open(path, newline='') as file:
            return [{key: value for key, value in row.items() if 'ms' not in key.split('_')}
                    for row in csv.DictReader(file)], run

    def test_shards_merge_to_the_table_of_one_run(self):
        whole, run = self.rows()
        self.assertEqual((len(whole), played(run)), (PLAYS, PLAYS))
        counts = []
        for shard in ('1/2', '2/2'):
            run = sweep('--outcomes', self.outcomes, '--shard', shard)
            self.assertEqual((run.returncode, run.stdout), (0, ''), run.stderr)
            counts.append(played(run))
        self.assertEqual(sorted(counts), [3, 4])
        merged, run = self.rows('--outcomes', self.outcomes, '--merge', 'yes')
        self.assertEqual(played(run), 0)
        self.assertEqual(merged, whole)

    def test_goes_on_where_it_was_stopped(self):
        sweep('--outcomes', self.outcomes, '--shard', '1/2')
        _, run = self.rows('--outcomes', self.outcomes)
        self.assertEqual(played(run), 3)
        self.assertIn('s left: incline', run.stderr)

    def test_what_is_missing_or_of_something_else_is_one_line(self):
        run = sweep('--outcomes', self.outcomes, '--merge', 'yes')
        self.assertEqual(run.returncode, 1)
        self.assertRegex(run.stderr, r"^speed_accuracy: outcome '.*incline_none_5mm_minimise_2x4.outcome' is missing")
        sweep('--outcomes', self.outcomes)
        run = sweep('--outcomes', self.outcomes, '--merge', 'yes', '--duration', '0.15')
        self.assertEqual(run.returncode, 1)
        self.assertIn('or is not the outcome of', run.stderr)

    def test_wrong_options_are_one_line(self):
        for options, words in ((('--hand', 'dead'), "--hand 'dead': expected kinematic or soft"),
                               (('--render', 'lines:3'), "--render 'lines:3': expected points:N or field:N"),
                               (('--render', 'field:3'), 'expected 1, 2, 4 or 8 patterns'),
                               (('--shard', '3/2', '--outcomes', self.outcomes),
                                "--shard '3': expected a number from 1 to 2"),
                               (('--shard', '1'), "--shard '1': expected I/N"),
                               (('--shard', '1/2'), 'need a folder: --outcomes')):
            run = sweep(*options)
            self.assertEqual(run.returncode, 1)
            self.assertIn(words, run.stderr)
            self.assertEqual(run.stderr.count('\n'), 1)


class Axes(unittest.TestCase):
    """Not run with sanitizers: each play makes the flesh of soft hands anew, which takes minutes there."""

    def test_skin_material_hand_and_rendering_are_axes(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        path = os.path.join(folder.name, 'rows.csv')
        axes = ['--material', 'putty', '--hand', 'kinematic,soft', '--skin', '0.01,0.014', '--render',
                'points:2,field:1']
        run = subprocess.run([PROGRAM, '--scene', 'kindergarten', '--hands', 'knead', '--share', SHARE, '--duration',
                              '2.6',
                              '--spacing', '0.01', '--substeps', '1', '--iterations', '4', '--solver', 'minimise',
                              '--reference', 'minimise:1x4', *axes, '--threads', '1', '--csv', path],
                             capture_output=True, text=True, timeout=200, check=False)
        self.assertEqual(run.returncode, 0, run.stderr)
        with open(path, newline='') as file:
            rows = list(csv.DictReader(file))
        settings = [row for row in rows if row['role'] == 'setting']
        self.assertEqual([(row['hand'], row['skin_m'], row['rendering']) for row in settings],
                         [(hand, skin, rendering) for hand in ('kinematic', 'soft') for skin in ('0.01', '0.014')
                          for rendering in ('points:2', 'field:1')])
        self.assertEqual({row['material'] for row in rows}, {'putty'})
        force = {(row['hand'], row['skin_m']): float(row['mean_force_N']) for row in settings}
        self.assertEqual(len(set(force.values())), 4)
        for skin in ('0.01', '0.014'):  # the clay holds a soft hand back
            self.assertTrue(0.0 < force['soft', skin] < force['kinematic', skin], force)
        for row in settings:
            self.assertTrue(0.0 < float(row['pressure_error']) < 1.0, row['pressure_error'])
            self.assertGreater(float(row['ms_rendering']), 0.0)


if __name__ == '__main__':
    unittest.main(argv=[sys.argv[0], CLASS])
