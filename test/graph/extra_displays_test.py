#!/usr/bin/env python3
"""What displays show that are off by default: see extra_displays.test."""
import math
import os
import re
import sys
import unittest

import numpy
import roslib.packages
from sensor_msgs import point_cloud2
from sensor_msgs.msg import PointField
from std_msgs.msg import Header

import rig_messages
import rig_run
from rviz_window import BACKGROUND, HANDS, PATIENCE, Camera, Window, differs, drawn, kneading, publish

sys.path.insert(0, os.path.join(rig_run.PACKAGE, 'test', 'emulator'))
import acoustic_field  # noqa: E402

MOMENT = '3.24'  # s into the bag; fingers press with their pads, too
PAD = 0.008      # m, radius of a finger pad
# Colours at equal distances from 0 to the full scale: of pressure, and of sound.
STOPS = [(1.0, 0.93, 0.45), (1.0, 0.62, 0.10), (0.86, 0.14, 0.16), (0.38, 0.0, 0.22)]
SOUND_STOPS = [(5, 5, 26), (64, 18, 115), (184, 48, 107), (247, 133, 77), (252, 245, 191)]
FULL, RANGE = 500.0, 40.0  # Pa and dB, of the slice
LENGTH = 0.01              # m, of the arrow of 1 N


def color_at(stops, share):
    """The colour at a share of the full scale, 0 to 1."""
    at = (len(stops) - 1) * min(max(share, 0.0), 1.0)
    k = min(len(stops) - 2, int(at))
    return [a + (at - k) * (b - a) for a, b in zip(stops[k], stops[k + 1])]


def contacts(forces):
    """clay/contacts with these ((x, y, z), (fx, fy, fz)): m, and N of the clay on the skin."""
    names = ('x', 'y', 'z', 'fx', 'fy', 'fz')
    fields = [PointField(name, 4 * k, PointField.FLOAT32, 1) for k, name in enumerate(names)]
    return point_cloud2.create_cloud(Header(frame_id='world'), fields, [at + force for at, force in forces])


class ExtraDisplays(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.run_of_bag, cls.last = kneading(MOMENT)

    def moment(self, graph, topics):
        """Publishes the topics' messages of the moment in a graph, latched."""
        publish(graph, self.last, ['/tf_static'] + topics)

    def sources(self):
        """Place and phase of each transducer for acoustic_field, and the amplitude that they have in common."""
        drive = self.last['/array/drive']
        self.assertLess(max(drive.amplitude) - min(drive.amplitude), 1e-5)
        lines = next(m for m in self.last['/array/geometry'].markers if m.ns == 'directions of the transducers')
        faces = lines.points[1::2]
        self.assertEqual(len(faces), len(drive.phase))
        return [(at.x, at.y, phase) for at, phase in zip(faces, drive.phase)], drive.amplitude[0]

    def slice(self, name, **properties):
        """A picture of the slice through the strongest focal point. Returns a function from a place in it, (y, z) in
        the frame of the array, to the acoustic pressure of an independent sum there, Pa, and the pixels around it."""
        with rig_run.Graph() as graph:
            window = Window(graph, only={'Slice of the sound': dict(properties, **{'Alpha': 1, 'Full scale': FULL})},
                            camera=dict(yaw=math.pi, pitch=0.05, distance=0.4, focus=(0.0, 0.0, -0.03)))
            camera = Camera(window.config)
            self.moment(graph, ['/array/drive', '/array/geometry', '/array/focal_points'])
            seen = window.settled(lambda picture: drawn(picture) > 50000)
            seen.save(os.path.join(os.environ.get('ROS_HOME', graph.folder), name + '.png'))
        to_world = rig_messages.array_to_world(self.run_of_bag)
        point = lambda x, y, z: type('Point', (), dict(x=x, y=y, z=z))
        x = self.strongest().x
        sources, share = self.sources()

        def look(y, z):
            pixel = camera.project(to_world(point(x, y, z)))[:2]
            return share * acoustic_field.pressure(sources, (x, y, z)), seen.around(pixel, 2)
        return look

    def strongest(self):
        return max(self.last['/array/focal_points'].points, key=lambda p: p.intensity).position

    def wrong_colors(self, look, share_of):
        """Places whose colour is not that of the share of the scale for their pressure; and all shares."""
        strongest, wrong, shares = self.strongest(), [], []
        places = [(strongest.y, strongest.z)] + [(0.002 * k - 0.06, 0.05 + 0.0043 * (k % 37)) for k in range(60)]
        for y, z in places:
            pressure, pixels = look(y, z)
            shares.append(share_of(pressure))
            color = color_at(SOUND_STOPS, shares[-1])
            if all(differs(near, color, 26) for near in pixels):
                wrong.append((y, z, color, pixels[len(pixels) // 2]))
        return wrong, shares

    def test_slice_of_the_sound(self):
        """Colours of the slice, against an independent sum at the same places. Between the points of its grid the slice
        is interpolated. With a step of 1 mm, an eighth of a wavelength, the error of this is less than a tenth."""
        wrong, shares = self.wrong_colors(self.slice('slice', Step=0.001), lambda pressure: pressure / FULL)
        self.assertGreater(max(shares), 0.5, 'a strong place was looked at')
        self.assertFalse(wrong)

    def test_slice_of_the_sound_in_decibels(self):
        """The same with the level of the sum; 26 dB below the full scale the slice in Pa would be all dark. Steps are
        small, because levels change fast near the places of silence."""
        look = self.slice('slice in dB', Unit='dB', Range=RANGE, Step=0.001)
        wrong, shares = self.wrong_colors(look, lambda pressure: 1.0 + 20.0 * math.log10(pressure / FULL) / RANGE)
        self.assertGreater(max(shares), 0.8, 'a loud place was looked at')
        self.assertGreater(len([share for share in shares if 0.3 < share < 0.7]), 5, 'places between')
        self.assertFalse(wrong)

    def test_forces_on_the_clay(self):
        """Arrows: the sum of two contacts of a cell, down onto the clay; and one from the left."""
        self.last['/clay/contacts'] = contacts([((0.012, 0.042, 0.04), (0.0, 0.0, 3.0)),
                                                ((0.018, 0.048, 0.04), (0.0, 0.0, 3.0)),
                                                ((0.015, -0.055, 0.05), (0.0, -4.0, 0.0))])
        with rig_run.Graph() as graph:
            window = Window(graph, only=('Forces on the clay',),
                            camera=dict(yaw=math.pi, pitch=0.3, distance=0.4, focus=(0.0, 0.0, 0.05)))
            camera = Camera(window.config)
            self.moment(graph, ['/clay/contacts'])
            seen = window.settled(lambda picture: drawn(picture) > 500)
            seen.save(os.path.join(os.environ.get('ROS_HOME', graph.folder), 'forces.png'))
        for tip, force in (((0.015, 0.045, 0.04), (0.0, 0.0, -6.0)), ((0.015, -0.055, 0.05), (0.0, 4.0, 0.0))):
            along = lambda share: camera.project([a - LENGTH * share * f for a, f in zip(tip, force)])[:2]
            for share in (0.03, 0.3, 0.6, 0.97):
                self.assertTrue(any(max(color) < 100 for color in seen.around(along(share), 1)), (force, share))
            for share in (-0.1, 1.1):
                self.assertFalse(any(differs(color, BACKGROUND) for color in seen.around(along(share), 1)),
                                 (force, share))

    def test_wanted_and_given_pressure(self):
        """Colours of the skin in hands/rendered, against an independent sum; and its picture has all colour bars."""
        about, up = (0.0, 0.0, 0.03), (0.28, 0.0, 0.17)
        with rig_run.Graph() as graph:
            graph.start([roslib.packages.find_node('tactile_clay', 'hand_surface')[0]])
            window = Window(graph, only=('Wanted and given pressure, side by side',),
                            camera=dict(yaw=math.pi, pitch=0.12, distance=1.0, focus=(0.28, 0.17, 0.15)))
            self.moment(graph, list(HANDS) + ['/array/drive', '/array/geometry'])
            seen = window.settled(lambda picture: drawn(picture) > 20000)
            camera = Camera(window.config)
            seen.save(os.path.join(os.environ.get('ROS_HOME', graph.folder), 'rendered.png'))
            recording = graph.record(['/hands/rendered'])
            written = recording[1] + '.active'
            rig_run.wait_until(lambda: os.path.exists(written) and os.path.getsize(written) > 100000, PATIENCE,
                               'hands/rendered')
            markers = graph.recorded(recording)['/hands/rendered'][-1].markers
        bars = {m.ns: m for m in markers if m.id == 15}  # its last number
        titles = {m.ns: m.text for m in markers if m.id == 16}
        self.assertIn('kPa', titles['wanted, bar'])
        for name in ('weight', 'wanted', 'given'):
            bar = next(m for m in markers if m.ns == name + ', bar' and m.id == 10)
            height = max(p.z for p in bar.points)
            across = [p.y for p in bar.points if p.z > height - 1e-6]
            x, y, _ = camera.project((bar.points[0].x, 0.5 * (min(across) + max(across)), height - 0.004))
            self.assertTrue(any(not differs(color, (105, 5, 57), 36) for color in seen.around((x, y), 4)), name)
        self.errors_are_those_of_the_skin(titles['given, bar'])
        self.weights_are_those_of_the_skin([m for m in markers if m.ns == 'weight' and m.points])
        # Given: skin that is bright is where the sum says so, and as bright.
        full = float(bars['given, bar'].text)
        pose = next(t.transform.translation for t in self.last['/tf_static'].transforms if t.child_frame_id == 'array')
        (sources, drive), density, speed, checked = self.sources(), 1.2041, acoustic_field.SOUND_SPEED, 0
        for hand in (m for m in markers if m.ns == 'given' and m.id < 2 and m.points):
            for corner, color in list(zip(hand.points, hand.colors))[::11]:
                share = self.share_of(color)
                if share is None:
                    continue
                x = about[0] - (corner.z - up[2])
                y = corner.y - up[1] + 0.17
                z = about[2] + (corner.x - up[0])
                amplitude = drive * acoustic_field.pressure(sources, (x - pose.x, y - pose.y, z - pose.z))
                given = amplitude ** 2 / (density * speed ** 2)
                self.assertLess(abs(share - given / full), 0.04, (x, y, z))
                checked += 1
        self.assertGreater(checked, 20)

    def errors_are_those_of_the_skin(self, title):
        """The errors of the title, against those at the samples of the skin."""
        told = re.match(r'given by the array, Pa\nerror (\d+) %, on finger pads (\d+) %; \d+\.\d mN$', title)
        self.assertTrue(told, title)
        pose = next(t.transform for t in self.last['/tf_static'].transforms if t.child_frame_id == 'array').translation
        skin = numpy.array(rig_messages.columns(self.last['/hands/skin'], 'x', 'y', 'z', 'area', 'pad_distance',
                                                'normal_x', 'normal_y', 'normal_z'))
        pressed = numpy.array(rig_messages.columns(self.last['/hands/pressure'], 'x', 'y', 'z', 'pressure'))
        places = skin[:, :3] - (pose.x, pose.y, pose.z)  # the array is not turned
        apart = numpy.linalg.norm(places[:, None] - pressed[None, :, :3], axis=2)
        wants = numpy.zeros(len(skin))
        wants[apart.argmin(axis=0)] = pressed[:, 3]
        gives = acoustic_field.pressures(self.sources()[0], places) ** 2
        counted = (apart.min(axis=1) < 0.06) & ((places * skin[:, 5:]).sum(axis=1) < 0.0)
        mean = lambda values, which: (skin[:, 3] * values)[which].sum()
        scale = mean(wants * gives, counted) / mean(gives * gives, counted)
        for number, which in zip(told.groups(), (counted, counted & (skin[:, 4] < PAD))):
            error = math.sqrt(mean((scale * gives - wants) ** 2, which) / mean(wants ** 2, which))
            self.assertLess(abs(0.01 * float(number) - error), 0.1, title)  # corners of the mesh lie elsewhere

    def weights_are_those_of_the_skin(self, hands):
        """Pads, a thirtieth of the skin, have weight 1, and the palm has 58 / 241."""
        colors = [(c.r, c.g, c.b) for hand in hands for c in hand.colors]
        for share, least in ((1.0, 0.02), (58.0 / 241.0, 0.2)):
            wanted = color_at(STOPS, share)
            alike = [color for color in colors if max(abs(a - b) for a, b in zip(color, wanted)) < 0.02]
            self.assertGreater(len(alike) / len(colors), least, share)

    @staticmethod
    def share_of(color):
        """Share of the full scale from a colour of the scale, above the part that the skin shines through; else
        None."""
        best = (1.0, None)
        for k in range(16, 200):
            distance = max(abs(a - b) for a, b in zip(color_at(STOPS, k / 200), (color.r, color.g, color.b)))
            best = min(best, (distance, k / 200))
        return best[1] if best[0] < 0.01 else None

if __name__ == '__main__':
    rig_run.main('extra_displays')
