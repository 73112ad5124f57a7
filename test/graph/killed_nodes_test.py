#!/usr/bin/env python3
"""Each node before the array is killed: see killed_nodes.test."""
import os
import signal
import sys
import time
import unittest
import xmlrpc.client

import rig_run
from rig_run import wait_until

sys.path.insert(0, os.path.join(rig_run.PACKAGE, 'test', 'emulator'))
import sonic_surface  # noqa: E402  pylint: disable=wrong-import-position

UPSTREAM = ['hand_tracking', 'hand_simulator', 'clay_simulator', 'contact_pressure', 'focal_point_renderer']


def knead(graph, emulator):
    rig = graph.rig(dict(hands='bag', file=rig_run.bag('knead'), loop='true', device='sonic_surface', quality='fast',
                         port=emulator.link, max_points='1', head_spl_cap='200'))
    wait_until(emulator.sounds, 60, 'a sound; the rig says\n' + graph.words())
    return rig


class Killed(unittest.TestCase):
    def test_the_script(self):
        """scripts/rig, which passes Ctrl-C on: suspended, it silences the array until it goes on; killed, it takes all with it."""
        with rig_run.Graph() as graph, sonic_surface.Emulator(os.path.join(graph.folder, 'port')) as emulator:
            rig = knead(graph, emulator)
            for name in (signal.SIGTSTP, signal.SIGKILL):
                since = time.monotonic()
                rig.send_signal(name)
                time.sleep(2.0)
                self.assertTrue(emulator.silent_for_good(), name)
                last = emulator.last_sound()
                print('silent %.0f ms after %s' % (1e3 * (last - since), name.name))
                self.assertLess(last - since, 1.25)  # a second, and what a busy machine adds
                if name == signal.SIGTSTP:
                    rig.send_signal(signal.SIGCONT)
                    wait_until(emulator.sounds, 20, 'a sound')
            wait_until(lambda: graph.left_processes() == [], 30, 'the end of all')
            self.assertTrue(emulator.silent_for_good())

    def kill(self, node):
        with rig_run.Graph() as graph, sonic_surface.Emulator(os.path.join(graph.folder, 'port')) as emulator:
            rig = knead(graph, emulator)
            _, _, uri = graph.master().lookupNode('/test', '/' + node)
            _, _, pid = xmlrpc.client.ServerProxy(uri).getPid('/test')
            killed = time.monotonic()
            os.kill(pid, signal.SIGKILL)
            wait_until(emulator.silent_for_good, 10, 'silence')
            last = emulator.last_sound()
            print('silent %.0f ms after' % (1e3 * (last - killed)))
            self.assertLess(last - killed, 1.0)  # 0.1 by the gate, and what a busy machine adds
            graph.stop(rig)
            self.assertTrue(emulator.silent_for_good())


def case(node):
    return lambda self: self.kill(node)


for name in UPSTREAM:
    setattr(Killed, 'test_' + name, case(name))

if __name__ == '__main__':
    rig_run.main('killed_nodes')
