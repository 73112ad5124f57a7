#!/usr/bin/env python3
"""Clay that is saved and goes on: see sculpture.test."""
import os
import shutil
import stat
import tempfile
import unittest

import rospy
from sensor_msgs.msg import PointCloud2
from std_srvs.srv import Trigger
from tactile_clay.srv import SculptureFile

import rig_run

PATIENCE = 30.0  # s


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
                                  ('save', damaged, 'is there already, expected a new name, or a call of the service overwrite'),
                                  ('overwrite', fifo, 'is no regular file'),
                                  ('overwrite', self.folder, 'is no regular file'),
                                  ('overwrite', '/dev/null', 'is no regular file')):
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


if __name__ == '__main__':
    rig_run.main('sculpture')
