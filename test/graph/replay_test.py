#!/usr/bin/env python3
"""What a bag says of its rig, and whether it comes again: see replay.test."""
import io
import math
import os
import shutil
import subprocess
import tempfile
import unittest
from importlib.machinery import SourceFileLoader

import genpy.dynamic
import rosbag
import rosbag.migration
import roslaunch.config
import roslib.message
import rospkg
import rospy
import yaml
from std_msgs.msg import String

import rig_run
from own_files import OWN_RIG, config, own_files, write

REPLAY = os.path.join(rig_run.build_space(), 'devel', 'lib', 'tactile_clay', 'replay')
OLD_FIELD = 'string tracker\n'
RULE = """
class OldHands(MessageUpdateRule):
    old_type = new_type = 'tactile_clay/TrackedHands'
    old_full_text = %r
    new_full_text = %r
    order = 0
    migrated_types = [('Header', 'Header'), ('TrackedHand', 'TrackedHand')]
    valid = True
    def update(self, old_msg, new_msg):
        self.migrate(old_msg.header, new_msg.header)
        self.migrate_array(old_msg.hands, new_msg.hands, 'TrackedHand')
"""


def replay(bag, *options):
    """(exit code, lines of the standard output, lines of the standard error)"""
    done = subprocess.run([REPLAY, bag, *options], stdin=subprocess.DEVNULL, capture_output=True, text=True,
                          timeout=200, check=False)
    return done.returncode, done.stdout.splitlines(), done.stderr.splitlines()


class Replay(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.mkdtemp(prefix='replay_test_')
        cls.addClassCleanup(shutil.rmtree, cls.folder, ignore_errors=True)
        files = os.path.join(cls.folder, 'files of a user')
        cls.scene = own_files(files)
        cls.rig = os.path.join(files, 'my_rig.yaml')
        write(cls.rig, OWN_RIG)
        cls.bag = os.path.join(cls.folder, 'run.bag')
        cls.head = subprocess.run(['git', '-C', rig_run.PACKAGE, 'rev-parse', 'HEAD'], capture_output=True, text=True,
                                  check=False)
        with rig_run.Graph() as graph:
            rig = graph.rig(dict(rig_run.LOCKSTEP, hands='bag', file=rig_run.bag('press_finger'), scene=cls.scene,
                                 quality='fast', duration='1.6', nodelets='true', rig=cls.rig, record=cls.bag),
                            environment={'ROS_NAMESPACE': 'lab'})
            code, words = rig.wait(150), graph.words()
        if code != 0:
            raise AssertionError(words)
        shutil.rmtree(files)

    def changed(self, name, change):
        """A copy of the bag in which change(topic, message) gives each message anew, or None to leave it out."""
        path = os.path.join(self.folder, name + '.bag')
        with rosbag.Bag(self.bag) as bag, rosbag.Bag(path, 'w') as copy:
            for topic, message, when in bag.read_messages():
                message = change(topic, message)
                if message is not None:
                    copy.write(topic, message, when)
        return path

    def description(self):
        with rosbag.Bag(self.bag) as bag:
            texts = [message.data for _, message, _ in bag.read_messages('/lab/rig/description')]
        self.assertEqual(len(texts), 1)
        return yaml.safe_load(texts[0])

    def described(self, name, change):
        """A copy of the bag whose description is changed."""
        def of(topic, message):
            if not topic.endswith('rig/description'):
                return message
            told = yaml.safe_load(message.data)
            change(told)
            return String(yaml.safe_dump(told))
        return self.changed(name, of)

    def expect_refused(self, bag, *words):
        code, _, errors = replay(bag)
        self.assertEqual(code, 2, errors)
        self.assertEqual(len(errors), 1, errors)
        self.assertTrue(errors[0].startswith('replay: %s: ' % bag), errors)
        for word in words:
            self.assertIn(word, errors[0])

    def test_the_description_tells_what_the_rig_was(self):
        told = self.description()
        self.assertEqual(told['package']['version'], rospkg.RosPack().get_manifest('tactile_clay').version)
        if self.head.returncode == 0:
            self.assertEqual(told['package']['commit'], self.head.stdout.strip())
            self.assertIsInstance(told['package']['tree_has_changes'], bool)
        self.assertEqual((told['namespace'], told['host']['name']), ('/lab', os.uname().nodename))
        self.assertEqual(told['parameters']['clay_simulator']['quality'], 'fast')
        head_point = yaml.safe_load(config('rig.yaml'))['head_point']
        self.assertEqual(told['parameters']['simulated_array']['head_point'], head_point)
        self.assertEqual(told['parameters']['simulated_array']['temperature'], 24.5)
        self.assertEqual(told['parameters']['focal_point_renderer']['full_scale_pressure'], 300000.0)
        self.assertEqual((told['arguments']['nodelets'], told['arguments']['scene']), ('True', self.scene))
        files = {(entry['role'], entry['name']): entry for entry in told['files']}
        self.assertFalse([entry for entry in files.values() if 'missing' in entry])
        self.assertEqual(files['material', 'putty']['text'], config('materials', 'putty.yaml'))
        self.assertEqual(files['material', 'putty']['path'], 'config/materials/putty.yaml')
        self.assertEqual(files['quality', 'quality.yaml']['text'], config('quality.yaml'))
        self.assertIn('adhesion: 50', files['material', 'soft.yaml']['text'])
        self.assertIn('<robot', files['urdf', 'my_table.urdf']['text'])
        self.assertIn(('mesh', 'wedge.stl'), files)
        self.assertEqual(files['own rig', self.rig]['text'], OWN_RIG)

    def test_it_is_in_the_bag_before_the_first_sample(self):
        with rosbag.Bag(self.bag) as bag:
            times = {topic: when for topic, _, when in reversed(list(bag.read_messages(raw=True)))}
        self.assertLess(times['/lab/rig/description'], times['/lab/hands/tracked'])

    def test_comes_again_from_the_bag_alone(self):
        kept = os.path.join(self.folder, 'kept')
        code, lines, errors = replay(self.bag, '--keep', kept)
        self.assertEqual(code, 0, '\n'.join(lines + errors))
        self.assertRegex(lines[-1], r'^identical: \d+ messages on \d+ topics$')
        with rosbag.Bag(self.bag) as bag:
            count = bag.get_message_count('/lab/array/focal_points')
        self.assertGreater(count, 90)
        for topic in ('clay/particles', 'clay/contacts', 'hands/pressure', 'array/focal_points', 'array/drive',
                      'array/state'):
            told = [line for line in lines if line.startswith('replay: /lab/%s ' % topic)]
            self.assertEqual([line.split()[2:] for line in told], [[str(count), 'messages', 'the', 'same']], topic)
        self.assertTrue(os.path.exists(os.path.join(kept, 'replayed.bag')))
        self.expect_refused_folder(kept)

    def expect_refused_folder(self, kept):
        code, _, errors = replay(self.bag, '--keep', kept)
        self.assertEqual((code, len(errors)), (2, 1), errors)

    def test_a_bag_of_an_earlier_release(self):
        """The package's own rules are found; what was not recorded then is not compared."""
        newest = {old._type: old for old in earlier_types()}
        self.assertIn('tactile_clay/ClayStatus', newest)

        def older(_, message):
            old = newest.get(message._type)
            return message if old is None else old(*[getattr(message, name) for name in old.__slots__])
        code, lines, errors = replay(self.changed('earlier', older))
        self.assertEqual(code, 0, '\n'.join(lines + errors))
        self.assertRegex(lines[-1], r'^identical: \d+ messages on \d+ topics$')
        untold = [line for line in lines
                  if line.startswith('replay: not compared, because the recorded /lab/clay/status ')]
        self.assertEqual(len(untold), 1, lines)
        self.assertIn('lowered', untold[0])

    def test_one_number_of_a_bag_with_older_messages(self):
        """Migrated by rules; the one number that was changed is named."""
        now = roslib.message.get_message_class('tactile_clay/TrackedHands')
        text = now._full_text.replace('Header header\n', 'Header header\n' + OLD_FIELD, 1)
        old = genpy.dynamic.generate_dynamic('tactile_clay/TrackedHands', text)['tactile_clay/TrackedHands']
        self.assertNotEqual(old._md5sum, now._md5sum)
        seen = []

        def older(topic, message):
            if topic == '/lab/hands/tracked':
                return old(header=message.header, hands=message.hands, tracker='of old')
            if topic == '/lab/array/focal_points' and message.points:
                seen.append((message.header.stamp, message.points[0].pressure))
                if len(seen) == 4:
                    message.points[0].pressure += 1.0
            return message
        path = self.changed('older', older)
        self.assertGreater(len(seen), 4)
        self.expect_refused(path, 'tactile_clay/TrackedHands of /lab/hands/tracked', old._md5sum, now._md5sum)
        rules = os.path.join(self.folder, 'old.bmr')
        write(rules, RULE % (text, now._full_text))
        code, lines, errors = replay(path, '--rules', rules)
        self.assertEqual(code, 1, '\n'.join(lines + errors))
        stamp, pressure = seen[3]
        self.assertIn('different: /lab/array/focal_points at %d.%09d s: points[0].pressure: recorded %r, replayed %r, '
                      'by 1' % (stamp.secs, stamp.nsecs, pressure + 1.0, pressure), lines[-1])

    def test_what_cannot_be_replayed(self):
        def without(name, dropped):
            return self.changed(name, lambda topic, message: None if topic.endswith('hands/tracked')
                                and dropped(message.header.seq) else message)
        self.expect_refused(rig_run.bag('press_finger'), 'has no topic rig/description')
        for name, change, words in (
                ('major', lambda told: told['package'].update(version='7.0.0'), 'version 7.0.0'),
                ('live', lambda told: told['parameters']['clay_simulator'].update(lockstep=False), 'is of a live run'),
                ('file', lambda told: told['files'][1].update(missing='it was gone'), 'it was gone'),
                ('role', lambda told: told['files'][1].update(role=3), 'that are no texts'),
                ('leaves', lambda told: told['files'][1].update(path='config/../../../../out'), 'outside of its')):
            with self.subTest(name):
                self.expect_refused(self.described(name, change), words)
        self.expect_refused(without('late', lambda seq: seq < 5), 'begins with sample 5')
        self.expect_refused(without('hole', lambda seq: seq == 9), 'lacks samples 9 to 9')
        garbage = os.path.join(self.folder, 'garbage.bag')
        write(garbage, 'no bag\n' * 1000)
        self.expect_refused(garbage, 'not a readable bag')


def earlier_types():
    """The message types of earlier releases, oldest first, as the rules of the package know them."""
    rules = {'MessageUpdateRule': type('MessageUpdateRule', (), {})}
    exec(config('migration.bmr'), rules)  # as rosbag does
    found = [rule for rule in rules.values() if getattr(rule, 'valid', False)]
    return [genpy.dynamic.generate_dynamic(rule.old_type, rule.old_full_text)[rule.old_type] for rule in found]


class Migration(unittest.TestCase):
    def test_each_earlier_message_becomes_one_of_today(self):
        migrator = rosbag.migration.MessageMigrator(
            [os.path.join(rig_run.PACKAGE, 'config', 'migration.bmr')], plugins=False)
        olds = earlier_types()
        self.assertGreater(len(olds), 6)
        for number, old_type in enumerate(olds):
            with self.subTest(old_type._type, number=number):
                now = roslib.message.get_message_class(old_type._type)
                self.assertNotEqual(old_type._md5sum, now._md5sum)
                old = old_type()
                for k, (name, kind) in enumerate(zip(old.__slots__, old._slot_types)):
                    if kind == 'std_msgs/Header':
                        old.header.stamp, old.header.frame_id = rospy.Time(7, 8), 'array'
                    elif kind == 'tactile_clay/FocalPoint[]':
                        old.points = [old_point(old_type, 1.5), old_point(old_type, 2.5)]
                    else:
                        setattr(old, name, [k + 1.0] if kind == 'float32[]' else ['a'] if kind == 'string[]' else k + 1)
                buffer = io.BytesIO()
                old.serialize(buffer)
                _, data, md5, _, kind = migrator.migrate_raw(
                    (old_type._type, buffer.getvalue(), old_type._md5sum, None, old_type),
                    (now._type, None, now._md5sum, None, now))
                self.assertEqual((md5, kind), (now._md5sum, now))
                new = now().deserialize(data)
                self.assertEqual((new.header.stamp, new.header.frame_id), (rospy.Time(7, 8), 'array'))
                for name, kind in zip(new.__slots__, new._slot_types):
                    if name in ('header', 'points'):
                        continue
                    value = getattr(new, name)
                    if hasattr(old, name):
                        self.assertEqual(list(value) if isinstance(value, tuple) else value, getattr(old, name), name)
                    elif kind == 'float32':
                        self.assertTrue(math.isnan(value), name)
                    else:
                        self.assertFalse(value, name)
                if hasattr(old, 'points'):
                    self.assertEqual([point.pressure for point in new.points], [1.5, 2.5])


def old_point(array_type, pressure):
    point = genpy.dynamic.generate_dynamic(array_type._type, array_type._full_text)['tactile_clay/FocalPoint']()
    point.pressure = pressure
    return point


class Nodes(unittest.TestCase):
    def test_each_node_of_the_launch_is_described(self):
        """The list of describe_rig against roslaunch."""
        loader = SourceFileLoader('describe_rig', os.path.join(rig_run.PACKAGE, 'scripts', 'describe_rig'))
        describe = loader.load_module()
        launch = os.path.join(rig_run.PACKAGE, 'launch', 'rig.launch')
        for variant in ({}, dict(device='debug', skeleton='true', record='true'),
                        dict(device='sonic_surface', wire='/tmp/boards', nodelets='true')):
            launched = roslaunch.config.load_config_default(
                [(launch, ['rviz:=false'] + ['%s:=%s' % item for item in variant.items()])], 11311, verbose=False).nodes
            names = {node.name for node in launched} - {'describe_rig', 'record'}
            self.assertEqual(names, set(describe.nodes_of_rig(variant)))


if __name__ == '__main__':
    rig_run.main('replay')
