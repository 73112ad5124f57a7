#!/usr/bin/env python3
"""What an install writes, what catkin_lint says, and what the scripts say of themselves: install_test.py
BUILD_FOLDER"""
import glob
import os
import shutil
import subprocess
import sys
import unittest

SOURCE = os.path.realpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), '..', '..'))
BUILD = os.path.abspath(sys.argv.pop())
PROGRAMS = os.path.join(BUILD, 'devel', 'lib', 'tactile_clay')


class Install(unittest.TestCase):
    def test_nothing_goes_elsewhere_than_into_the_prefix(self):
        """CMake lists what has an absolute destination, which `cmake --install --prefix` does not move."""
        scripts = glob.glob(os.path.join(BUILD, '**', 'cmake_install.cmake'), recursive=True)
        self.assertGreater(len(scripts), 5)
        installed = ''
        for path in scripts:
            with open(path) as script:
                text = script.read()
            self.assertFalse('CMAKE_ABSOLUTE_DESTINATION_FILES' in text, path)
            installed += text
        for name in ('setup.bash', '_setup_util.py', 'hand_tracking', 'replay', 'rig_view'):
            self.assertIn('/%s"' % name, installed)

    def test_catkin_lint(self):
        if shutil.which('catkin_lint') is None:
            self.skipTest('no catkin_lint')
        done = subprocess.run(['catkin_lint', '-q', SOURCE], stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                              text=True,
                              timeout=100, check=False)
        self.assertEqual([line for line in done.stdout.splitlines() if ' error: ' in line], [])
        self.assertEqual(done.returncode, 0, done.stdout)

    def test_each_script_tells_what_it_is(self):
        with open(os.path.join(SOURCE, 'cmake', 'ros.cmake')) as text:
            listed = text.read().split('catkin_install_python(PROGRAMS', 1)[1].split('DESTINATION')[0].split()
        self.assertGreater(len(listed), 5)
        for script in listed:
            with self.subTest(script):
                program = os.path.join(PROGRAMS, os.path.basename(script))  # as rosrun starts it
                done = subprocess.run([program, '--help'], stdin=subprocess.DEVNULL, capture_output=True, text=True,
                                      timeout=30,
                                      check=False)
                self.assertEqual((done.returncode, done.stderr), (0, ''))
                self.assertGreater(len(done.stdout), 40)
                # Else rosrun finds it twice, here and in the development space, and asks which one is meant.
                self.assertFalse(os.access(os.path.join(SOURCE, script), os.X_OK), 'is executable')
                self.assertTrue(os.access(program, os.X_OK))

    def test_each_tool_tells_what_it_is(self):
        tools = []
        for path in sorted(glob.glob(os.path.join(SOURCE, 'src', 'tools', '*.cpp'))):
            with open(path) as text:
                tools += [os.path.splitext(os.path.basename(path))[0]] if 'int main(' in text.read() else []
        self.assertGreater(len(tools), 10)
        for tool in tools:
            with self.subTest(tool):
                done = subprocess.run([os.path.join(PROGRAMS, tool), '--help'], stdin=subprocess.DEVNULL,
                                      capture_output=True,
                                      text=True, timeout=30, check=False)
                self.assertEqual((done.returncode, done.stderr), (0, ''))
                self.assertIn(tool, done.stdout)
                self.assertGreater(len(done.stdout), 80)


if __name__ == '__main__':
    unittest.main()
