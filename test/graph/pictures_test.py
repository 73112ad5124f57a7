#!/usr/bin/env python3
"""What displays show, each by itself in one view: see pictures.test.

A soft hand presses a block. For the view, its moment is taken apart: the hand that the clay meets is lifted above the
tracked one, the skeleton stands beside them, and the array faces the camera.
"""
import colorsys
import copy
import itertools
import math
import os
import struct
import unittest

import roslib.packages
from geometry_msgs.msg import Quaternion, TransformStamped, Vector3
from tactile_clay.msg import ClayStatus
from tf2_msgs.msg import TFMessage

import rig_messages
import rig_run
from rviz_window import BACKGROUND, HEIGHT, OVERLAY, WIDTH, Camera, Window, differs, publish

MOMENT = '1.9'  # s into the bag; the finger presses
STATES, MODEL = '/hands/joint_states_right', 'hand_right_description'
TOPICS = ['/hands/tracked', '/hands/skin', '/hands/bones', STATES, '/tf', '/array/drive', '/array/geometry',
          '/array/state']
LIFT = 0.02  # m, of the hand that the clay meets
BESIDE = 0.25  # m, of the skeleton
PITCH = 0.3  # of the camera, which looks along y
CAMERA = dict(yaw=-0.5 * math.pi, pitch=PITCH, distance=0.75, focus=(0.22, 0.03, 0.12))
ARRAY = (0.55, 0.03, 0.12)  # m
PITCH_OF_USX, ROWS = 0.0103, 16  # m, and a side
TRANSDUCER_LIFT = 0.001  # m, of the coloured discs
GREY = (51, 51, 51)  # of a silent transducer
ONLY = {'Array': {}, 'Transducers, by phase and amplitude': {}, 'State of the rig': {},
        'Tracked bones beside those of the soft hand': {}, 'Hands, with the pressure on their skin': {},
        'Skeleton of the right hand': {},
        # Its bar; the slice itself is far outside of the view.
        'Slice of the sound': {'Unit': 'dB', 'Size': 0.01, 'Position': 5.0, 'Follow the strongest point': False}}
GREEN, ORANGE = (40, 140, 70), (210, 120, 0)  # dots of the state of the rig
WRIST, KNUCKLE, TIP = 1, 12, 15  # in the order of OpenXR; two of the middle finger
JOINTS = 25  # of hands/bones, which has no palm joint
FINGERS = [range(2, 6), range(6, 11), range(11, 16), range(16, 21), range(21, 26)]


def facing_the_camera():
    """Rotation of an array whose face looks at the camera, its y axis upwards."""
    half = 0.5 * (0.5 * math.pi - PITCH)
    return Quaternion(math.sin(half), 0.0, 0.0, math.cos(half))


def frame(name, place, rotation):
    found = TransformStamped(child_frame_id=name)
    found.header.frame_id = 'world'
    found.transform.translation, found.transform.rotation = Vector3(*place), rotation
    return found


def lifted(cloud):
    """hands/skin whose samples, not those of the tracked hand, are higher by LIFT."""
    cloud, (offset,) = copy.deepcopy(cloud), [field.offset for field in cloud.fields if field.name == 'z']
    data = bytearray(cloud.data)
    for at in range(offset, len(data), cloud.point_step):
        struct.pack_into('<f', data, at, struct.unpack_from('<f', data, at)[0] + LIFT)
    cloud.data = bytes(data)
    return cloud


def pressing():
    """A run with a soft hand and its skeleton: the last message of each topic, and the URDF of the hand."""
    with rig_run.Graph() as graph:
        recording = graph.record(TOPICS)
        rig = graph.rig(dict(rig_run.LOCKSTEP, modulation='am', hands='bag', file=rig_run.bag('press_deeper'),
                             hand_model='soft', skeleton='true', quality='fast', duration=MOMENT))
        model = lambda: graph.master().getParam('/test', '/' + MODEL)
        # It is there from the 30th sample until the node ends.
        rig_run.wait_until(lambda: model()[0] == 1 and model()[2], 60, 'the URDF of the hand')
        urdf = model()[2]
        if rig.wait(120) != 0:
            raise AssertionError(graph.words())
        messages = graph.recorded(recording)
    last = {topic: messages[topic][-1] for topic in TOPICS}
    last['/tf'] = next(t for message in reversed(messages['/tf']) for t in message.transforms
                       if t.child_frame_id == 'hand_right_wrist')
    return last, urdf


def moment(last):
    """The messages that are shown."""
    wrist = last['/tf'].transform
    place = (wrist.translation.x + BESIDE, wrist.translation.y, wrist.translation.z)
    shown = dict(last)
    shown['/tf_static'] = TFMessage([frame('array', ARRAY, facing_the_camera()),
                                     frame('hand_right_wrist', place, wrist.rotation)])
    shown['/hands/skin'] = lifted(last['/hands/skin'])
    for marker in shown['/hands/bones'].markers:
        for point in marker.points if marker.ns == 'virtual' else []:
            point.z += LIFT
    drive = shown['/array/drive']
    drive.amplitude = [(1.0, 0.5, 0.0)[k % 3] for k in range(len(drive.phase))]
    shown['/clay/status'] = ClayStatus(particles=2114, real_time_factor=1.0)
    shown['/array/state'].emitting, shown['/array/state'].silent_reason = True, ''
    return shown


def is_blue(color):
    return color[2] - color[0] > 45


def ink(picture, left, top, width, height):
    """Places of the dark pixels of a rectangle, from its corner."""
    return {(x, y) for x in range(width) for y in range(height) if max(picture[left + x, top + y]) < 150}


def state_pixels(picture, condition):
    return {(x, y) for x in range(OVERLAY[0]) for y in range(OVERLAY[1], HEIGHT) if condition(picture[x, y])}


def dots(picture, color):
    """How many pixels of the state of the rig have the colour."""
    return len(state_pixels(picture, lambda c: not differs(c, color, 10)))


class Pictures(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        last, urdf = pressing()
        cls.shown = moment(last)
        hand = cls.shown['/hands/tracked'].hands[0]
        cls.joints = [((j.position.x, j.position.y, j.position.z), r) for j, r in zip(hand.joints, hand.radii)]
        with rig_run.Graph() as graph:
            graph.master().setParam('/test', '/' + MODEL, urdf)
            graph.start([roslib.packages.find_node('robot_state_publisher', 'robot_state_publisher')[0],
                         'robot_description:=' + MODEL, 'joint_states:=' + STATES])
            graph.start([roslib.packages.find_node('tactile_clay', 'hand_surface')[0]])
            window = Window(graph, only=ONLY, camera=CAMERA)
            cls.camera = Camera(window.config)
            cls.pictures(graph, window)

    @classmethod
    def pictures(cls, graph, window):
        """The array and the skeleton; with drive and bones; and with skin, while the array is silent."""
        board, knuckle = cls.on_the_array(8.2, 8.2, -0.007), cls.beside(cls.joints[KNUCKLE][0])
        x, y, z = cls.joints[TIP][0]
        tip = cls.camera.project((x, y, z + LIFT))
        topics = ['/tf_static', STATES, '/array/geometry']
        cls.array = cls.picture(graph, window, topics, lambda seen: any(map(is_blue, seen.around(knuckle, 2))) and any(
            max(c) < 90 for c in seen.around(board, 2)))
        topics += ['/array/drive', '/hands/bones', '/clay/status', '/array/state']
        cls.bones = cls.picture(graph, window, topics, lambda seen: dots(seen, GREEN) > 40 and any(
            min(c) > 247 for c in seen.around(tip, 4)))
        cls.shown['/array/state'].emitting = False
        cls.shown['/array/state'].silent_reason = 'stopped, as the test wants it'
        topics += ['/hands/tracked', '/hands/skin']
        cls.skin = cls.picture(graph, window, topics, lambda seen: dots(seen, ORANGE) > 12 and any(
            c[0] - c[2] > 25 for c in seen.around(tip, 4)))

    @classmethod
    def picture(cls, graph, window, topics, condition):
        publisher = publish(graph, cls.shown, topics)
        seen = window.settled(condition)
        folder = os.environ.get('ROS_HOME', graph.folder)
        seen.save(os.path.join(folder, 'picture%d.png' % len(topics)))  # for who looks
        graph.stop(publisher)
        return seen

    @classmethod
    def on_the_array(cls, column, row, height=0.0):
        """Pixel of a place in frame array: distances of transducers from the middle, and m."""
        turned = rig_messages.rotate(facing_the_camera(), (column * PITCH_OF_USX, row * PITCH_OF_USX, height))
        return cls.camera.project([a + b for a, b in zip(turned, ARRAY)])[:2]

    @classmethod
    def beside(cls, place):
        """Pixel of a place of the skeleton."""
        return cls.camera.project((place[0] + BESIDE, place[1], place[2]))[:2]

    def transducers(self):
        """Pixel of each transducer, in the order of the channels."""
        markers = self.shown['/array/geometry'].markers
        spheres = next(m for m in markers if m.type == m.SPHERE_LIST)
        self.assertEqual(len(spheres.points), ROWS ** 2)
        return [self.on_the_array(p.x / PITCH_OF_USX, p.y / PITCH_OF_USX, p.z + TRANSDUCER_LIFT)
                for p in spheres.points]

    def test_the_array_is_a_dark_board_with_grey_transducers(self):
        for column, row in itertools.product((-8.2, 8.2), (-8.2, 0.0, 8.2)):
            self.assertTrue(any(max(c) < 90 for c in self.array.around(self.on_the_array(column, row, -0.007), 2)))
            beyond = self.array.around(self.on_the_array(1.2 * column, row, -0.007), 1)
            self.assertFalse(any(differs(c, BACKGROUND) for c in beyond), (column, row))
        for at in self.transducers():
            self.assertTrue(any(min(c) > 140 and max(c) - min(c) < 12 for c in self.array.around(at, 1)), at)

    def test_transducers_have_the_colours_of_phase_and_amplitude(self):
        drive, wrong, hues = self.shown['/array/drive'], [], set()
        for at, phase, amplitude in zip(self.transducers(), drive.phase, drive.amplitude):
            turns = phase / (2.0 * math.pi) % 1.0
            hues.add(int(6.0 * turns))
            full = [255.0 * c for c in colorsys.hsv_to_rgb(turns, 0.85, 1.0)]
            color = [amplitude * a + (1.0 - amplitude) * b for a, b in zip(full, GREY)]
            if all(differs(near, color, 20) for near in self.bones.around(at, 1)):
                wrong.append((at, phase, amplitude, self.bones[round(at[0]), round(at[1])]))
        self.assertEqual(hues, set(range(6)), 'phases of all colours are looked at')
        self.assertFalse(wrong)

    def test_bones_of_the_soft_hand_are_white_and_tracked_ones_blue(self):
        markers = [m for m in self.shown['/hands/bones'].markers if m.points]
        spheres = [(self.camera.project((p.x, p.y, p.z)), 0.5 * m.scale.x, m.ns) for m in markers for p in m.points]
        seen, wrong = {'tracked': 0, 'virtual': 0}, []
        for joint in [p for m in markers if len(m.points) == JOINTS for p in m.points]:
            x, y, _ = self.camera.project((joint.x, joint.y, joint.z))
            looks = {look for (u, v, scale), radius, look in spheres
                     if math.hypot(x - u, y - v) < 1.2 * radius * scale + 1.0}
            if len(looks) > 1:
                continue  # one of them hides the other there
            look, = looks
            seen[look] += 1
            near = self.bones.around((x, y), 1)
            blue = any(map(is_blue, near))
            white = any(differs(c, BACKGROUND, 8) and max(c) - min(c) < 12 for c in self.bones.around((x, y), 2))
            if blue != (look == 'tracked') or (look == 'virtual' and not white):
                wrong.append((look, x, y, near))
        self.assertGreater(min(seen.values()), 10, seen)
        self.assertFalse(wrong)

    def test_skeleton(self):
        """At the joints, as they are tracked, of a hand beside the tracked one; and nowhere else."""
        there = [any(map(is_blue, self.array.around(self.beside(place), 3))) for place, _ in self.joints[WRIST:]]
        self.assertGreater(sum(there), 0.85 * JOINTS)
        for place, _ in self.joints[WRIST:]:
            self.assertFalse(any(map(is_blue, self.array.around(self.camera.project(place), 3))))

    def balls(self, links, grow, lift):
        """Every second pixel of every second row that lies on balls from joint to joint of the hand, which are larger
        by `grow`, m."""
        pixels = set()
        for (a, b), k in itertools.product(links, range(9)):
            mix = lambda u, v: u + k / 8.0 * (v - u)
            (p, r), (q, s) = self.joints[a], self.joints[b]
            place = [mix(*c) for c in zip(p, q)]
            x, y, scale = self.camera.project((place[0], place[1], place[2] + lift))
            radius = (mix(r, s) + grow) * scale
            for j in range(math.ceil(0.5 * (y - radius)), math.floor(0.5 * (y + radius)) + 1):
                half = math.sqrt(max(0.0, radius ** 2 - (2 * j - y) ** 2))
                pixels.update((2 * i, 2 * j) for i in range(math.ceil(0.5 * (x - half)),
                                                            math.floor(0.5 * (x + half)) + 1))
        return pixels

    def test_soft_skin_is_seen_apart_from_the_tracked_hand(self):
        """Fingers where only one of the two hands is: flesh, or a blue veil."""
        fingers = [(a, a + 1) for finger in FINGERS for a in finger[1:-1]]
        palm = [WRIST] + [joint for finger in FINGERS for joint in finger[:2]]
        all_links = fingers + list(itertools.combinations(palm, 2))
        for name, lift, other, least, tint in (('soft', LIFT, 0.0, 25, lambda c: c[0] - c[2]),
                                                ('tracked', 0.0, LIFT, 13, lambda c: c[2] - c[0])):
            alone = self.balls(fingers, -0.002, lift) - self.balls(all_links, 0.004, other)
            self.assertGreater(len(alone), 200, name)
            right = [at for at in alone if tint(self.skin[at]) > least]
            self.assertGreater(len(right) / len(alone), 0.85, name)

    def test_bar_of_the_slice_has_its_colours_and_decibels(self):
        white = {(x, y) for x in range(WIDTH - 300, WIDTH) for y in range(260) if min(self.array[x, y]) > 246}
        left, middle = min(x for x, _ in white), min(x for x, _ in white) + 17  # pixels, of sound_bar.cpp
        coloured = [y for y in range(min(y for _, y in white), max(y for _, y in white))
                    if min(self.array[middle, y]) <= 246]
        runs = itertools.groupby(enumerate(coloured), lambda pair: pair[1] - pair[0])
        bar = max(([y for _, y in run] for _, run in runs), key=len)
        self.assertAlmostEqual(len(bar), 180, delta=1)
        stops = [(5, 5, 26), (64, 18, 115), (184, 48, 107), (247, 133, 77), (252, 245, 191)]
        for k, color in enumerate(stops):
            at = (middle, bar[-1] - k * (len(bar) - 1) // 4)
            self.assertFalse(differs(self.array[at], color, 12), (k, self.array[at]))
        # Five numbers beside it, from 111 to 151 dB: 40 dB up to 1000 Pa. None between two of them.
        heights = [bar[-1] + 1 - 45 * k for k in range(5)]
        numbers = [ink(self.array, left + 33, y - 8, 32, 17) for y in heights]
        first_digits = [{(x, y) for x, y in number if x < 6} for number in numbers]
        for a, b in itertools.combinations(range(5), 2):
            self.assertGreater(len(numbers[a] ^ numbers[b]), 5, 'other numbers')
            self.assertLess(len(first_digits[a] ^ first_digits[b]), 4, 'each begins with 1')
        self.assertGreater(min(map(len, first_digits)), 4)
        for y in heights[:-1]:
            self.assertFalse(ink(self.array, left + 33, y - 28, 32, 12))

    def test_state_of_the_rig_tells_when_the_array_stops(self):
        sounds, silent = self.bones, self.skin
        self.assertGreater(dots(sounds, GREEN), dots(silent, GREEN))
        self.assertLess(dots(sounds, ORANGE), 5)
        right = lambda picture: max(x for x, _ in state_pixels(picture, lambda c: min(c) > 247))
        self.assertGreater(right(silent), right(sounds) + 40, 'the reason makes its line longer')
        for picture in (sounds, silent):
            self.assertGreater(len(state_pixels(picture, lambda c: max(c) < 130)), 200, 'pixels of words')


if __name__ == '__main__':
    rig_run.main('pictures')
