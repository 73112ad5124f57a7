#!/usr/bin/env python3
"""Several runs on one master: see rigs.test."""
import glob
import os
import re
import shutil
import subprocess
import threading
import time
import unittest
import xml.etree.ElementTree
from xmlrpc.server import SimpleXMLRPCServer

import rosbag

import rig_run

PROGRAMS = os.path.join(rig_run.build_space(), 'devel', 'lib', 'tactile_clay')
NODES = ('hand_tracking', 'hand_simulator', 'clay_simulator', 'contact_pressure', 'focal_point_renderer',
         'array_driver',
         'robot_state_publisher', 'record')
# Of no type that a node reads: whoever reads it ends with a line.
POISON = {'poison': {'poison': 1}}


def parameters_in_source():
    """Names of the parameters that nodes read."""
    keys = set()
    reading = (r'\b(?:param|paramIn|poseParam|pointParam)(?:<[^()]*>)?\(\s*\w+,\s*"(\w+)"',
               r'\b(?:text|whole|number|truth)\(\s*"(\w+)",',  # that may change while the node runs
               r'\{"(\w+)", &SafetyGateConfig::')  # limits of the gate
    for path in glob.glob(os.path.join(rig_run.PACKAGE, 'src', 'nodes', '*.cpp')) + [
            os.path.join(rig_run.PACKAGE, 'src', 'device', 'safety_limits.h')]:
        with open(path) as source:
            text = source.read()
            for pattern in reading:
                keys.update(re.findall(pattern, text))
    return keys


class OneAfterTheOther(unittest.TestCase):
    def test_a_run_reads_nothing_of_an_earlier_one_and_takes_files_of_any_name(self):
        keys = parameters_in_source()
        self.assertGreater(len(keys), 50)
        self.assertTrue({'head_spl_cap', 'gate_without', 'full_scale_pressure', 'recorder', 'graph', 'quality'} <= keys)
        with rig_run.Graph() as graph:
            for node in NODES:
                for key in keys | {'other'}:
                    graph.master().setParam('/test', '/%s/%s' % (node, key), POISON)
            # The tf prefix that robot_state_publisher would look for.
            graph.master().setParam('/test', '/tf_prefix', 'poison')
            folder = os.path.join(graph.folder, 'Anna\'s "$(5)" & \u00fc; ~')
            os.mkdir(folder)
            shutil.copy(rig_run.bag('no_hands'), os.path.join(folder, 'hands.bag'))
            rig = graph.rig(dict(lockstep='true', hands='bag', file='hands.bag', device='debug', duration='0.5',
                                 quality='fast',
                                 record='new folder/run'), cwd=folder)
            self.assertEqual(rig.wait(100), 0, graph.words())
            left = [name for name in graph.master().getParamNames('/test')[2] if 'poison' in name or '/other' in name]
            self.assertEqual(left, [])
            self.assertRegex(graph.words(),
                             r'/array_driver: the safety gate allows at most 2000 Pa .*, 110 dB at the head')
            with rosbag.Bag(os.path.join(folder, 'new folder', 'run.bag')) as bag:
                self.assertGreater(bag.get_message_count('/array/state'), 20)
                frames = {one.child_frame_id
                          for _, message, _ in bag.read_messages('/tf_static') for one in message.transforms}
            self.assertTrue({'tracker', 'array'} <= frames)
            self.assertFalse([name for name in frames if 'poison' in name], frames)
            again = graph.rig(dict(hands='none', record=os.path.join(folder, 'new folder', 'run')), cwd=folder)
            self.assertNotEqual(again.wait(60), 0)
            self.assertIn("run.bag' exists already", graph.words())


class AtOnce(unittest.TestCase):
    def test_a_second_rig_harms_nobody(self):
        with rig_run.Graph() as graph:
            first = graph.rig(dict(hands='none', quality='fast'))
            rig_run.wait_until(lambda: graph.subscribed('/array/focal_points') or first.poll() is not None, 60, 'a rig')
            time.sleep(1)
            self.refused_by_name(graph)
            self.assertIsNone(first.poll(), graph.words())
            self.beside_in_a_namespace(graph)
            self.assertIsNone(first.poll(), graph.words())
            # Whoever starts a program by hand replaces a node: that is no good end.
            graph.start([os.path.join(PROGRAMS, 'hand_simulator')])
            self.assertEqual(first.wait(60), 1, graph.words())
            self.assertIn('another node took the name /hand_simulator', graph.words())

    def refused_by_name(self, graph):
        words = graph.words()
        second = graph.rig(dict(hands='none', duration='1'))
        self.assertNotEqual(second.wait(60), 0)
        said = graph.words()[len(words):]
        self.assertIn('nodes of a rig run on this master already, such as /hand_tracking (process ', said)
        self.assertNotIn('started with pid', said)
        # In a namespace that roslaunch tells to its nodes alone, each of them asks.
        command = [os.path.join(PROGRAMS, 'unless_running'), 'echo', 'started', '__name:=robot_state_publisher']
        done = subprocess.run(command, env=graph.environment, capture_output=True, text=True, timeout=60, check=False)
        self.assertEqual((done.returncode, done.stdout), (1, ''))
        self.assertIn('/robot_state_publisher', done.stderr)
        done = subprocess.run(command, env=dict(graph.environment, ROS_NAMESPACE='lab'), capture_output=True, text=True,
                              timeout=60, check=True)
        self.assertEqual(done.stdout, 'started __name:=robot_state_publisher\n')

    def beside_in_a_namespace(self, graph):
        path = os.path.join(graph.folder, 'beside.bag')
        rig = graph.rig(dict(hands='choreography', file='tour', lockstep='true', duration='0.3', quality='fast',
                             record=path,
                             tracker_pose='0 0 1 0 0 0'), environment={'ROS_NAMESPACE': 'beside'})
        self.assertEqual(rig.wait(100), 0, graph.words())
        with rosbag.Bag(path) as bag:
            topics = set(bag.get_type_and_topic_info().topics)
            heights = [one.transform.translation.z for _, message, _ in bag.read_messages('/beside/tf_static')
                       for one in message.transforms if one.child_frame_id == 'tracker']
        self.assertEqual({name for name in topics if not name.startswith('/beside/')} - {'/diagnostics'}, set())
        self.assertTrue({'/beside/tf', '/beside/array/state'} <= topics)
        self.assertEqual(set(heights), {1.0})


class Master(unittest.TestCase):
    """What preflight finds on a master."""

    def preflight(self, graph, *arguments):
        done = subprocess.run([os.path.join(PROGRAMS, 'preflight'), 'starts:=true', *arguments], env=graph.environment,
                              capture_output=True, text=True, timeout=60, check=False)
        self.assertLessEqual(len(done.stderr.splitlines()), 1)
        return done.returncode, done.stderr

    def test_the_robot_model_is_all_that_preflight_prints(self):
        """Also where a source has something to say, as of a bag that was recorded in a namespace."""
        with rig_run.Graph() as graph:
            path = os.path.join(graph.folder, 'lab.bag')
            with rosbag.Bag(rig_run.bag('press_finger')) as read, rosbag.Bag(path, 'w') as written:
                for _, message, when in read.read_messages('/hands/tracked'):
                    written.write('/lab/hands/tracked', message, when)
            done = subprocess.run([os.path.join(PROGRAMS, 'preflight'), 'hands:=bag', 'file:=' + path],
                                  env=graph.environment,
                                  capture_output=True, text=True, timeout=60, check=False)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertIn('plays the hands of its topic /lab/hands/tracked', done.stderr)
            self.assertEqual(xml.etree.ElementTree.fromstring(done.stdout).tag, 'robot')

    def test_use_sim_time_without_a_clock(self):
        with rig_run.Graph() as graph:
            graph.master().setParam('/test', '/use_sim_time', True)
            code, line = self.preflight(graph, 'hands:=none')
            self.assertEqual(code, 1)
            self.assertIn('use_sim_time is true on this master, and nobody publishes /clock', line)
            self.assertEqual(self.preflight(graph, 'hands:=none', 'lockstep:=true'), (0, ''))
            self.assertEqual(self.preflight(graph, 'hands:=topic'), (0, ''))
            graph.master().registerPublisher('/clock_source', '/clock', 'rosgraph_msgs/Clock', 'http://localhost:1/')
            self.assertEqual(self.preflight(graph, 'hands:=none'), (0, ''))

    def test_every_node_of_the_launch_is_looked_for(self):
        variants = ({}, dict(device='sonic_surface', wire='/tmp/boards', skeleton='true', record='true',
                             nodelets='true'))
        with rig_run.Graph() as graph, SimpleXMLRPCServer(('localhost', 0), logRequests=False) as node:
            node.register_function(lambda *_: [1, '', 7], 'getPid')
            threading.Thread(target=node.serve_forever, daemon=True).start()
            uri = 'http://localhost:%d/' % node.server_address[1]
            for variant in variants:
                arguments = ['rviz:=false'] + ['%s:=%s' % item for item in variant.items()]
                launched = subprocess.run(['roslaunch', '--nodes', 'tactile_clay', 'rig.launch', *arguments],
                                          check=True,
                                          env=graph.environment, cwd=graph.folder, stdout=subprocess.PIPE,
                                          text=True).stdout.split()
                self.assertGreater(len(launched), 6)
                for name in launched + ['/not_ours']:
                    graph.master().registerPublisher(name, '/some/topic', '*', uri)
                code, line = self.preflight(graph, *arguments)
                self.assertEqual(code, 1)
                self.assertEqual(sorted(re.search(r'\(rosnode kill (.*?)\)', line).group(1).split()), sorted(launched))
                for name in launched:
                    graph.master().unregisterPublisher(name, '/some/topic', uri)
            node.shutdown()

    def test_a_node_that_was_killed_or_is_frozen(self):
        with rig_run.Graph() as graph:
            graph.master().registerPublisher('/hand_tracking', '/some/topic', '*', 'http://localhost:1/')
            self.assertEqual(self.preflight(graph), (0, ''), 'nobody listens there')
            with rig_run.socket.create_server(('localhost', 0)) as silent:
                uri = 'http://localhost:%d/' % silent.getsockname()[1]
                graph.master().registerPublisher('/hand_tracking', '/some/topic', '*', uri)
                code, line = self.preflight(graph)
            self.assertEqual(code, 1)
            self.assertIn('/hand_tracking (frozen, on localhost)', line)


if __name__ == '__main__':
    rig_run.main('rigs')
