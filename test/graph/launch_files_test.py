#!/usr/bin/env python3
"""roslaunch-check of each launch file: see launch_files.test."""
import contextlib
import glob
import os
import shlex
import shutil
import tempfile
import unittest
from unittest import mock

import roslaunch.config
import roslaunch.rlutil

import rig_run

VARIANTS = ((), ('lockstep:=true',), ('device:=debug', 'skeleton:=true', 'record:=true'),
            ('wire:=/tmp/boards', 'device:=sonic_surface', 'nodelets:=true'))
FOLDER = os.path.join(rig_run.PACKAGE, 'launch')


def load(*arguments):
    """The launch of the rig with these arguments, not started."""
    return roslaunch.config.load_config_default([(os.path.join(FOLDER, 'rig.launch'), ['rviz:=false', *arguments])],
                                                11311,
                                                verbose=False)


@contextlib.contextmanager
def working_directory(folder):
    before = os.getcwd()
    os.chdir(folder)
    try:
        yield
    finally:
        os.chdir(before)


class LaunchFiles(unittest.TestCase):
    def test_roslaunch_check(self):
        files = sorted(glob.glob(os.path.join(FOLDER, '*.launch')))
        self.assertIn(os.path.join(FOLDER, 'rig.launch'), files)
        files.remove(os.path.join(FOLDER, 'node.launch'))  # a part of rig.launch, which is checked with it
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
            shutil.copy(os.path.join(rig_run.PACKAGE, 'config', 'scenes', 'press.yaml'),
                        os.path.join(folder, 'mine.yaml'))
            score = os.path.join(rig_run.PACKAGE, 'config', 'hands', 'tour.yaml')
            shutil.copy(score, os.path.join(folder, 'score.yaml'))
            for hands, file, scene, expected_file, expected_scene in (
                    ('bag', 'mine.bag', './mine.yaml', folder + '/mine.bag', folder + '/./mine.yaml'),
                    ('bag', folder + '/mine.bag', 'press', folder + '/mine.bag', 'press'),
                    ('choreography', 'tour', 'mine.yaml', 'tour', folder + '/mine.yaml'),
                    ('choreography', 'score.yaml', 'press', folder + '/score.yaml', 'press')):
                with self.subTest(hands=hands, file=file, scene=scene), mock.patch.dict(os.environ, PWD=folder):
                    arguments = ['hands:=' + hands, 'file:=' + file, 'scene:=' + scene]
                    config = load(*arguments)
                    self.assertEqual(config.params['/hand_tracking/file'].value, expected_file)
                    self.assertEqual(config.params['/clay_simulator/scene'].value, expected_scene)


    def test_a_rig_of_the_user_stands_for_that_of_the_package(self):
        with tempfile.TemporaryDirectory() as folder, mock.patch.dict(os.environ, PWD=folder):
            with open(os.path.join(folder, 'my rig.yaml'), 'w') as rig:
                rig.write('tracker_pose: [0, 0, -0.1, 0, 0, 0]\ntemperature: 23.5\npressure_cap: 1500.0\n'
                          'full_scale_pressure: 200000.0\nposition_beta: 50.0\nhead_spl_cap: 100.0\n')
            params = load('rig:=my rig.yaml', 'head_spl_cap:=95').params
            for name, expected in (('hand_tracking/tracker_pose', [0, 0, -0.1, 0, 0, 0]),
                                   ('hand_tracking/position_beta', 50.0),
                                   ('simulated_array/temperature', 23.5),
                                   ('simulated_array/array_pose', [0, 0, -0.15, 0, 0, 0]),  # of the package
                                   ('simulated_array/pressure_cap', 1500.0),
                                   ('simulated_array/head_spl_cap', 95),
                                   ('focal_point_renderer/full_scale_pressure', 200000.0),
                                   ('focal_point_renderer/max_points', 8)):
                self.assertEqual(params['/' + name].value, expected, name)

    def test_numbers_may_have_an_exponent(self):
        given = {'hand_tracking/rate': '1e0', 'hand_tracking/prediction': '5e-3', 'hand_tracking/duration': '1e1',
                 'clay_simulator/target_ms': '8e0', 'simulated_array/head_spl_cap': '1e2'}
        params = load(*(name.split('/')[1] + ':=' + text for name, text in given.items())).params
        for name, text in given.items():
            self.assertIsInstance(params['/' + name].value, float, name)
            self.assertEqual(params['/' + name].value, float(text), name)
        for name in ('clay_simulator/substeps', 'clay_simulator/iterations', 'clay_simulator/threads',
                     'focal_point_renderer/max_points', 'simulated_array/phase_levels'):
            self.assertIs(type(params['/' + name].value), int, name)

    def test_the_sound_is_a_field_where_the_array_takes_phases(self):
        for device, array, expected in (('simulated', 'simulated_array', 'field'),
                                        ('sonic_surface', 'array_driver', 'field'),
                                        ('debug', 'array_driver', 'am')):
            params = load('device:=' + device, 'port:=/dev/nowhere').params
            self.assertEqual(params['/focal_point_renderer/modulation'].value, expected, device)
            self.assertEqual(params['/%s/modulation' % array].value, expected, device)
            self.assertEqual(params['/contact_pressure/around'].value, 0.06 if expected == 'field' else 0.0)

    def test_a_person_is_known_to_the_renderer(self):
        with tempfile.TemporaryDirectory() as folder, mock.patch.dict(os.environ, PWD=folder):
            with open(os.path.join(folder, 'anna.yaml'), 'w') as person:
                person.write('felt_threshold: 0.6  # mN\nfelt_gain: 1.5\n')
            params = load('person:=anna.yaml').params
            self.assertEqual(params['/focal_point_renderer/felt_threshold'].value, 0.6)
            self.assertEqual(params['/focal_point_renderer/felt_gain'].value, 1.5)
            self.assertNotIn('/simulated_array/felt_gain', params)

    def test_a_target_has_the_quality_chosen(self):
        for arguments, expected in (([], 'balanced'), (['target_ms:=5'], 'auto'),
                                    (['target_ms:=5', 'quality:=fast'], 'fast')):
            self.assertEqual(load(*arguments).params['/clay_simulator/quality'].value, expected, arguments)

    def test_files_may_have_any_name(self):
        for name in ("Anna's hands", 'cost $(5)', '$(arg scene)', '$HOME', 'a; b & c', '"quoted" ~', 'G\u00e4nge', '-d',
                     "it''s \\\\'"):
            with self.subTest(name), tempfile.TemporaryDirectory() as parent:
                folder = os.path.join(parent, name)
                os.mkdir(folder)
                shutil.copy(rig_run.bag('no_hands'), os.path.join(folder, name + '.bag'))
                shutil.copy(os.path.join(rig_run.PACKAGE, 'config', 'scenes', 'press.yaml'),
                            os.path.join(folder, name + '.yaml'))
                for given, expected in (('./', folder + '/./'), ('~/', folder + '/')):
                    with mock.patch.dict(os.environ, PWD=folder, HOME=folder), working_directory(folder):
                        config = load('file:=%s.bag' % (given + name), 'scene:=%s.yaml' % (given + name),
                                      'record:=%snew %s.bag' % (given, name))
                    self.assertEqual(config.params['/hand_tracking/file'].value, expected + name + '.bag')
                    self.assertEqual(config.params['/clay_simulator/scene'].value, expected + name + '.yaml')
                    self.assertEqual(config.params['/record/bag'].value, '%snew %s.bag' % (expected, name))

    @staticmethod
    def prefix(variant, node):
        """What stands before a program. A recording is not started again, nor is anything in lockstep."""
        kept = 'lockstep:=true' not in variant and node.name not in ('record', 'describe_rig')
        return ['unless_running'] + (['keep_running'] if kept else []) + (['--again'] if node.package == 'nodelet'
                                                                          else [])

    def test_no_node_reads_what_an_earlier_run_left_or_takes_the_name_of_another(self):
        for variant in VARIANTS:
            with self.subTest(variant):
                config = load(*variant)
                self.assertGreater(len(config.nodes), 6)
                for node in config.nodes:
                    if node.type == 'rig_view':
                        continue
                    self.assertIn('/%s/' % node.name, config.clear_params)
                    words = shlex.split(node.launch_prefix)
                    self.assertEqual([os.path.basename(word) for word in words], self.prefix(variant, node), node.name)
                    self.assertIn(['/tf', 'tf'], node.remap_args, node.name)
                    self.assertIn(['/tf_static', 'tf_static'], node.remap_args, node.name)

    def test_names_of_nodes_are_not_taken_from_arguments(self):
        # Those of node.launch have plain names, which a launch file that includes the rig may have as well.
        names = lambda config: sorted((node.name, node.type) for node in config.nodes)
        self.assertEqual(names(load('name:=mine', 'type:=mine', 'node:=mine')), names(load()))


if __name__ == '__main__':
    rig_run.main('launch_files')
