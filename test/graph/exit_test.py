#!/usr/bin/env python3
"""Ctrl-C of each node: see exit.test."""
import os
import time
import unittest

import rig_run

PROGRAMS = os.path.join(rig_run.build_space(), 'devel', 'lib', 'tactile_clay')
NODES = {'hand_tracking': ['_source:=none'], 'hand_simulator': [], 'clay_simulator': ['_scene:=kindergarten'],
         'contact_pressure': [], 'focal_point_renderer': [], 'array_driver': ['_device:=debug'],
         # A master knows one provider of a service: two arrays of a namespace would take it from each other.
         'simulated_array': ['array/stop:=simulated/stop', 'array/reset:=simulated/reset']}


class Exit(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.graph = rig_run.Graph()
        cls.addClassCleanup(cls.graph.__exit__)
        cls.graph.__enter__()
        # All run at once, as in a rig.
        cls.running = {node: cls.graph.start([os.path.join(PROGRAMS, node)] + arguments)
                       for node, arguments in NODES.items()}
        rig_run.wait_until(lambda: all(cls.graph.registered('/' + node) for node in NODES), 60, 'seven nodes')
        rig_run.wait_until(lambda: cls.graph.subscribed('/array/focal_points'), 60, 'a graph')
        time.sleep(1)  # they do something

    def interrupt(self, node):
        process = self.running[node]
        self.assertIsNone(process.poll(), 'it had ended before')
        start = time.monotonic()
        self.assertEqual(self.graph.stop(process), 0)
        self.assertLess(time.monotonic() - start, 2.0)
        self.assertFalse(self.graph.registered('/' + node))


class WithoutMaster(unittest.TestCase):
    def test_ctrl_c_while_a_node_waits_for_a_master(self):
        graph = rig_run.Graph()  # not entered: at its address is nobody
        self.addCleanup(graph.__exit__)
        running = {}
        for node in NODES:
            words = open(os.path.join(graph.folder, node), 'w+b')
            self.addCleanup(words.close)
            running[node] = graph.start([os.path.join(PROGRAMS, node)], stdout=words, stderr=words), words

        def said(words):
            words.seek(0)
            return words.read().decode(errors='replace')
        rig_run.wait_until(lambda: all('contact master' in said(words) for _, words in running.values()), 30,
                           'seven nodes that wait')
        for node, (process, words) in running.items():
            with self.subTest(node):
                self.assertEqual(graph.stop(process), 0, said(words))
                self.assertNotIn('FATAL', said(words))


def case(node):
    return lambda self: self.interrupt(node)


for name in NODES:
    setattr(Exit, 'test_' + name, case(name))

if __name__ == '__main__':
    rig_run.main('exit')
