#!/usr/bin/env python3
"""The recorder of the rig: see recorder.test."""
import os
import signal
import subprocess
import tempfile
import time
import unittest

import rig_run

RECORDER = os.path.join(rig_run.build_space(), 'devel', 'lib', 'tactile_clay', 'record_run')
OF_EACH_SAMPLE = rig_run.CHAIN + ['/clay/particles', '/clay/status', '/array/drive']


class Recorder(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix='recorder_')
        self.addCleanup(folder.cleanup)
        self.folder = folder.name

    def refused(self, *parameters):
        """The line with which the recorder of a graph ends that cannot begin."""
        with rig_run.Graph() as graph:
            process = graph.start([RECORDER, *parameters], stderr=subprocess.PIPE, text=True, cwd=self.folder)
            _, errors = process.communicate(timeout=30)
        self.assertEqual(process.returncode, 1)
        return errors.strip()

    def test_a_lockstep_run_waits_for_a_slow_recorder(self):
        """bzip2 packs some 10 MB a second, a tenth of what this run gives."""
        bag = os.path.join(self.folder, 'a new folder', 'run.bag')
        with rig_run.Graph() as graph:
            rig = graph.rig(dict(rig_run.LOCKSTEP, file=rig_run.bag('knead'), quality='draft', duration='6', record=bag,
                                 record_compression='bz2'))
            code, words = rig.wait(200), graph.words()
        self.assertEqual(code, 0, words)
        messages = rig_run.Messages(bag)
        stamps = messages.stamps('/hands/tracked')
        self.assertEqual(len(stamps), 360)
        for topic in OF_EACH_SAMPLE:
            self.assertEqual(messages.stamps(topic), stamps, topic)
        self.assertEqual(len(messages['/rig/description']), 1)

    def test_a_lockstep_run_does_not_wait_for_a_recorder_of_other_topics(self):
        run = rig_run.Run(dict(rig_run.LOCKSTEP, file=rig_run.bag('knead'), quality='draft', duration='1'),
                          topics=['/hands/skin'])
        self.assertEqual(run.code, 0, run.words)
        self.assertEqual(len(run.messages['/hands/skin']), 60)

    def test_what_was_sent_before_it_is_asked_to_end_is_in_the_bag(self):
        """Of so many messages rosbag's queue of 100 would drop some. The sender stays: where a publisher leaves, ROS
        drops its connection with what was not read yet."""
        bag = os.path.join(self.folder, 'sent.bag')
        count = 300
        sender = ('import base64, os, rospy\nfrom std_msgs.msg import String\nrospy.init_node("sender")\n'
                  'p = rospy.Publisher("words", String, queue_size=None)\n'  # publish() returns once it is sent
                  'while p.get_num_connections() == 0: rospy.sleep(0.01)\n'
                  'text = base64.b64encode(os.urandom(100000)).decode()\n'
                  'for k in range(%d): p.publish("%%06d" %% k + text)\n'
                  'open("sent", "w").close()\nrospy.spin()\n' % count)
        with rig_run.Graph() as graph:
            recorder = graph.start([RECORDER, '_bag:=' + bag, '_topics:=words', '_compression:=bz2'])
            graph.start(['python3', '-c', sender])
            rig_run.wait_until(lambda: os.path.exists(os.path.join(graph.folder, 'sent')), 100, 'all to be sent')
            recorder.send_signal(signal.SIGTERM)
            self.assertEqual(recorder.wait(100), 0)
        self.assertEqual([int(message.data[:6]) for message in rig_run.Messages(bag)['/words']], list(range(count)))
        self.assertEqual(os.listdir(self.folder), ['sent.bag'])

    def test_one_line_about_what_it_cannot_do(self):
        self.assertIn("compression 'zip', expected one of none, lz4, bz2", self.refused('_compression:=zip'))
        open(os.path.join(self.folder, 'old.bag'), 'w').close()
        self.assertIn("old.bag' exists already", self.refused('_bag:=old.bag'))
        self.assertIn('is not a folder', self.refused('_bag:=old.bag/new.bag'))

    def test_recordings_are_dated_where_they_have_no_name(self):
        with rig_run.Graph() as graph:
            recorder = graph.start([RECORDER, '_folder:=' + self.folder])
            rig_run.wait_until(lambda: graph.registered('/record'), 30, 'a recorder')
            time.sleep(0.5)
            self.assertEqual(graph.stop(recorder), 0)
        self.assertRegex(os.listdir(self.folder)[0], r'^tactile_clay_\d{4}(-\d\d){5}\.bag$')


if __name__ == '__main__':
    rig_run.main('recorder')
