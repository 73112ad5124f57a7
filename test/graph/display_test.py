#!/usr/bin/env python3
"""What the default view shows: see display.test."""
import copy
import math
import os
import struct
import types
import unittest

import rosbag
import roslib.packages

import rig_messages
import rig_run
from rviz_window import (BACKGROUND, CONFIG, HANDS, OVERLAY, PATIENCE, WIDTH, Camera, Window, differs, drawn,
                         has_strong_colours, kneading, places, publish, silhouette)


def on_the_bar(share):
    """Place of a share of the full scale on the colour bar of the hands, m."""
    return 0.10, 0.30, 0.01 + 0.13 * share


def samples(cloud):
    """(pressure in Pa, place in the array's frame) of each sample of hands/pressure."""
    return [(pressure, types.SimpleNamespace(x=x, y=y, z=z))
            for pressure, x, y, z in rig_messages.columns(cloud, 'pressure', 'x', 'y', 'z')]


class Display(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.run_of_bag, cls.last = kneading()
        cls.camera = Camera(CONFIG)
        cls.last['/array/state'].emitting = False
        cls.clay, cls.hands, cls.sound, cls.silence = cls.show(['/clay/particles'], HANDS, ['/array/focal_points'],
                                                               ['/array/state'])

    @classmethod
    def show(cls, *steps):
        """Pictures of the default view as topics of the moment are added step by step."""
        pictures, topics = [], ['/tf_static']
        with rig_run.Graph() as graph:
            window = Window(graph)
            for node in ('clay_surface', 'hand_surface'):
                graph.start([roslib.packages.find_node('tactile_clay', node)[0]])
            for k, step in enumerate(steps):
                topics += step
                publisher = publish(graph, cls.last, topics)
                before = pictures[-1] if pictures else None
                pictures.append(window.settled(
                    lambda picture: drawn(picture) > 5000 and
                    (before is None or any(differs(picture[x, y], before[x, y]) for y in range(OVERLAY[1])
                                           for x in range(WIDTH)))))
                pictures[-1].save(os.path.join(os.environ.get('ROS_HOME', graph.folder),
                                               'step%d.png' % k))  # for who looks
                graph.stop(publisher)
            with open('/proc/%d/environ' % window.rviz.pid, 'rb') as environment:
                cls.environment = environment.read()
            with open(os.path.join(graph.folder, 'rviz.log')) as log:
                cls.log = log.read()
        return pictures

    def test_silhouette_of_the_clay(self):
        expected = silhouette(places(self.last['/clay/particles']), self.camera)
        shown = {at for at in self.clay.pixels(lambda color: differs(color, BACKGROUND))
                 if at[0] > OVERLAY[0] or at[1] < OVERLAY[1]}
        self.assertGreater(len(expected & shown) / len(expected | shown), 0.9)

    def test_rviz_keeps_the_memory_that_it_frees(self):
        """Without this it spends a third of its time on getting the memory of large messages back."""
        self.assertIn(b'trim_threshold', self.environment)

    def test_rviz_misses_no_package(self):
        self.assertIn('OpenGl version', self.log)
        self.assertNotIn('[rospack] Error', self.log)

    def test_state_of_the_rig(self):
        panel = self.clay.pixels(lambda color: min(color) > 247)
        self.assertGreater(len([at for at in panel if at[0] < OVERLAY[0] and at[1] > OVERLAY[1]]), 1500)

    def test_each_body_has_its_colour(self):
        has_strong_colours(self, self.clay)

    def test_colour_bar(self):
        ends = {0.05: (255, 237, 115), 0.33: (255, 160, 30), 0.65: (222, 40, 42), 0.97: (105, 5, 57)}
        for share, color in ends.items():
            x, y, _ = self.camera.project(on_the_bar(share))
            self.assertTrue(any(not differs(seen, color, 30) for seen in self.hands.around((x, y), 2)), (share, color))

    def test_hands_seldom_cover_the_colour_bar(self):
        """In at most 15 % of the frames of a bag, where hands are balls about their joints."""
        bar = [self.camera.project(on_the_bar(0.2 * k)) for k in range(6)]
        for name in ('knead', 'potter'):
            covered = []
            with rosbag.Bag(rig_run.bag(name)) as bag:
                for _, message, _ in bag.read_messages('/hands/tracked'):
                    balls = [(self.camera.project((joint.position.x, joint.position.y, joint.position.z)), radius)
                             for hand in message.hands for joint, radius in zip(hand.joints, hand.radii)]
                    covered.append(any(math.hypot(x - at[0], y - at[1]) < radius * scale
                                       for (x, y, scale), radius in balls for at in bar))
            self.assertGreater(len(covered), 100)
            self.assertLess(sum(covered) / len(covered), 0.15, name)

    def test_pressure_is_seen(self):
        """The middle of a contact, through the hand and above the clay: red, as from half of the full scale on. At its
        rim the skin is yellow and orange."""
        to_world = rig_messages.array_to_world(self.run_of_bag)
        pressure, place = max(samples(self.last['/hands/pressure']), key=lambda sample: sample[0])
        self.assertGreater(pressure, 20000.0)
        x, y, _ = self.camera.project(to_world(place))
        red = lambda picture: len([color for color in picture.around((x, y), 12) if color[0] - color[1] > 110])
        self.assertLess(red(self.clay), 10)
        self.assertGreater(red(self.hands), 60, 'pixels of 625')

    def test_every_pressed_place_is_painted(self):
        """Skin in the colours of pressure beside each sample of a fifth of the full scale, and beside one in the notch
        between the balls of wrist and thumb, which the drawn heel covers."""
        last = dict(self.last)
        last['/hands/pressure'] = self.with_pressed_heel()
        with rig_run.Graph() as graph:
            graph.start([roslib.packages.find_node('tactile_clay', 'hand_surface')[0]])
            recording = graph.record(['/hands/surface'])
            publish(graph, last, ['/tf_static'] + list(HANDS))
            written = recording[1] + '.active'
            rig_run.wait_until(lambda: os.path.exists(written) and os.path.getsize(written) > 5e6, PATIENCE,
                               'hands/surface')
            markers = graph.recorded(recording)['/hands/surface'][-1].markers
        painted = [(p.x, p.y, p.z) for m in markers if m.ns in ('skin', 'skin that touches')
                   for p, color in zip(m.points, m.colors) if color.r - color.b > 0.45]
        to_world, checked = rig_messages.array_to_world(self.run_of_bag), 0
        for pressure, place in samples(last['/hands/pressure']):
            if pressure < 8000.0:
                continue
            nearest = min(math.dist(to_world(place), corner) for corner in painted)
            self.assertLess(nearest, 0.008, '%.0f Pa at %s' % (pressure, place))
            checked += 1
        self.assertGreater(checked, 10)
        heel = to_world(place)  # the last sample; were it painted as far below the skin as it is, 0.76
        strongest = max(c.r - c.b for m in markers if m.ns in ('skin', 'skin that touches')
                        for p, c in zip(m.points, m.colors) if math.dist(heel, (p.x, p.y, p.z)) < 0.008)
        self.assertGreater(strongest, 0.85, 'as strong as on open skin')

    def with_pressed_heel(self):
        """hands/pressure with one more sample, at the bottom of the notch on the side of the palm."""
        WRIST, THUMB = 1, 2
        hand = self.last['/hands/tracked'].hands[0]
        at = [(p.position.x, p.position.y, p.position.z) for p in hand.joints]
        length = math.dist(at[WRIST], at[THUMB])
        axis = [(b - a) / length for a, b in zip(at[WRIST], at[THUMB])]
        # Where the two balls meet: a circle about the axis.
        along = (length ** 2 + hand.radii[WRIST] ** 2 - hand.radii[THUMB] ** 2) / (2.0 * length)
        radius = math.sqrt(hand.radii[WRIST] ** 2 - along ** 2)
        palmar = rig_messages.rotate(hand.joints[0].orientation, (0.0, -1.0, 0.0))
        share = sum(a * b for a, b in zip(axis, palmar))
        normal = [b - share * a for a, b in zip(axis, palmar)]
        normal = [c / math.hypot(*normal) for c in normal]
        place = [c + along * a + radius * n for c, a, n in zip(at[WRIST], axis, normal)]
        array = next(t.transform for t in self.last['/tf_static'].transforms if t.child_frame_id == 'array')
        q, shift = array.rotation, array.translation
        back = types.SimpleNamespace(x=-q.x, y=-q.y, z=-q.z, w=q.w)
        place = rig_messages.rotate(back, [c - s for c, s in zip(place, (shift.x, shift.y, shift.z))])
        values = dict(zip(('x', 'y', 'z'), place), pressure=20000.0)
        values.update(zip(('normal_x', 'normal_y', 'normal_z'), rig_messages.rotate(back, normal)))
        cloud = copy.deepcopy(self.last['/hands/pressure'])
        row = bytearray(cloud.data[:cloud.point_step])
        for field in cloud.fields:
            if field.name in values:
                struct.pack_into('<f', row, field.offset, values[field.name])
        cloud.data = bytes(cloud.data) + bytes(row)
        cloud.width += 1
        cloud.row_step = cloud.width * cloud.point_step
        return cloud

    def test_focal_points(self):
        to_world = rig_messages.array_to_world(self.run_of_bag)
        points = self.last['/array/focal_points'].points
        self.assertTrue(points)
        for point in points:
            x, y, _ = self.camera.project(to_world(point.position))
            changed = [a for a, b in zip(self.sound.around((x, y), 2), self.hands.around((x, y), 2)) if differs(a, b)]
            self.assertGreater(len(changed), 12, 'a focal point at %d, %d' % (x, y))
            coloured = lambda picture: [c for c in picture.around((x, y), 2) if max(c) - min(c) > 40]
            self.assertGreater(len(coloured(self.sound)), 12, 'that sounds, at %d, %d' % (x, y))
            self.assertLess(len(coloured(self.silence)), 6, 'of a silent array, at %d, %d' % (x, y))


if __name__ == '__main__':
    rig_run.main('display')
