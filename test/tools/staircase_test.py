#!/usr/bin/env python3
"""QUEST, and the tool that asks by it, with observers whose threshold is known: staircase_test.py SCRIPTS_FOLDER."""
import math
import os
import random
import subprocess
import sys
import tempfile
import unittest

SCRIPTS = sys.argv[1]
sys.path.insert(0, SCRIPTS)
from quest import Quest, right_answers  # noqa: E402  pylint: disable=wrong-import-position


def observed(threshold, trials, generator):
    staircase = Quest(math.log10(0.4), 0.5)
    for _ in range(trials):
        strength = staircase.next()
        staircase.update(strength, generator.random() < right_answers(strength, threshold))
    return staircase.estimate()


class Staircase(unittest.TestCase):
    def test_psychometric_function_is_that_of_the_paper(self):
        # Watson & Pelli 1983: a Weibull function between the share of guesses and that without slips.
        self.assertAlmostEqual(right_answers(0.3, 0.3), 0.005 + 0.99 * (1 - 0.5 * math.exp(-1)), 12)
        self.assertAlmostEqual(right_answers(-5, 0), 0.5, 6)
        self.assertAlmostEqual(right_answers(5, 0), 0.995, 6)

    def test_finds_the_threshold_of_simulated_observers(self):
        """Within one deviation of what is thought at first, 0.13 to 1.3 mN, hundred observers each: no bias beyond 0.6
        dB (0.03 in log10), a deviation of at most 2.4 dB (0.12), and as large as it tells itself."""
        for threshold in (math.log10(0.13), math.log10(0.4), math.log10(1.3)):
            generator = random.Random(5)
            found = [observed(threshold, 40, generator) for _ in range(100)]
            errors = [mean - threshold for mean, _ in found]
            bias = sum(errors) / len(errors)
            deviation = math.sqrt(sum((error - bias) ** 2 for error in errors) / len(errors))
            told = sum(deviation for _, deviation in found) / len(found)
            self.assertLess(abs(bias), 0.03, threshold)
            self.assertLess(deviation, 0.12, threshold)
            self.assertTrue(0.6 < deviation / told < 1.6, (deviation, told))

    def test_more_trials_know_more(self):
        generator = random.Random(6)
        few, many = ([observed(0.0, trials, generator)[1] for _ in range(30)] for trials in (15, 60))
        self.assertLess(sum(many), 0.65 * sum(few))

    def run_tool(self, *words):
        return subprocess.run([sys.executable, os.path.join(SCRIPTS, 'staircase'), *words], capture_output=True,
                              text=True,
                              stdin=subprocess.DEVNULL, timeout=60, check=False)

    def test_the_tool_writes_what_the_renderer_reads(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, 'person.yaml')
            run = self.run_tool(path, '--simulate', '0.8', '--seed', '3', '--trials', '60')
            self.assertEqual(run.returncode, 0, run.stderr)
            with open(path) as file:
                lines = [line.split('#')[0].strip() for line in file]
            values = dict(line.split(': ') for line in lines if line)
            self.assertEqual(sorted(values), ['felt_gain', 'felt_threshold'])
            self.assertLess(abs(math.log10(float(values['felt_threshold']) / 0.8)), 0.25)
            self.assertAlmostEqual(float(values['felt_gain']), float(values['felt_threshold']) / 0.4, delta=1e-3)
            again = self.run_tool(path, '--simulate', '0.8')
            self.assertEqual(again.returncode, 1)
            self.assertIn('exists already', again.stderr)

    def test_wrong_words_are_told_in_one_line(self):
        self.assertIn('--trials is 0, expected 1 to 1000', self.run_tool('x.yaml', '--trials', '0').stderr)
        self.assertIn('--simulate is 1e+06', self.run_tool('x.yaml', '--simulate', '1e6').stderr)


if __name__ == '__main__':
    unittest.main(argv=sys.argv[:1])
