#!/usr/bin/env python3
"""Clay that is saved and goes on: see sculpture.test."""
import os
import shutil
import stat
import struct
import subprocess
import tempfile
import threading
import unittest
from collections import Counter

import rosbag
import roslib.packages
import rospy
from sensor_msgs.msg import PointCloud2
from std_srvs.srv import Trigger
from tactile_clay.srv import SculptureFile, Undo

import rig_run

PATIENCE = 30.0  # s
CLAY = 2114 * 0.5**3  # cm^3, of the scene


def stl_volume(file):
    """Volume of a binary STL file in mm, cm^3. Raises AssertionError where it is not closed."""
    with open(file, 'rb') as opened:
        data = opened.read()
    count, = struct.unpack_from('<I', data, 80)
    assert len(data) == 84 + 50 * count
    edges, volume = Counter(), 0.0
    for k in range(count):
        a, b, c = corners = [struct.unpack_from('<3f', data, 84 + 50 * k + 12 * (1 + n)) for n in range(3)]
        edges.update(zip(corners, corners[1:] + corners[:1]))
        volume += sum(a[i] * (b[i - 2] * c[i - 1] - b[i - 1] * c[i - 2]) for i in range(3)) / 6000.0
    assert all(n == 1 and edges[to, start] == 1 for (start, to), n in edges.items()), 'each edge has two triangles'
    return volume


def export_mesh(*arguments):
    program = roslib.packages.find_node('tactile_clay', 'export_mesh')[0]
    return subprocess.run([program, *arguments], capture_output=True, text=True, timeout=PATIENCE)


class Sculpture(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.skins = rig_run.lockstep('press_deeper').messages['/hands/skin']
        rospy.init_node('sculpture_test')
        cls.folder = tempfile.mkdtemp()
        cls.contacts = []
        cls.subscriber = rospy.Subscriber('clay/contacts', PointCloud2, cls.contacts.append, queue_size=None)
        cls.publisher = rospy.Publisher('hands/skin', PointCloud2, queue_size=None)
        rig_run.wait_until(lambda: cls.publisher.get_num_connections() and cls.subscriber.get_num_connections(),
                           PATIENCE, 'connections')

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.folder)

    def answers(self, skins):
        """What the clay says to these samples, one after the other."""
        del self.contacts[:]
        for skin in skins:
            self.publisher.publish(skin)
        rig_run.wait_until(lambda: len(self.contacts) == len(skins), PATIENCE, 'an answer to each skin')
        return [message.data for message in self.contacts]

    def call(self, name, **request):
        service = 'clay_simulator/' + name
        rospy.wait_for_service(service, PATIENCE)
        return rospy.ServiceProxy(service, SculptureFile if request else Trigger)(**request)

    def test_goes_on_to_the_bit(self):
        touched = [k for k, skin in enumerate(self.answers(self.skins)) if skin]
        middle = touched[len(touched) // 2]
        before, after = self.skins[:middle], self.skins[middle:]
        file = os.path.join(self.folder, 'pressed.clay')

        self.assertTrue(self.call('reset').success)
        self.answers(before)
        saved = self.call('save', file=file)
        self.assertTrue(saved.success, saved.message)
        once = self.answers(after)
        self.assertGreater(len([data for data in once if data]), 5)

        untouched = self.answers(after)
        self.assertNotEqual(untouched, once, 'the dent is not felt')
        loaded = self.call('load', file=file)
        self.assertTrue(loaded.success, loaded.message)
        self.answers(before[-1:])  # no time passes: its stamp lies before
        self.assertEqual(self.answers(after), once)

    def undo(self, seconds):
        rospy.wait_for_service('clay_simulator/undo', PATIENCE)
        return rospy.ServiceProxy('clay_simulator/undo', Undo)(seconds=seconds)

    def test_what_is_undone_comes_again_to_the_bit(self):
        """Samples of a second and a half, from a state of which the second half is undone."""
        self.assertTrue(self.call('reset').success)
        once = self.answers(self.skins)
        times = [skin.header.stamp.to_sec() for skin in self.skins]
        answer = self.undo(times[-1] - times[0] - 1.0)
        self.assertTrue(answer.success, answer.message)
        self.assertGreaterEqual(answer.went_back, times[-1] - times[0] - 1.0 - 1e-6)
        self.assertIn('the clay is as it was', answer.message)
        last = times[-1] - answer.went_back
        middle = next(k for k, time in enumerate(times) if time > last + 1e-4)
        self.assertGreater(len(times) - middle, 10)
        self.answers(self.skins[middle - 1:middle])  # no time passes: its stamp lies before
        again = self.answers(self.skins[middle:])
        self.assertGreater(len([data for data in again if data]), 5)
        self.assertEqual(again, once[middle:])

    def test_a_reset_is_undone(self):
        self.answers(self.skins)
        first = os.path.join(self.folder, 'first.clay')
        second = os.path.join(self.folder, 'second.clay')
        self.assertTrue(self.call('save', file=first).success)
        self.assertTrue(self.call('reset').success)
        self.assertTrue(self.undo(0.0).success)
        self.assertTrue(self.call('save', file=second).success)
        with open(first, 'rb') as one, open(second, 'rb') as other:
            self.assertEqual(one.read(), other.read())
        answer = self.undo(1e4)
        self.assertFalse(answer.success)
        self.assertRegex(answer.message, r'^10000.0 s back: expected at most [0-9.]+ s, the age of the oldest state')

    def test_what_is_no_sculpture_is_refused(self):
        damaged = os.path.join(self.folder, 'damaged.clay')
        with open(damaged, 'w') as file:
            file.write('clay')
        fifo, huge = os.path.join(self.folder, 'fifo'), os.path.join(self.folder, 'huge.clay')
        os.mkfifo(fifo)
        with open(huge, 'wb') as file:
            file.write(b'tactile_clay sculpture 5\n' + bytes(44) + b'\xff' * 8)
        for name, file, words in (('load', damaged, 'is not a sculpture'),
                                  ('load', self.folder + '/none.clay', 'cannot be opened'),
                                  ('load', huge, 'a count of'),
                                  ('load', fifo, 'is a FIFO'),
                                  ('load', self.folder, 'is a folder'),
                                  ('load', '/dev/zero', 'is a device'),
                                  ('load', 'relative.clay', 'expected an absolute path'),
                                  ('save', self.folder + '/no/folder.clay', 'cannot be written'),
                                  ('save', 'relative.clay', 'expected an absolute path'),
                                  ('save', damaged, 'exists already, expected a new name, '
                                                   'or a call of the service overwrite'),
                                  ('overwrite', fifo, 'is not a regular file'),
                                  ('overwrite', self.folder, 'is not a regular file'),
                                  ('overwrite', '/dev/null', 'is not a regular file')):
            answer = self.call(name, file=file)
            self.assertFalse(answer.success)
            self.assertIn(words, answer.message)
            self.assertIn(file, answer.message)
            self.assertNotIn('\n', answer.message)
        with open(damaged) as file:
            self.assertEqual(file.read(), 'clay')
        self.assertTrue(stat.S_ISCHR(os.stat('/dev/null').st_mode))
        self.assertTrue(stat.S_ISFIFO(os.stat(fifo).st_mode))
        written = self.call('overwrite', file=damaged)
        self.assertTrue(written.success, written.message)
        loaded = self.call('load', file=damaged)
        self.assertTrue(loaded.success, loaded.message)

    def exported(self, service, file):
        """The answer of clay_surface, while the clay goes on."""
        answers = []
        thread = threading.Thread(target=lambda: answers.append(
            rospy.ServiceProxy('clay_surface/' + service, SculptureFile)(file=file)))
        rospy.wait_for_service('clay_surface/' + service, PATIENCE)
        thread.start()
        while thread.is_alive():
            self.answers(self.skins[:1])
            thread.join(0.05)
        return answers[0]

    def test_its_surface_leaves_as_a_mesh(self):
        mesh = os.path.join(self.folder, 'mesh.stl')
        answer = self.exported('export', mesh)
        self.assertTrue(answer.success, answer.message)
        self.assertAlmostEqual(stl_volume(mesh) / CLAY, 1.0, delta=0.02)
        for name, file, words in (('export', mesh, 'exists already'),
                                  ('export', 'mesh.ply', 'expected an absolute path'),
                                  ('overwrite', self.folder + '/mesh.obj', 'ends in .ply or .stl')):
            answer = self.exported(name, file)
            self.assertFalse(answer.success)
            self.assertIn(words, answer.message)
        self.assertTrue(self.exported('overwrite', mesh).success)

    def test_meshes_of_files(self):
        sculpture, bag = os.path.join(self.folder, 'some.clay'), os.path.join(self.folder, 'some.bag')
        self.assertTrue(self.call('save', file=sculpture).success)
        clouds = []
        subscriber = rospy.Subscriber('clay/particles', PointCloud2, clouds.append)
        rig_run.wait_until(lambda: self.answers(self.skins[:1]) and clouds, PATIENCE, 'particles')
        subscriber.unregister()
        with rosbag.Bag(bag, 'w') as opened:
            opened.write('/rig/clay/particles', clouds[0])
        for file in (sculpture, bag):
            mesh = file + '.stl'
            done = export_mesh('in:=' + file, 'out:=' + mesh)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertAlmostEqual(stl_volume(mesh) / CLAY, 1.0, delta=0.02)
            self.assertIn('cm^3', done.stdout)
        with open(bag + '.stl', 'rb') as one, open(sculpture + '.stl', 'rb') as other:
            self.assertEqual(len(one.read()), len(other.read()))
        for arguments, words in ((('in:=' + sculpture, 'out:=' + mesh), 'exists already'),
                                 (('in:=' + sculpture,), 'got no out'),
                                 (('in:=' + sculpture, 'out:=' + mesh + '.obj'), 'ends in .ply or .stl'),
                                 (('in:=' + mesh, 'out:=' + mesh + '.ply'), 'is not a sculpture'),
                                 (('in:=' + bag, 'out:=' + mesh + '.ply', 'topic:=hands/skin'),
                                  'no clouds on hands/skin'),
                                 (('in:=' + sculpture, 'out:=' + mesh + '.ply', 'scene:=potters_wheel'),
                                  'expected scene:=')):
            done = export_mesh(*arguments)
            self.assertEqual(done.returncode, 1)
            self.assertIn(words, done.stderr)
            self.assertEqual(done.stderr.count('\n'), 1)


if __name__ == '__main__':
    rig_run.main('sculpture')
