#!/usr/bin/env python3
"""`rosbag play` into the live rig, and Ctrl-C: see play.test."""
import unittest

import rig_run

TOPICS = ['/clay/particles', '/clay/contacts', '/clay/status', '/hands/pressure', '/array/focal_points', '/array/state']
READY = ['/hands/tracked', '/hands/skin', '/clay/contacts', '/hands/pressure', '/array/focal_points']


class Play(unittest.TestCase):
    def play(self, **arguments):
        with rig_run.Graph() as graph:
            graph.master().setParam('/test', '/use_sim_time', True)
            recording = graph.record(TOPICS)
            rig = graph.rig(dict(hands='topic', quality='fast', **arguments))
            rig_run.wait_until(lambda: all(graph.subscribed(topic) for topic in READY) or rig.poll() is not None, 60,
                               'a rig')
            player = graph.start(['rosbag', 'play', '--clock', '--delay=2', '--start=1', '--duration=5', '--quiet',
                                  rig_run.bag('knead')])
            self.assertEqual(player.wait(60), 0)
            self.assertIsNone(rig.poll(), graph.words())
            code = graph.stop(rig)
            self.assertEqual(code, 130, 'Ctrl-C: ' + graph.words())
            self.assertNotIn('escalating', graph.words())  # roslaunch had to send SIGTERM
            messages = graph.recorded(recording)
            self.assertEqual(graph.left_processes(), [])
        for topic in TOPICS:
            self.assertGreater(len(messages[topic]), 10, topic)
        self.assertEqual(messages['/clay/particles'][-1].width, 2114)
        self.assertGreater(max(cloud.width for cloud in messages['/clay/contacts']), 10)
        self.assertGreater(len([1 for message in messages['/array/focal_points'] if message.points]), 10)
        self.assertTrue(any(state.emitting for state in messages['/array/state']))
        stamps = messages.stamps('/array/focal_points')
        self.assertEqual(stamps, sorted(stamps))

    def test_nodes(self):
        self.play()

    def test_nodelets(self):
        self.play(nodelets='true')


if __name__ == '__main__':
    rig_run.main('play')
