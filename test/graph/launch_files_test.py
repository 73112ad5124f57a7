#!/usr/bin/env python3
"""roslaunch-check of each launch file: see launch_files.test."""
import glob
import os
import unittest

import roslaunch.rlutil

import rig_run

FOLDER = os.path.join(rig_run.PACKAGE, 'launch')


class LaunchFiles(unittest.TestCase):
    def test_roslaunch_check(self):
        files = sorted(glob.glob(os.path.join(FOLDER, '*.launch')))
        self.assertIn(os.path.join(FOLDER, 'rig.launch'), files)
        for path in files:
            with self.subTest(os.path.basename(path)):
                # Arguments without a default, such as a bag to show, are the caller's.
                self.assertIsNone(roslaunch.rlutil.check_roslaunch(path, ignore_unset_args=True))

    def test_each_argument_of_the_rig_is_documented(self):
        with open(os.path.join(FOLDER, 'rig.launch')) as launch:
            arguments = [line for line in launch if line.startswith('  <arg name=')]
        self.assertGreater(len(arguments), 20)
        for line in arguments:
            self.assertIn('doc="', line)


if __name__ == '__main__':
    rig_run.main('launch_files')
