#!/usr/bin/env python3
"""The skeleton of tracked hands: see skeleton.test."""
import statistics
import unittest
from xml.etree import ElementTree

import rig_messages
import rig_run

STATES = '/hands/joint_states_right'
TIP = 10  # of the index finger, in the order of OpenXR


def compose(chain):
    """The position of the last frame of a chain of transforms, in the parent of the first."""
    point = (0.0, 0.0, 0.0)
    for t in reversed(chain):
        shift = (t.translation.x, t.translation.y, t.translation.z)
        point = tuple(a + b for a, b in zip(rig_messages.rotate(t.rotation, point), shift))
    return point


class Skeleton(unittest.TestCase):
    nodelets = 'false'

    @classmethod
    def setUpClass(cls):
        with rig_run.Graph() as graph:
            recording = graph.record(['/hands/tracked', STATES, '/hands/joint_states_left', '/tf', '/tf_static',
                                      '/array/state'])
            # Live, so that robot_state_publisher, which sends by the wall clock, sees all of it, and slowly, since it
            # starts when the hand is known.
            rig = graph.rig({'hands': 'bag', 'file': rig_run.bag('lost_hand'), 'skeleton': 'true', 'quality': 'fast',
                             'rate': '0.3', 'nodelets': cls.nodelets})
            # Not there yet, not known yet, known: the node forgets it when it ends.
            rig_run.wait_until(lambda: rosparam_of(graph, '/hand_right_description'), 60, 'the URDF of the right hand')
            cls.urdf = rosparam_of(graph, '/hand_right_description')
            cls.no_urdf = rosparam_of(graph, '/hand_left_description')
            cls.managed = graph.registered('/manager')
            cls.code = rig.wait(120)
            cls.words = graph.words()
            cls.forgotten = not rosparam_of(graph, '/hand_right_description')
            cls.messages = graph.recorded(recording)
            cls.left = graph.left_processes()

    def test_the_rig_ends(self):
        self.assertEqual((self.code, self.left), (0, []), self.words)
        self.assertTrue(self.forgotten, 'the model of this person is left to the next')
        self.assertEqual(self.managed, self.nodelets == 'true')

    def test_joint_states_are_within_the_limits_of_the_urdf(self):
        robot = ElementTree.fromstring(self.urdf)
        limits = {joint.get('name'): (float(joint.find('limit').get('lower')), float(joint.find('limit').get('upper')))
                  for joint in robot.findall('joint') if joint.get('type') == 'revolute'}
        self.assertEqual(len(limits), 21)
        states = self.messages[STATES]
        seen = [m.header.stamp for m in self.messages['/hands/tracked'] if m.hands]
        self.assertGreater(len(states), 0.8 * (len(seen) - 29))
        self.assertLessEqual({state.header.stamp for state in states}, set(seen[29:]))
        for state in states:
            self.assertEqual(set(state.name), set(limits))
            for name, angle in zip(state.name, state.position):
                low, high = limits[name]
                self.assertTrue(low - 1e-6 <= angle <= high + 1e-6, (name, angle))
        self.assertFalse(self.no_urdf, 'a hand that nobody saw has a model')
        self.assertEqual(self.messages['/hands/joint_states_left'], [])

    def test_robot_state_publisher_puts_the_fingertip_where_it_is_tracked(self):
        tracked = self.messages.by_stamp('/hands/tracked')
        static = {t.child_frame_id: t for m in self.messages['/tf_static'] for t in m.transforms}
        moving = {}
        for message in self.messages['/tf']:
            for t in message.transforms:
                moving.setdefault(t.header.stamp.to_nsec(), {})[t.child_frame_id] = t
        errors = []
        for stamp, transforms in moving.items():
            chain, frame = [], 'hand_right_index_tip'
            while frame != 'world':
                link = transforms.get(frame, static.get(frame))
                if link is None or not frame.startswith('hand_right_'):
                    break
                chain.insert(0, link.transform)
                frame = link.header.frame_id
            if frame == 'world' and stamp in tracked and tracked[stamp].hands:
                p = tracked[stamp].hands[0].joints[TIP].position
                errors.append(1e3 * rig_messages.distance(compose(chain), (p.x, p.y, p.z)))
        self.assertGreater(len(errors), 20, 'robot_state_publisher sent next to nothing')
        print('index tip: %d samples, median %.2f mm, most %.2f mm' %
              (len(errors), statistics.median(errors), max(errors)))
        self.assertLess(statistics.median(errors), 3.0)

    def test_a_lost_hand_is_cut_off_from_the_world(self):
        parents = [(t.header.stamp, t.header.frame_id) for m in self.messages['/tf'] for t in m.transforms
                   if t.child_frame_id == 'hand_right_wrist']
        seen = max(m.header.stamp for m in self.messages['/hands/tracked'] if m.hands)
        self.assertEqual([parent for stamp, parent in parents if stamp > seen], ['hand_right_lost'])
        self.assertEqual({parent for stamp, parent in parents if stamp <= seen}, {'world'})


class SkeletonAsNodelet(Skeleton):
    nodelets = 'true'


class NoSkeleton(unittest.TestCase):
    def test_without_the_argument_it_does_not_exist(self):
        with rig_run.Graph() as graph:
            rig = graph.rig({'hands': 'bag', 'file': rig_run.bag('lost_hand'), 'quality': 'fast', 'duration': '2'})
            rig_run.wait_until(lambda: graph.subscribed('/hands/skin'), 60, 'a rig')
            for node in ('/hand_skeleton', '/hand_left_state_publisher', '/hand_right_state_publisher'):
                self.assertFalse(graph.registered(node), node)
            self.assertEqual(rig.wait(60), 0, graph.words())
            self.assertNotIn('process[hand_skeleton', graph.words())


def rosparam_of(graph, name):
    code, _, value = graph.master().getParam('/test', name)
    return value if code == 1 else None


if __name__ == '__main__':
    rig_run.main('skeleton')
