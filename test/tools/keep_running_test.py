#!/usr/bin/env python3
"""What keep_running starts again, and what it does not: keep_running_test.py PROGRAM"""
import os
import signal
import subprocess
import sys
import tempfile
import time
import unittest

PROGRAM = sys.argv.pop()
# Counts its starts in a file of the folder that is kept, and does what it is told for that start.
SCRIPT = '''
import os, signal, sys, time
path = os.path.join(os.environ['TACTILE_CLAY_KEPT'], 'starts')
with open(path, 'a') as file:
    file.write('x')
start = os.path.getsize(path)
beat = int(os.environ['TACTILE_CLAY_BEAT'])
print('start', start, os.getpid(), flush=True)
act = sys.argv[1].split(',')[start - 1]
if act == 'kill':
    os.kill(os.getpid(), signal.SIGKILL)
elif act == 'hang':  # after a sign of life
    os.write(beat, b'.')
    time.sleep(60)
elif act == 'busy':  # with none
    time.sleep(1.5)
elif act == 'stop':
    os.kill(os.getpid(), signal.SIGSTOP)
elif act == 'wait':
    signal.signal(signal.SIGINT, lambda *_: sys.exit(7))
    time.sleep(60)
else:
    sys.exit(int(act))
'''


class KeepRunning(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory(prefix='keep_running_')
        self.addCleanup(self.folder.cleanup)

    def start(self, acts, *options):
        return subprocess.Popen([PROGRAM, *options, '--patience', '0.4', sys.executable, '-c', SCRIPT, acts,
                                 '__name:=node',
                                 '__log:=' + os.path.join(self.folder.name, 'node.log')], stdin=subprocess.DEVNULL,
                                stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)

    def run_to_end(self, acts, *options):
        """(exit code, number of starts, lines of keep_running)"""
        process = self.start(acts, *options)
        out, words = process.communicate(timeout=30)
        self.assertEqual(os.listdir(self.folder.name), [], 'its folder goes with it')
        return process.returncode, out.count('start'), words.splitlines()

    def test_what_ends_by_itself_stays_ended(self):
        for code in (0, 1, 5):
            self.assertEqual(self.run_to_end(str(code)), (code, 1, []))

    def test_what_was_killed_or_is_frozen_is_started_again(self):
        code, starts, words = self.run_to_end('kill,hang,stop,busy')
        self.assertEqual((code, starts), (0, 4))
        self.assertEqual(words, ['tactile_clay: node was ended by signal 9 (Killed), and is started again',
                                 'tactile_clay: node was frozen, and is started again',
                                 'tactile_clay: node was frozen, and is started again'])

    def test_what_dies_again_and_again_is_given_up(self):
        code, starts, words = self.run_to_end(','.join(9 * ['kill']))
        self.assertEqual((code, starts, len(words)), (137, 6, 6))
        self.assertIn('for the 6th time within a minute, and is not started again', words[-1])

    def test_a_good_end_that_nobody_asked_for(self):
        code, starts, words = self.run_to_end('0,0,4', '--again')
        self.assertEqual((code, starts, len(words)), (4, 3, 2))
        self.assertIn('ended although nobody asked it to', words[0])

    def test_whoever_is_asked_to_end_ends(self):
        for acts, code in (('kill,wait', 7), ('kill,wait,0', 7)):
            process = self.start(acts, '--again')
            for _ in range(2):
                process.stdout.readline()
            time.sleep(0.3)
            process.send_signal(signal.SIGINT)
            self.assertEqual(process.wait(10), code)
            process.communicate()

    def test_without_its_keeper_nothing_goes_on(self):
        process = self.start('wait')
        pid = int(process.stdout.readline().split()[2])
        process.kill()
        process.communicate()
        deadline = time.monotonic() + 10
        while os.path.exists('/proc/%d' % pid) and time.monotonic() < deadline:
            time.sleep(0.05)
        self.assertFalse(os.path.exists('/proc/%d' % pid))

    def test_wrong_use(self):
        for arguments, words in (([], 'expected a program'), (['--patience', 'long', 'true'], "--patience 'long'"),
                                 (['--fast', 'true'], "unknown option '--fast'")):
            done = subprocess.run([PROGRAM, *arguments], capture_output=True, text=True, timeout=10, check=False)
            self.assertEqual((done.returncode, len(done.stderr.splitlines())), (1, 1))
            self.assertIn(words, done.stderr)


if __name__ == '__main__':
    unittest.main()
