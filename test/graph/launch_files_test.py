#!/usr/bin/env python3
"""roslaunch-check of each launch file: see launch_files.test."""
import glob
import os
import shutil
import tempfile
import unittest
from unittest import mock

import roslaunch.config
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

    def test_files_are_named_from_the_folder_of_the_user(self):
        with tempfile.TemporaryDirectory() as folder:
            shutil.copy(rig_run.bag('no_hands'), os.path.join(folder, 'mine.bag'))
            shutil.copy(os.path.join(rig_run.PACKAGE, 'config', 'scenes', 'press.yaml'), os.path.join(folder, 'mine.yaml'))
            score = os.path.join(rig_run.PACKAGE, 'config', 'hands', 'tour.yaml')
            shutil.copy(score, os.path.join(folder, 'score.yaml'))
            for hands, file, scene, expected_file, expected_scene in (
                    ('bag', 'mine.bag', './mine.yaml', folder + '/mine.bag', folder + '/./mine.yaml'),
                    ('bag', folder + '/mine.bag', 'press', folder + '/mine.bag', 'press'),
                    ('choreography', 'tour', 'mine.yaml', 'tour', folder + '/mine.yaml'),
                    ('choreography', 'score.yaml', 'press', folder + '/score.yaml', 'press')):
                with self.subTest(hands=hands, file=file, scene=scene), mock.patch.dict(os.environ, PWD=folder):
                    arguments = ['hands:=' + hands, 'file:=' + file, 'scene:=' + scene, 'rviz:=false']
                    config = roslaunch.config.load_config_default([(os.path.join(FOLDER, 'rig.launch'), arguments)], 11311,
                                                                  verbose=False)
                    self.assertEqual(config.params['/hand_tracking/file'].value, expected_file)
                    self.assertEqual(config.params['/clay_simulator/scene'].value, expected_scene)


if __name__ == '__main__':
    rig_run.main('launch_files')
