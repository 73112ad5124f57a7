#!/usr/bin/env python3
"""What the display Clay as splats shows: see splats.test."""
import os
import unittest
from unittest import mock

import roslib.packages

import rig_run
from rviz_window import (BACKGROUND, CONFIG, HANDS, PATIENCE, Camera, Window, differs, drawn, has_strong_colours,
                         kneading, places, publish, silhouette)

SPLATS, SURFACE, SKIN = 'Clay as splats', 'Clay', 'Hands, with the pressure on their skin'
# Fixed before the first run. IoU: pixels that two pictures have in common, of all that one of them has.
LEAST_IOU = 0.9
LEAST_ALIKE = 0.9  # of the pixels of the clay, those whose colour is that of clay/surface within 24 of 255


def clay_pixels(picture):
    return picture.pixels(lambda color: differs(color, BACKGROUND))


def iou(a, b):
    return len(a & b) / len(a | b)


class Splats(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        _, cls.last = kneading()
        cls.splats, cls.splats_hands = cls.show(SPLATS)
        cls.surface, cls.surface_hands = cls.show(SURFACE)

    @classmethod
    def show(cls, clay):
        """Pictures of the moment with this display of the clay: without hands, and with them."""
        with rig_run.Graph() as graph:
            window = Window(graph, only=(clay, SKIN))
            for node in ('clay_surface', 'hand_surface'):
                graph.start([roslib.packages.find_node('tactile_clay', node)[0]])
            publisher = publish(graph, cls.last, ['/tf_static', '/clay/particles'])
            alone = window.settled(lambda picture: drawn(picture) > 5000)
            graph.stop(publisher)
            publish(graph, cls.last, ['/tf_static', '/clay/particles'] + list(HANDS))
            least = drawn(alone) + 5000
            both = window.settled(lambda picture: drawn(picture) > least)
            for name, picture in (('alone', alone), ('hands', both)):  # for who looks
                picture.save(os.path.join(os.environ.get('ROS_HOME', graph.folder), '%s, %s.png' % (clay, name)))
        return alone, both

    def test_silhouette(self):
        expected = silhouette(places(self.last['/clay/particles']), Camera(CONFIG))
        self.assertGreater(iou(expected, clay_pixels(self.splats)), LEAST_IOU)

    def test_bodies_have_their_colours(self):
        has_strong_colours(self, self.splats)

    def test_light_and_colours_are_those_of_the_surface(self):
        clay = clay_pixels(self.splats) & clay_pixels(self.surface)
        alike = [at for at in clay if not differs(self.splats[at], self.surface[at])]
        self.assertGreater(len(alike) / len(clay), LEAST_ALIKE)

    def test_hands_hide_what_is_behind_them(self):
        changed = lambda before, after: {at for at in clay_pixels(before) if differs(before[at], after[at])}
        behind = changed(self.splats, self.splats_hands)
        self.assertGreater(len(behind), 2000)
        self.assertLess(len(behind), 0.9 * len(clay_pixels(self.splats)))
        self.assertGreater(iou(behind, changed(self.surface, self.surface_hands)), LEAST_IOU)

    def test_says_what_the_card_lacks(self):
        with mock.patch.dict(os.environ, MESA_EXTENSION_OVERRIDE='-GL_ARB_texture_float'), rig_run.Graph() as graph:
            Window(graph, only=(SPLATS,))
            publish(graph, self.last, ['/tf_static', '/clay/particles'])
            log = os.path.join(graph.folder, 'rviz.log')
            words = lambda: open(log).read()
            rig_run.wait_until(lambda: 'lacks floating-point textures' in words(), PATIENCE,
                               'a line of the display')
            self.assertIn("Switch on the display 'Clay'", words())


if __name__ == '__main__':
    rig_run.main('splats')
