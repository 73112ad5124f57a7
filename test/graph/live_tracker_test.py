#!/usr/bin/env python3
"""The whole rig on a live websocket tracker: see live_tracker.test."""
import json
import math
import os
import subprocess
import sys
import time
import unittest

import rig_run

SERVER = os.path.join(rig_run.PACKAGE, 'test', 'support', 'leap_server.py')


class LiveTracker(unittest.TestCase):
    def serve(self, *arguments):
        """Starts the server. Returns its process and url."""
        server = subprocess.Popen([sys.executable, SERVER] + list(arguments), stdout=subprocess.PIPE,
                                  stdin=subprocess.DEVNULL, universal_newlines=True)
        self.addCleanup(server.wait)
        self.addCleanup(server.kill)
        self.addCleanup(server.stdout.close)
        return server, 'ws://127.0.0.1:%d/v6.json' % json.loads(server.stdout.readline())['port']

    def test_a_recording_over_a_websocket_drives_the_rig(self):
        # Breaking off each two seconds, and saying what is no message, does not stop it.
        _, url = self.serve(rig_run.recording('grab'), '--loop', '--rate', '110', '--disconnect', '220', '--garbage',
                            '50')
        run = rig_run.Run({'hands': 'leap_websocket', 'url': url, 'quality': 'fast', 'duration': '8'},
                          rig_run.CHAIN + ['/diagnostics'])
        self.assertEqual((run.code, run.left), (0, []), run.words)
        self.assertNotIn('Traceback', run.words)
        self.assertIn("expected one message of Leap's JSON protocol v6", run.words)
        hands = run.messages['/hands/tracked']
        self.assertGreater(len(hands), 300)
        self.assertGreater(sum(bool(message.hands) for message in hands), 200)
        stamps = run.messages.stamps('/hands/tracked')
        self.assertEqual(stamps, sorted(set(stamps)))
        self.assertEqual({message.header.frame_id for message in hands}, {'world'})
        states = run.messages['/array/state']
        self.assertGreater(len(states), 20)
        print('%d samples of hands, %d focal-point frames, %d of them touching, %d states' % (
            len(hands), len(run.messages['/array/focal_points']),
            sum(bool(message.points) for message in run.messages['/array/focal_points']), len(states)))
        self.assertTrue(any(message.points for message in run.messages['/array/focal_points']))
        reports = [{pair.key: pair.value for pair in status.values} for message in run.messages['/diagnostics']
                   for status in message.status if status.name.endswith('tracked hands')]
        self.assertGreater(len(reports), 4)
        rates = [float(report['rate, Hz']) for report in reports]
        self.assertTrue(50 < max(rates) < 150, rates)  # of 110, and nothing while it is not connected
        # The server's clock stands still while it is away, which takes a quarter of a second to be seen.
        ages = sorted(float(report['age, mean, s']) for report in reports)
        self.assertTrue(0.0 < ages[0] and ages[len(ages) // 2] < 0.1, ages)
        self.assertGreater(int(reports[-1]['dropouts']), 0)  # each time that the tracker breaks off
        self.assertGreater(int(reports[-1]['faults of the source']), 0)
        sure = [report['confidence, ' + side + ', minimum'] for report in reports for side in ('left', 'right')]
        self.assertTrue(any(value != 'not seen' and 0.0 < float(value) <= 1.0 for value in sure), sure)

    def test_each_recording_over_a_websocket_drives_the_rig(self):
        for name in rig_run.RECORDINGS:
            with self.subTest(name):
                _, url = self.serve(rig_run.recording(name), '--loop', '--rate', '60')
                run = rig_run.Run({'hands': 'leap_websocket', 'url': url, 'quality': 'fast', 'duration': '4'})
                self.assertEqual((run.code, run.left), (0, []), run.words)
                self.assertNotIn('Traceback', run.words)
                hands = run.messages['/hands/tracked']
                print('%s: %d samples, %d with hands, %d skins, %d focal-point frames, %d touching, %d states' % (
                    name, len(hands), sum(bool(message.hands) for message in hands), len(run.messages['/hands/skin']),
                    len(run.messages['/array/focal_points']),
                    sum(bool(message.points) for message in run.messages['/array/focal_points']),
                    len(run.messages['/array/state'])))
                self.assertGreater(sum(bool(message.hands) for message in hands), 100)
                # Live, the newest sample wins at each node; how many a second is the benchmarks' and not asked for
                # here.
                for topic in rig_run.CHAIN[1:]:
                    self.assertGreater(len(run.messages[topic]), 10, topic)
                    stamps = run.messages.stamps(topic)
                    self.assertEqual(stamps, sorted(stamps), topic)
                for message in run.messages['/array/focal_points']:
                    for point in message.points:
                        p = point.position
                        self.assertTrue(all(map(math.isfinite, (p.x, p.y, p.z, point.pressure, point.intensity))),
                                        point)

    def test_no_tracker_is_told_and_ends_on_request(self):
        server, url = self.serve(os.devnull)
        server.kill()
        server.wait()
        with rig_run.Graph() as graph:
            rig = graph.rig({'hands': 'leap_websocket', 'url': url})
            rig_run.wait_until(lambda: url in graph.words(), 60, 'a line about ' + url)
            time.sleep(1.0)
            self.assertIsNone(rig.poll(), graph.words())
            self.assertEqual(graph.stop(rig), 130)
            lines = [line for line in graph.words().splitlines() if url in line and 'WARN' in line]
            self.assertTrue(lines, graph.words())
            self.assertIn("expected a server of Leap's protocol v6", lines[0])
            self.assertEqual(graph.left_processes(), [])


if __name__ == '__main__':
    rig_run.main('live_tracker')
