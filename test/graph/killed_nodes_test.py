#!/usr/bin/env python3
"""Nodes that are killed or frozen come back: see killed_nodes.test."""
import os
import re
import signal
import sys
import time
import unittest
import xmlrpc.client

import rig_run
from rig_run import wait_until

sys.path.insert(0, os.path.join(rig_run.PACKAGE, 'test', 'emulator'))
import sonic_surface  # noqa: E402  pylint: disable=wrong-import-position

CHAIN = ['hand_tracking', 'hand_simulator', 'clay_simulator', 'contact_pressure', 'focal_point_renderer',
         'array_driver']
OTHERS = ['clay_surface', 'robot_state_publisher']
GAP = 0.15  # s, longer than any pause of a sound


def knead(graph, emulator, **arguments):
    rig = graph.rig(dict(dict(hands='bag', file=rig_run.bag('knead'), loop='true', device='sonic_surface',
                              quality='fast',
                              port=emulator.link, max_points='1', head_spl_cap='200'), **arguments))
    wait_until(emulator.sounds, 60, 'a sound; the rig says\n' + graph.words())
    return rig


class Story(unittest.TestCase):
    """A rig that loses its nodes, one after the other."""

    def setUp(self):
        self.graph = rig_run.Graph()
        self.addCleanup(self.graph.__exit__)
        self.graph.__enter__()
        self.emulator = sonic_surface.Emulator(os.path.join(self.graph.folder, 'port'))
        self.addCleanup(self.emulator.__exit__)
        self.emulator.__enter__()

    def pid(self, node):
        """Nothing where it does not answer."""
        try:
            code, _, uri = self.graph.master().lookupNode('/test', '/' + node)
            return xmlrpc.client.ServerProxy(uri).getPid('/test')[2] if code == 1 else None
        except (OSError, xmlrpc.client.Error):
            return None

    def silence(self, since):
        """When the first silence that is no gap between two patterns began and ended; nothing where there was none."""
        swaps = self.emulator.since(since)
        for k, swap in enumerate(swaps):
            sounds = min((later.when for later in swaps[k:] if later.sounds), default=time.monotonic())
            if sounds - swap.when > GAP:
                return swap.when, sounds
        return None

    def lose(self, node, how=signal.SIGKILL, silent_within=1.0):
        """A node is killed or frozen: the array is silent, the node comes back, the others have gone on, it sounds
        again."""
        before = {name: self.pid(name) for name in CHAIN + OTHERS}
        wait_until(self.emulator.sounds, 30, 'a sound')
        since = time.monotonic()
        os.kill(before[node], how)
        wait_until(lambda: self.pid(node) not in (None, before[node]), 20, node + ' again:\n' + self.graph.words())
        back = time.monotonic()
        if node in CHAIN:  # it may be back before what it left behind is too old to sound
            wait_until(lambda: self.silence(since), 5, 'a silence: it sounded all the time')
        wait_until(self.emulator.sounds, 30, 'a sound with the new %s; the rig says\n%s' % (node, self.graph.words()))
        print('%s of %s: back after %.1f s' % (how.name, node, back - since))
        if node in CHAIN:
            silent, sounds = self.silence(since)
            print('%s of %s: silent after %.0f ms, for %.0f ms' %
                  (how.name, node, 1e3 * (silent - since), 1e3 * (sounds - silent)))
            self.assertLess(silent - since, silent_within)
        after = {name: self.pid(name) for name in CHAIN + OTHERS}
        self.assertEqual({name for name in before if before[name] != after[name]}, {node})

    def test_each_node_comes_back(self):
        # No computer holds such a target: the quality goes down, once, since the new clay begins with what held.
        rig = knead(self.graph, self.emulator, target_ms='0.001')
        time.sleep(3.0)  # a checkpoint of the clay, and one more
        for node in CHAIN + OTHERS:
            with self.subTest(node):
                self.lose(node)
        with self.subTest('frozen'):
            self.lose('clay_simulator', signal.SIGSTOP)
        self.assertEqual(len(re.findall(r'the clay continues from its checkpoint at [1-9]', self.graph.words())), 2)

        lowered = re.findall(r"clay_simulator: frames took longer than .*: "
                             r"quality '(\w+)' instead of '(\w+)'; errors to expect",
                             self.graph.words())
        self.assertEqual(lowered, [('draft', 'fast')])
        self.assertEqual(self.graph.master().getParam('/test', '/clay_simulator/quality')[2], 'draft')

        # An emergency stop outlives its driver.
        self.command('/array/stop')
        wait_until(self.emulator.silent_for_good, 5, 'silence')
        driver, since = self.pid('array_driver'), time.monotonic()
        os.kill(driver, signal.SIGKILL)
        wait_until(lambda: self.pid('array_driver') not in (None, driver), 20, 'a driver')
        time.sleep(2.0)
        self.assertFalse([swap for swap in self.emulator.since(since) if swap.sounds])
        self.assertIn('the earlier emergency stop is in force until it is reset', self.graph.words())
        self.command('/array/reset')
        wait_until(self.emulator.sounds, 30, 'a sound')

        # A node that is asked to end does; and the exit code knows of those before.
        _, _, uri = self.graph.master().lookupNode('/test', '/hand_tracking')
        xmlrpc.client.ServerProxy(uri).shutdown('/test', 'the test is over')
        self.assertEqual(rig.wait(30), 3, self.graph.words())
        self.assertTrue(self.emulator.silent_for_good())

    def command(self, service):
        done = self.graph.start(['rosservice', 'call', service])
        self.assertEqual(done.wait(20), 0)


class Nodelets(Story):
    """The manager has all of the chain; a nodelet comes back with it."""

    def test_each_node_comes_back(self):
        rig = knead(self.graph, self.emulator, nodelets='true', quality='auto', target_ms='0.001')
        self.assertIn("quality 'draft' (2 x 8) is the coarsest, and does not hold 0.001 ms", self.graph.words())
        self.assertEqual(self.graph.master().getParam('/test', '/clay_simulator/quality')[2], 'draft')
        manager, since = self.pid('manager'), time.monotonic()
        os.kill(manager, signal.SIGKILL)
        wait_until(lambda: self.pid('manager') not in (None, manager), 20, 'a manager')
        wait_until(lambda: any(swap.sounds for swap in self.emulator.since(since + 1.5)), 40,
                   'a sound; the rig says\n' + self.graph.words())
        self.assertLess(self.silence(since)[0] - since, 1.0)
        self.assertEqual(self.graph.stop(rig), 130)


class Script(unittest.TestCase):
    def test_the_script(self):
        """scripts/rig, which passes Ctrl-C on: suspended, it silences the array until it goes on; killed, it takes all
        with it."""
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


if __name__ == '__main__':
    rig_run.main('killed_nodes')
