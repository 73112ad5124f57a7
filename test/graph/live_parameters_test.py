#!/usr/bin/env python3
"""Parameters that change while the rig runs, by dynparam: see live_parameters.test.

The run is a lockstep one. One of its nodes is stopped (SIGSTOP) while the command line is at work: what is asked for
then holds from one frame on.
"""
import contextlib
import os
import shutil
import signal
import subprocess
import tempfile
import time
import unittest
import xmlrpc.client

import rosbag
import roslib.packages
import yaml

import rig_run

REPLAY = roslib.packages.find_node('tactile_clay', 'replay')[0]
DYNPARAM = roslib.packages.find_node('dynamic_reconfigure', 'dynparam')[0]
MATERIAL = 'modelling_clay'  # of kindergarten


class Rig:
    """A lockstep run that is recorded, in a graph of its own."""

    def __init__(self, graph, bag, **arguments):
        self.graph, self.pid = graph, None
        self.process = graph.rig(dict(rig_run.LOCKSTEP, modulation='am', hands='bag', file=rig_run.bag('knead'),
                                      record=bag,
                                      quality='accurate', clean='true', duration='5', **arguments))

    def command(self, *words, code=0):
        """What a command line tool says, which ends with this code."""
        done = subprocess.run(words, env=self.graph.environment, cwd=self.graph.folder, stdin=subprocess.DEVNULL,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=60, check=False)
        if (done.returncode == 0) != (code == 0):
            raise AssertionError('%s ended with %d:\n%s' % (' '.join(words), done.returncode, done.stdout))
        return done.stdout

    def dynparam(self, *words, **options):
        return self.command(DYNPARAM, *words, **options)

    def wait_for_frames(self, count):
        self.command('rostopic', 'echo', '-n', str(count), '/array/state/frames_sent')
        code, _, uri = self.graph.master().lookupNode('/test', '/contact_pressure')
        if code != 1:
            raise AssertionError('no /contact_pressure:\n' + self.graph.words())
        self.pid = xmlrpc.client.ServerProxy(uri).getPid('/test')[2]

    @contextlib.contextmanager
    def held(self):
        """Between two frames: the node that has no parameters of this kind is stopped meanwhile. Not for longer than
        lockstep waits for an answer."""
        os.kill(self.pid, signal.SIGSTOP)
        time.sleep(0.2)  # what is on its way arrives
        try:
            yield
        finally:
            os.kill(self.pid, signal.SIGCONT)
        time.sleep(0.1)  # some frames


def changes_in(bag):
    """{node: [(stamp in ns, values)]} of rig/changes"""
    changes = {}
    with rosbag.Bag(bag) as opened:
        for _, message, _ in opened.read_messages('/rig/changes'):
            changes.setdefault(message.node, []).append((message.header.stamp.to_nsec(),
                                                         yaml.safe_load(message.parameters)))
    return changes


def replay(bag):
    done = subprocess.run([REPLAY, bag], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                          text=True, timeout=200, check=False)
    return done.returncode, done.stdout.splitlines()


class LiveParameters(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.mkdtemp(prefix='live_parameters_')
        cls.addClassCleanup(shutil.rmtree, cls.folder, ignore_errors=True)
        cls.bag = os.path.join(cls.folder, 'run.bag')
        saved = os.path.join(cls.folder, 'saved.yaml')
        with rig_run.Graph() as graph:
            rig = Rig(graph, cls.bag)
            rig.wait_for_frames(20)
            with rig.held():
                rig.dynparam('set', '/focal_point_renderer', 'max_points', '1')
                rig.dynparam('set', '/focal_point_renderer', "{modulation: lateral, full_scale_pressure: 2e5}")
                rig.dynparam('set', '/clay_simulator', "{quality: fast, %s/viscosity: 150.5}" % MATERIAL)
                rig.dynparam('set', '/simulated_array', 'pressure_cap', '700')
            # Refused, each with its line; nothing of a set that is wrong holds.
            for wrong in ((('focal_point_renderer', '{max_points: 300}'),
                           ('focal_point_renderer', '{modulation: field}'),
                           ('focal_point_renderer', '{sigma: 0.0, max_points: 3}')),
                          (('clay_simulator', '{quality: best}'),
                           ('clay_simulator', '{%s/flow_index: 0.0, substeps: 2}' % MATERIAL),
                           ('simulated_array', '{pressure_cap: 2500.0}'),
                           ('hand_tracking', '{prediction: 0.03}'))):
                with rig.held():
                    for node, values in wrong:
                        rig.dynparam('set', '/' + node, values, code=1)
            rig.wait_for_frames(60)
            with rig.held():
                rig.dynparam('dump', '/focal_point_renderer', saved)
                rig.dynparam('set', '/focal_point_renderer', 'max_points', '5')
                rig.dynparam('set', '/clay_simulator', 'sleeping', 'false')
            with rig.held():
                rig.dynparam('load', '/focal_point_renderer', saved)
                rig.dynparam('set', '/hand_tracking', 'position_min_cutoff', '1.5')
                rig.dynparam('set', '/simulated_array', 'pressure_cap', '2000')
                cls.nodes = rig.dynparam('list').split()
                cls.server = yaml.safe_load(rig.command('rosparam', 'get', '/focal_point_renderer'))
            code = rig.process.wait(100)
            cls.words = graph.words()
        if code != 0:
            raise AssertionError(cls.words)
        with open(saved) as file:
            cls.saved = yaml.load(file, yaml.UnsafeLoader)
        cls.changes = changes_in(cls.bag)
        cls.messages = rig_run.Messages(cls.bag)

    def test_each_node_that_has_some_tells_them(self):
        self.assertEqual(sorted(self.nodes), ['/clay_simulator', '/focal_point_renderer', '/hand_tracking',
                                              '/simulated_array'])
        told = self.messages['/clay_simulator/parameter_descriptions']
        self.assertEqual(told, [])  # ranges are of the program, not of the run
        self.assertGreater(len(self.messages['/clay_simulator/parameter_updates']), 1)

    def test_a_change_is_recorded_with_the_frame_from_which_it_holds(self):
        stamps = self.messages.stamps('/hands/tracked')
        first = self.changes['focal_point_renderer'][0]
        self.assertEqual(first[1], {'max_points': 1, 'modulation': 'lateral', 'full_scale_pressure': 200000.0})
        for node, expected in (('clay_simulator', {'quality': 'fast', MATERIAL + '/viscosity': 150.5}),
                               ('simulated_array', {'pressure_cap': 700.0})):
            stamp, values = self.changes[node][0]
            self.assertEqual(values, expected, node)
            self.assertIn(stamp, stamps[20:])
            self.assertLessEqual(abs(stamps.index(stamp) - stamps.index(first[0])), 1, node)
        self.assertEqual([values for _, values in self.changes['focal_point_renderer'][1:]],
                         [{'max_points': 5}, {'max_points': 1}])
        self.assertEqual(self.changes['simulated_array'][1][1], {'pressure_cap': 2000.0})
        self.assertEqual(self.changes['clay_simulator'][1][1], {'sleeping': False})
        self.assertEqual([values for _, values in self.changes['hand_tracking']], [{'position_min_cutoff': 1.5}])

    def test_a_change_is_felt_from_its_frame_on(self):
        at = [stamp for stamp, _ in self.changes['focal_point_renderer']]
        for stamp, message in self.messages.by_stamp('/array/focal_points').items():
            self.assertEqual(message.modulation, 1 if stamp >= at[0] else 0)
            if at[0] <= stamp < at[1]:
                self.assertLessEqual(len(message.points), 1)
        lowered, raised = [stamp for stamp, _ in self.changes['simulated_array']]
        loudest = {True: 0.0, False: 0.0}
        for stamp, message in self.messages.by_stamp('/array/acoustics').items():
            capped = lowered <= stamp < raised
            loudest[capped] = max([loudest[capped], *message.achieved])
        self.assertGreater(loudest[False], 1.1 * 700.0)
        self.assertGreater(loudest[True], 0.5 * 700.0)
        self.assertLess(loudest[True], 1.01 * 700.0)

    def test_saved_and_loaded(self):
        self.assertEqual(self.saved['max_points'], 1)
        self.assertEqual(self.saved['full_scale_pressure'], 2e5)
        # The parameter server tells what holds.
        self.assertEqual(self.server['full_scale_pressure'], 2e5)

    def test_what_is_wrong_is_refused_with_the_words_of_the_start(self):
        for words in ('parameter /focal_point_renderer/max_points: expected a number from 1 to 256, got 300',
                      'parameter /focal_point_renderer/modulation: points cannot become a field',
                      "quality 'best' not found, expected one of: ",
                      "flow_index of material '%s' is 0.000000, expected > 0, at most 1" % MATERIAL,
                      'parameter /simulated_array/pressure_cap: expected a number from 1 to 2000, got 2500: the gate '
                      'is never made less strict than at its start',
                      'parameter /hand_tracking/prediction: expected a number from 0 to 0.02, got 0.03'):
            lines = [line for line in self.words.splitlines() if words in line]
            self.assertEqual(len(lines), 1, words)
            self.assertIn('no parameter was changed', lines[0])
        for values in self.changes['clay_simulator']:
            self.assertNotIn('substeps', values[1])
        with rig_run.Graph() as graph:
            for program, name, value in (('focal_point_renderer', 'max_points', '300'),
                                         ('clay_simulator', MATERIAL + '/flow_index', '0.0')):
                graph.master().setParam('/test', '/%s/%s' % (program, name), yaml.safe_load(value))
                done = subprocess.run([roslib.packages.find_node('tactile_clay', program)[0]], env=graph.environment,
                                      capture_output=True, text=True, timeout=60, check=False)
                self.assertEqual(done.returncode, 1)
                said = [line.split(': ', 1)[1] for line in done.stderr.splitlines() if 'expected' in line][0]
                self.assertIn(said.replace('\x1b[0m', ''), self.words)
                graph.master().deleteParam('/test', '/%s/%s' % (program, name))

    def test_replay_makes_the_same_changes(self):
        code, lines = replay(self.bag)
        self.assertEqual(code, 0, '\n'.join(lines))
        self.assertIn('replay: parameters change at their frames: clay_simulator, 2 times, focal_point_renderer, 3 '
                      'times, simulated_array, 2 times', lines)

    def changed(self, name, change):
        path = os.path.join(self.folder, name + '.bag')
        with rosbag.Bag(self.bag) as bag, rosbag.Bag(path, 'w') as copy:
            for topic, message, when in bag.read_messages():
                if change(topic, message):
                    copy.write(topic, message, when)
        return path

    def test_replay_is_honest_about_changes(self):
        def other(topic, message):
            if topic == '/rig/changes':
                message.parameters = message.parameters.replace('150.5', '151.5')
            return True
        code, lines = replay(self.changed('other', other))
        self.assertEqual(code, 1, '\n'.join(lines))
        stamp = self.changes['clay_simulator'][0][0]
        told = lines[-1].split(' at ')[1].split(' s: ')[0].replace('.', '')
        self.assertGreaterEqual(int(told), stamp)
        code, lines = replay(self.changed('none', lambda topic, _: topic != '/rig/changes'))
        self.assertEqual(code, 2)
        self.assertIn('parameters were changed during the run', lines[-1])
        code, lines = replay(self.changed('lost', lambda topic, message: topic != '/rig/changes' or
                                          message.header.seq != 1))
        self.assertEqual(code, 2)
        self.assertIn('lacks changes of parameters', lines[-1])


if __name__ == '__main__':
    rig_run.main('live_parameters')
