#!/usr/bin/env python3
"""Wrong arguments and damaged files: see bad_input.test."""
import gzip
import os
import subprocess
import unittest

import rosbag
import yaml
from std_msgs.msg import String

import rig_run

KINDERGARTEN = os.path.join(rig_run.PACKAGE, 'config', 'scenes', 'kindergarten.yaml')
PROGRAMS = os.path.join(rig_run.build_space(), 'devel', 'lib', 'tactile_clay')


class BadInput(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.graph = rig_run.Graph()
        cls.addClassCleanup(cls.graph.__exit__)
        cls.graph.__enter__()
        cls.script = rig_run.rig_script(os.path.join(cls.graph.folder, 'package'))

    def file(self, name, content):
        path = os.path.join(self.graph.folder, name)
        with open(path, 'wb') as out:
            out.write(content)
        return path

    def scene(self, change):
        with open(KINDERGARTEN) as text:
            scene = yaml.safe_load(text)
        change(scene)
        return self.file('changed.yaml', yaml.safe_dump(scene).encode())

    def run_to_end(self, command):
        """Exit code and lines of a program that has to end by itself."""
        done = subprocess.run(command, env=self.graph.environment, stdin=subprocess.DEVNULL, timeout=60,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, errors='replace', check=False)
        return done.returncode, [line for line in done.stdout.splitlines() if line.strip()]

    def expect_one_line(self, arguments, *expected):
        code, lines = self.run_to_end([self.script, 'rviz:=false'] + arguments)
        self.assertGreater(code, 0)
        self.assertEqual(len(lines), 1, '\n'.join(lines))
        for words in expected:
            self.assertIn(words, lines[0])

    def test_unknown_scene(self):
        self.expect_one_line(['scene:=sandbox'], 'sandbox', 'kindergarten', 'potters_wheel')

    def test_unknown_key_in_scene(self):
        def misspell(scene):
            scene['bodies'][0]['colour'] = scene['bodies'][0].pop('color')
        path = self.scene(misspell)
        self.expect_one_line(['scene:=' + path], path, 'colour', 'color')

    def test_wrong_value_in_scene(self):
        def negative(scene):
            scene['spacing'] = -0.005
        path = self.scene(negative)
        self.expect_one_line(['scene:=' + path], path, 'spacing')

    def test_unknown_material(self):
        def rename(scene):
            scene['bodies'][2]['material'] = 'granite'
        path = self.scene(rename)
        self.expect_one_line(['scene:=' + path], 'granite', 'modelling_clay')

    def test_scene_that_is_no_yaml(self):
        path = self.file('broken.yaml', b'bodies: [{name: red, \x00\x01')
        self.expect_one_line(['scene:=' + path], path)

    def test_robot_model_that_cannot_be_used(self):
        link = '<link name="world"><collision><geometry><mesh filename="none.stl"/></geometry></collision></link>'
        for name, inside, words in (('roots.urdf', '<link name="a"/><link name="b"/>', 'both roots'),
                                    ('names.urdf', '<link name="a&#10;b"/><link name="c"/>', 'a?b'),
                                    ('mesh.urdf', link, 'none.stl')):
            with self.subTest(name):
                path = self.file(name, ('<robot name="r">%s</robot>' % inside).encode())
                self.expect_one_line(['scene:=' + self.scene(lambda scene: scene.update(urdf=path))], path, words)

    def test_unknown_quality(self):
        self.expect_one_line(['quality:=perfect'], 'perfect', 'balanced')

    def test_quality_by_the_computer_in_lockstep(self):
        self.expect_one_line(['quality:=auto', 'lockstep:=true'], "quality 'auto'", 'lockstep')

    def test_unknown_solver(self):
        self.expect_one_line(['solver:=magic'], 'magic', 'minimise or paper')

    def test_missing_file(self):
        for source in ('bag', 'leap_recording'):
            with self.subTest(source):
                path = os.path.join(self.graph.folder, 'nowhere.' + source)
                self.expect_one_line(['hands:=' + source, 'file:=' + path], path)

    def test_garbage_as_a_bag(self):
        path = self.file('garbage.bag', bytes(range(256)) * 40)
        self.expect_one_line(['hands:=bag', 'file:=' + path], path, 'bag')

    def test_cut_bag(self):
        with open(rig_run.bag('press_finger'), 'rb') as whole:
            path = self.file('cut.bag', whole.read()[:9000])
        self.expect_one_line(['hands:=bag', 'file:=' + path], path, 'bag')

    def test_bag_without_the_topic(self):
        path = os.path.join(self.graph.folder, 'other.bag')
        with rosbag.Bag(path, 'w') as other:
            other.write('/chatter', String('hello'))
        self.expect_one_line(['hands:=bag', 'file:=' + path], path, 'hands/tracked')

    def test_bag_with_another_type_on_the_topic(self):
        path = os.path.join(self.graph.folder, 'typed.bag')
        with rosbag.Bag(path, 'w') as other:
            other.write('/hands/tracked', String('hello'))
        self.expect_one_line(['hands:=bag', 'file:=' + path], path, 'std_msgs/String', 'tactile_clay/TrackedHands')

    def test_garbage_as_a_recording(self):
        for name, content in (('plain.ndjson', b'no frames here\n'),
                              ('zipped.ndjson.gz', gzip.compress(b'\xff\xfe{]\n')),
                              ('cut.ndjson.gz', gzip.compress(os.urandom(5000))[:1000]), ('empty.ndjson', b'')):
            with self.subTest(name):
                path = self.file(name, content)
                self.expect_one_line(['hands:=leap_recording', 'file:=' + path], path)

    def test_unknown_device(self):
        self.expect_one_line(['device:=megaphone'], 'megaphone', 'debug')

    def test_wrong_options_of_a_device(self):
        for device, port, options, words in (
                ('sonic_surface', '', '', 'no port, expected'),
                ('sonic_surface', '/dev/nowhere', 'firmware=own', "firmware is 'own', expected one of stock, tactile"),
                ('sonic_surface', '/dev/nowhere', 'corrections=nowhere.csv', 'nowhere.csv: cannot be opened'),
                ('sonic_surface', '/dev/nowhere', 'temperature=30', "device_options: has the option temperature"),
                ('debug', '', 'log_rate', "device_options: 'log_rate', expected key=value"),
                ('debug', '', 'log_rate=often', "log_rate is 'often'")):
            with self.subTest(device + ' ' + options):
                self.expect_one_line(['device:=' + device, 'port:=' + port, 'device_options:=' + options], words)

    def test_wrong_supervisors(self):
        for device in ('debug', 'simulated'):
            for words in ('rosluanch', '', 'none master'):
                with self.subTest(device=device, words=words):
                    self.expect_one_line(['device:=' + device, 'supervisors:=' + words],
                                         "supervisors: ", "'%s'" % words, 'expected roslaunch, master, both, or none')

    def test_unknown_source_of_hands(self):
        self.expect_one_line(['hands:=telepathy'], 'telepathy', 'leap_recording')

    def test_url_that_is_none(self):
        self.expect_one_line(['hands:=leap_websocket', 'url:=http://localhost:6437'], 'http://localhost:6437',
                             'expected ws://HOST[:PORT][/PATH]')

    def test_unknown_argument(self):
        self.expect_one_line(['secne:=press'], 'secne', 'scene')

    def test_wrong_numbers(self):
        for argument in ('rate:=fast', 'duration:=-1', 'max_points:=0', 'threads:=many', 'prediction:=0.1',
                         'tracker_pose:=1 2 3'):
            with self.subTest(argument):
                self.expect_one_line([argument], argument.split(':')[0])

    def test_whole_numbers_have_no_fraction(self):
        for argument in ('substeps:=1.5', 'iterations:=2.5', 'threads:=1e-1', 'max_points:=8.01', 'phase_levels:=nan'):
            with self.subTest(argument):
                self.expect_one_line([argument], argument.split(':')[0], 'expected a')

    def test_wrong_switches_and_names(self):
        for argument, words in (('lockstep:=1', 'expected true or false'),
                                ('nodelets:=maybe', 'expected true or false'),
                                ('loop:=yes', 'expected true or false'), ('clean:=often', 'expected true or false'),
                                ('modulation:=fm', 'am, lateral, stm'), ('layout:=round', 'uhev1'),
                                ('phase_method:=guess', 'newton'), ('phase_levels:=-1', 'phase_levels'),
                                ('head_spl_cap:=loud', 'head_spl_cap')):
            with self.subTest(argument):
                self.expect_one_line([argument], argument.split('=')[1], words)

    def test_wrong_rig_files(self):
        for text, *words in (('tracker_pos: [0, 0, 0, 0, 0, 0]', ":2: unknown key 'tracker_pos'", 'tracker_pose'),
                             ('tracker_pose: [0, 0, 0]', ":2: 'tracker_pose' has 3 numbers", 'roll'),
                             ('head_point: here', ":2: 'head_point' cannot be read", 'x y z'),
                             ('pressure_cap: -1', ":2: 'pressure_cap': expected a number from 1 to"),
                             ('full_scale_pressure: 3e5', ":2: '3e5' is something else for rosparam, write 300000,"),
                             ('head_point: [0, 0, 3e-1]', ":2: '3e-1' is something else for rosparam, write 0.3,"),
                             ('head_point: [0, -.15, 0.4]', ":2: '-.15' is something else", 'write -0.15,'),
                             ('array_pose: [0, 0, 010, 0, 0, 0]', ":2: '010' is something else", 'write 10,'),
                             ('head_spl_cap: "110"', ":2: '110' is something else", 'write 110, without quotes'),
                             ('stale_timeout: !!str 0.1', ":2: '0.1' is something else", 'quotes or tag'),
                             ('phase_only: "true"', ":2: 'phase_only': expected true or false"),
                             ('sigma: 0', '/my_rig.yaml: ', 'sigma'),
                             ('workspace_low: [0.3, 0, 0.1]', 'my_rig.yaml: safety gate: workspace in x'),
                             ('max_points: 4',
                              ":2: 'max_points' is an argument of the rig, expected it as max_points:="),
                             ('gate_without: [hand_lost]', ":2: unknown key 'gate_without'")):
            with self.subTest(text):
                path = self.file('my_rig.yaml', ('temperature: 21.5\n%s\n' % text).encode())
                self.expect_one_line(['rig:=' + path], path, *words)
        self.expect_one_line(['rig:=nowhere.yaml'], 'nowhere.yaml')

    def test_wrong_files_of_a_person(self):
        for text, *words in (('felt_gain: 20.0', ":1: 'felt_gain': expected a number from 0.1 to 10"),
                             ("felt_gain: '1.5'", ":1: '1.5' is something else for rosparam, write 1.5,"),
                             ('felt_threshold: much', ":1: 'felt_threshold': expected a number"),
                             ('sigma: 0.01', ":1: unknown key 'sigma'", 'felt_gain, felt_threshold')):
            with self.subTest(text):
                path = self.file('person.yaml', (text + '\n').encode())
                self.expect_one_line(['person:=' + path], path, *words)
        self.expect_one_line(['person:=nobody.yaml'], 'nobody.yaml')

    def test_roslaunch_by_itself_fails_too(self):
        code, lines = self.run_to_end(['roslaunch', 'tactile_clay', 'rig.launch', 'rviz:=false', 'scene:=sandbox'])
        self.assertGreater(code, 0)
        self.assertTrue([line for line in lines if 'sandbox' in line and 'kindergarten' in line], lines)

    def test_a_list_with_a_text_in_it(self):
        self.graph.master().setParam('/test', '/bad_list/tracker_pose', [0, 0, '3e-1', 0, 0, 0])
        code, lines = self.run_to_end([os.path.join(PROGRAMS, 'hand_tracking'), '__name:=bad_list'])
        self.assertEqual(code, 1, lines)
        self.assertTrue([line for line in lines if 'tracker_pose' in line and 'got "{0,0,3e-1,0,0,0}"' in line], lines)

    def test_a_node_by_itself(self):
        self.graph.master().setParam('/test', '/wrong_description', '<robot name="unfinished">')
        for number, (program, argument, words) in enumerate((
                ('hand_tracking', '_source:=telepathy', 'telepathy'),
                ('hand_tracking', '_tracker_pose:=1 2 3', 'tracker_pose'),
                ('hand_tracking', '_clean:=perhaps', 'expected auto, true or false'),
                ('hand_tracking', '_position_beta:=-1', 'position_beta'),
                ('hand_simulator', '_spacing:=-1', 'spacing'),
                ('clay_simulator', '_scene:=sandbox', 'sandbox'),
                ('clay_simulator', '_rate:=zero', 'rate'),
                ('clay_simulator', 'robot_description:=wrong_description', 'parameter /wrong_description: urdf'),
                ('focal_point_renderer', '_max_points:=0', 'max_points'),
                ('focal_point_renderer', '_intensity_fit:=best', 'least_squares'),
                ('array_driver', '_device:=megaphone', 'megaphone'),
                ('array_driver', '_stale_timeout:=-1', 'stale_timeout'),
                ('simulated_array', '_array_pose:=1 2', 'array_pose'))):
            with self.subTest(program=program, argument=argument):
                code, lines = self.run_to_end([os.path.join(PROGRAMS, program), argument, '__name:=bad_%d' % number])
                self.assertEqual(code, 1, lines)
                fatal = [line for line in lines if 'FATAL' in line]
                self.assertEqual(len(fatal), 1, lines)
                self.assertIn(words, fatal[0])


if __name__ == '__main__':
    rig_run.main('bad_input')
