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


class Killed(unittest.TestCase):
    def kill(self, node):
        with rig_run.Graph() as graph, sonic_surface.Emulator(os.path.join(graph.folder, 'port')) as emulator:
            rig = graph.rig(dict(hands='bag', file=rig_run.bag('knead'), loop='true', device='sonic_surface', quality='fast',
                                 port=emulator.link, max_points='1', head_spl_cap='200'))
            wait_until(emulator.sounds, 60, 'a sound; the rig says\n' + graph.words())
            _, _, uri = graph.master().lookupNode('/test', '/' + node)
            _, _, pid = xmlrpc.client.ServerProxy(uri).getPid('/test')
            killed = time.monotonic()
            os.kill(pid, signal.SIGKILL)
            wait_until(emulator.silent_for_good, 10, 'silence')
            swaps = emulator.since(0)
            last = max(after.when for before, after in zip(swaps, swaps[1:]) if before.sounds)
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
