#!/usr/bin/env python3
"""AM, lateral modulation, STM and fields on their way to the arrays: see modulation.test."""
import math
import os
import sys
import tempfile
import time
import unittest

import rospy
from geometry_msgs.msg import Vector3
from sensor_msgs.msg import PointCloud2
from tactile_clay.msg import ArrayDrive, FocalPointArray, RenderingReport

import rig_messages
import rig_run
from array_stream import Driver, States, Stream, focus
from rig_run import wait_until

sys.path.insert(0, os.path.join(rig_run.PACKAGE, 'test', 'emulator'))
import acoustic_field  # noqa: E402  pylint: disable=wrong-import-position
import sonic_surface  # noqa: E402  pylint: disable=wrong-import-position

AM, LATERAL, STM, FIELD, CIRCLE, FIELD_CIRCLE = range(6)
AIR = 101325.0 / (287.05 * 293.15)             # kg/m^3, dry at 20 degrees C
FREE = dict(pressure_cap=1e6, head_spl_cap=200.0)  # a gate that makes nothing weaker
WAVENUMBER = acoustic_field.WAVENUMBER


def radiation(amplitude_squared):
    return amplitude_squared / (AIR * acoustic_field.SOUND_SPEED ** 2)


def channels():
    """(x, y) in m of each transducer of the layout usx: 16 x 16, 10.3 mm, along x and then y."""
    return [((column - 7.5) * 0.0103, (row - 7.5) * 0.0103) for row in range(16) for column in range(16)]


def sources_of_focus(x, y, z):
    """The exact drive of one focus: each transducer in phase there."""
    return [(cx, cy, -WAVENUMBER * math.dist((x, y, z), (cx, cy, 0.0))) for cx, cy in channels()]


def patch(step=0.006, half=4):
    """Samples of skin 0.17 m above the array, of which a round patch is to be felt."""
    places = [(step * i, step * j) for i in range(-half, half + 1) for j in range(-half, half + 1)]
    return [focus(x, y, 0.17, 0.3 if math.hypot(x, y) < 0.011 else 0.0, number) for number, (x, y) in enumerate(places)]


def position(point):
    return (point.position.x, point.position.y, point.position.z)


def setUpModule():
    rospy.init_node('modulation_test')


class SimulatedArray(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.stream, cls.states = Stream(), States()
        cls.addClassCleanup(cls.stream.stop)

    def setUp(self):
        self.stream.reset()

    def play(self, points, number, frequency, **parameters):
        """The field and the measured points of a simulated array that has played them for a while, and its drives."""
        self.stream.points, self.stream.modulation, self.stream.modulation_frequency = points, number, frequency
        fields, drives, measured = [], [], []
        parameters = dict(FREE, skin_field=False, slice_size=0.06, slice_step=0.01, **parameters)
        with Driver('simulated_array', **parameters):
            subscribers = [rospy.Subscriber('array/field', PointCloud2, fields.append),
                           rospy.Subscriber('array/drive', ArrayDrive, drives.append),
                           rospy.Subscriber('array/measured', FocalPointArray, measured.append)]
            self.states.wait(lambda state: state.emitting)
            time.sleep(0.5)  # for the slew
            del fields[:], drives[:]
            wait_until(lambda: len(fields) > 3 and len(drives) > 20, 20, 'fields and drives')
            for subscriber in subscribers:
                subscriber.unregister()
        return fields[-1], measured[-1], drives

    def expect_tactile(self, cloud, sources):
        """`sources`: of each instant of the period, with the share of power that it has."""
        strongest = 0.0
        for x, y, z, tactile in rig_messages.columns(cloud, 'x', 'y', 'z', 'tactile'):
            expected = sum(power * radiation(acoustic_field.pressure(playing, (x, y, z)) ** 2)
                           for playing, power in sources)
            strongest = max(strongest, tactile)
            self.assertAlmostEqual(tactile, expected, delta=0.01 * expected + 0.02)
        self.assertGreater(strongest, 1.0)

    def test_amplitude(self):
        cloud, measured, _ = self.play([focus(0.01, 0.0, 0.17, 1.0)], AM, 200.0)
        # (1 - cos) / 2 leaves half.
        self.expect_tactile(cloud, [(sources_of_focus(0.01, 0.0, 0.17), 0.5)])
        self.assertEqual(measured.modulation, AM)

    def test_unmodulated(self):
        cloud, _, _ = self.play([focus(0.01, 0.0, 0.17, 1.0)], AM, 0.0)
        self.expect_tactile(cloud, [(sources_of_focus(0.01, 0.0, 0.17), 1.0)])

    def test_lateral(self):
        cloud, measured, drives = self.play([focus(0.01, 0.0, 0.17, 1.0)], LATERAL, 10.0)
        # 16 steps of 0.75 mm from +3 mm to -3 mm and back.
        offsets = [0.003 - 0.00075 * min(step, 16 - step) for step in range(16)]
        self.expect_tactile(cloud, [(sources_of_focus(0.01 + offset, 0.0, 0.17), 1 / 16) for offset in offsets])
        self.assertEqual(measured.modulation, LATERAL)
        self.assertGreater(len({drive.phase for drive in drives}), 4, 'the drive moves with the stamps')

    def test_circle(self):
        cloud, measured, drives = self.play([focus(0.01, 0.0, 0.17, 1.0)], CIRCLE, 5.0)
        # 20 steps round a circle of 3 mm.
        angles = [2 * math.pi * step / 20 for step in range(20)]
        self.expect_tactile(cloud, [(sources_of_focus(0.01 + 0.003 * math.cos(angle), 0.003 * math.sin(angle), 0.17),
                                     1 / 20)
                                    for angle in angles])
        self.assertEqual(measured.modulation, CIRCLE)
        self.assertGreater(len({drive.phase for drive in drives}), 4, 'the drive moves with the stamps')

    def test_field_circle(self):
        """Each of its eight places comes as a drive of its own, which gives the patch there."""
        points = patch()
        _, measured, drives = self.play(points, FIELD_CIRCLE, 5.0, modulation='field_circle')
        self.assertEqual(measured.modulation, FIELD_CIRCLE)
        stamps = [drive.header.stamp for drive in drives]
        played = [drive for drive in drives if drive.header.stamp == stamps[len(stamps) // 2]]
        self.assertEqual(len(played), 8)
        for step, drive in enumerate(played):
            sources = [(x, y, phase) for (x, y), phase in zip(channels(), drive.phase)]
            angle = 2 * math.pi * step / 8
            given = [radiation(acoustic_field.pressure(sources, (p.position.x + 0.003 * math.cos(angle),
                                                                 p.position.y + 0.003 * math.sin(angle), 0.17)) ** 2)
                     for p in points]
            wanted = [p.intensity ** 2 for p in points]
            cosine = (sum(g * w for g, w in zip(given, wanted)) /
                      math.sqrt(sum(g * g for g in given) * sum(w * w for w in wanted)))
            self.assertGreater(cosine, 0.8, 'an error below 0.6 at place %d' % step)

    def test_stm(self):
        places = [(0.02, 0.0, 1.0), (0.0, 0.02, 0.8), (-0.02, 0.0, 0.6), (0.0, -0.02, 0.9)]
        points = [focus(x, y, 0.17, intensity, number) for number, (x, y, intensity) in enumerate(places)]
        cloud, measured, drives = self.play(points, STM, 37.0)
        self.expect_tactile(cloud, [(sources_of_focus(x, y, 0.17), intensity ** 2 / 4) for x, y, intensity in places])
        self.assertEqual(measured.modulation, STM)
        self.assertEqual(len({drive.phase for drive in drives}), 4)
        for point, (x, y, intensity) in zip(measured.points, places):
            alone = intensity * acoustic_field.pressure(sources_of_focus(x, y, 0.17), (x, y, 0.17))
            self.assertAlmostEqual(point.pressure / alone, 1, delta=0.005)

    def test_field(self):
        """Each pattern comes as a drive of its own, and what is told of the skin is the field of all of them."""
        reports = []
        subscriber = rospy.Subscriber('array/rendering', RenderingReport, reports.append)
        points = patch()
        for patterns in (1, 4):
            with self.subTest(patterns):
                del reports[:]
                cloud, measured, drives = self.play(points, FIELD, 200.0, modulation='field', field_patterns=patterns)
                stamps = [drive.header.stamp for drive in drives]
                played = [drive for drive in drives if drive.header.stamp == stamps[len(stamps) // 2]]
                self.assertEqual(len(played), patterns)
                self.assertEqual(measured.modulation, FIELD)
                sources = [[(x, y, phase) for (x, y), phase in zip(channels(), drive.phase)] for drive in played]
                share = [drive.amplitude[0] ** 2 / patterns for drive in played]
                report = reports[-1]
                self.assertEqual((len(report.wanted), len(report.granted)), (len(points), len(points)))
                for point, wanted, granted in list(zip(points, report.wanted, report.granted))[::7]:
                    given = sum(power * radiation(acoustic_field.pressure(playing, position(point)) ** 2)
                                for playing, power in zip(sources, share))
                    self.assertAlmostEqual(granted, given, delta=0.05 * given + 0.05)
                    self.assertEqual(wanted > 0, point.intensity > 0)
                self.assertTrue(0 < report.error < 0.6, report.error)
                self.assertGreater(report.gain, 0)
                self.assertEqual(report.force, 0, 'the stream does not tell areas')
                # The patch stands out, and half of its pressure is left by AM.
                for x, y, tactile in rig_messages.columns(cloud, 'x', 'y', 'tactile'):
                    given = 0.5 * sum(power * radiation(acoustic_field.pressure(playing, (x, y, 0.17)) ** 2)
                                      for playing, power in zip(sources, share))
                    self.assertAlmostEqual(tactile, given, delta=0.05 * given + 0.05)
        subscriber.unregister()

    def test_field_on_skin_at_an_angle(self):
        """The solver makes the pressure on skin that lies as the message says, and what is told is that pressure."""
        half, angle = math.sqrt(0.5), math.pi / 4
        points = patch()
        for point in points:  # the same patch on skin that is turned about y
            point.position.x, point.position.z = half * point.position.x, 0.17 + half * point.position.x
        normal = (math.sin(angle), 0.0, -math.cos(angle))
        reports = []
        subscriber = rospy.Subscriber('array/rendering', RenderingReport, reports.append)
        self.stream.normals = [Vector3(*normal)] * len(points)
        _, measured, drives = self.play(points, FIELD, 200.0, modulation='field')
        subscriber.unregister()
        sources = [(x, y, phase) for (x, y), phase in zip(channels(), drives[-1].phase)]
        power, apart = drives[-1].amplitude[0] ** 2, 0.0
        for point, granted, heard in list(zip(points, reports[-1].granted, measured.points))[::5]:
            given = power * radiation(acoustic_field.pressure(sources, position(point), normal) ** 2)
            free = math.sqrt(power) * acoustic_field.pressure(sources, position(point))
            self.assertAlmostEqual(granted, given, delta=0.05 * given + 0.05)
            self.assertAlmostEqual(heard.pressure, free, delta=0.05 * free + 30.0)
            apart = max(apart, radiation(free ** 2) - given)
        self.assertGreater(apart, 0.3, 'the angle is to be seen')
        self.assertTrue(0 < reports[-1].error < 0.6, reports[-1].error)

        self.stream.normals = self.stream.normals[1:]
        with Driver('simulated_array', modulation='field', **FREE):
            _, state = self.states.wait(lambda state: 'normal of focal point' in state.silent_reason)
            self.assertFalse(state.emitting)

    def test_the_gate_looks_at_every_instant(self):
        """A point 1 mm inside the workspace: in with AM, out with lateral modulation; a path with one place that is too
        loud."""
        edge = [focus(0.199, 0.0, 0.2, 0.5)]
        with Driver('simulated_array', **FREE):
            self.stream.points = edge
            self.states.wait(lambda state: state.emitting)
            self.stream.modulation, self.stream.modulation_frequency = LATERAL, 10.0
            _, state = self.states.wait(lambda state: not state.emitting)
            self.assertIn('outside the workspace', state.silent_reason)
            self.stream.modulation = 7
            _, state = self.states.wait(lambda state: "modulation is '7'" in state.silent_reason)
            self.assertFalse(state.emitting)
        with Driver('simulated_array', **FREE):
            self.stream.reset()
            self.stream.points, self.stream.modulation, self.stream.modulation_frequency = edge, CIRCLE, 5.0
            _, state = self.states.wait(lambda state: not state.emitting and 'workspace' in state.silent_reason)
            self.assertIn('outside the workspace', state.silent_reason)
        path = [focus(0.0, 0.0, 0.2, 0.3, 0), focus(0.02, 0.0, 0.2, 1.0, 1)]
        _, measured, _ = self.play(path, STM, 100.0, pressure_cap=1000.0)
        self.assertLess(measured.points[1].pressure, 1000.0)
        self.assertGreater(measured.points[1].pressure, 950.0)
        self.assertAlmostEqual(measured.points[0].pressure / measured.points[1].pressure, 0.3, delta=0.02)


class Devices(unittest.TestCase):
    def test_boards_refuse_at_start_what_their_wire_is_too_slow_for(self):
        with tempfile.TemporaryDirectory() as folder, sonic_surface.Emulator(os.path.join(folder, 'port')) as emulator:
            for modulation in ('lateral', 'stm', 'circle', 'field_circle'):
                with Driver(device='sonic_surface', port=emulator.link, modulation=modulation) as driver:
                    self.assertEqual(driver.process.wait(20), 1)
                    driver.reader.join(5)
                    lines = [line for line in driver.lines if 'modulation' in line]
                    self.assertEqual(len(lines), 1, driver.words())
                    self.assertIn("modulation is '%s', array 'sonic_surface' can do am, field only, because it takes "
                                  "89 updates per second" % modulation, lines[0])
            self.assertFalse(emulator.sounds())

    def test_boards_play_the_field_that_was_judged(self):
        """Through the wire: the phases that the boards play have the pressures on the skin that the driver tells of."""
        reports, states, stream = [], States(), Stream()
        self.addCleanup(stream.stop)
        subscriber = rospy.Subscriber('array/rendering', RenderingReport, reports.append)
        self.addCleanup(subscriber.unregister)
        stream.points, stream.modulation = patch(), FIELD
        with tempfile.TemporaryDirectory() as folder, sonic_surface.Emulator(os.path.join(folder, 'port')) as emulator:
            with Driver(device='sonic_surface', port=emulator.link, modulation='field', **FREE):
                states.wait(lambda state: state.emitting)
                time.sleep(1.5)  # the same skin all the time: the pattern settles
                playing = [swap for swap in emulator.since(0) if swap.sounds][-1]
                report = reports[-1]
            sources = [(x, y, 2.0 * math.pi * value / 32)
                       for (x, y), value in zip(sonic_surface.places(), playing.fronts[0])
                       if value != sonic_surface.OFF]
            self.assertGreater(len(sources), 100)
            for point, granted in list(zip(stream.points, report.granted))[::5]:
                given = radiation(acoustic_field.pressure(sources, position(point)) ** 2)
                self.assertAlmostEqual(granted, given, delta=0.1 * given + 0.1)
            self.assertEqual(emulator.faults(), 0)

    def test_debug_takes_all(self):
        states, stream = States(), Stream()
        self.addCleanup(stream.stop)
        stream.modulation, stream.modulation_frequency = STM, 100.0
        with Driver(device='debug', modulation='stm', head_spl_cap=200.0):
            states.wait(lambda state: state.emitting)


class Rig(unittest.TestCase):
    def test_each_modulation_comes_through(self):
        for number, modulation in enumerate(('am', 'lateral', 'stm', 'field', 'circle', 'field_circle')):
            with self.subTest(modulation):
                run = rig_run.Run(dict(rig_run.LOCKSTEP, hands='bag', file=rig_run.bag('press_deeper'), quality='fast',
                                       modulation=modulation), rig_run.CHAIN + ['/array/measured'])
                self.assertEqual(run.code, 0, run.words)
                points, states = run.messages.by_stamp('/array/focal_points'), run.messages.by_stamp('/array/state')
                touched = [stamp for stamp, message in points.items() if message.points]
                self.assertGreater(len(touched), 30)
                for stamp in touched:
                    self.assertEqual(points[stamp].modulation, number)
                    self.assertFalse(points[stamp].normal)
                    self.assertTrue(states[stamp].emitting, states[stamp].silent_reason)
                measured = run.messages.by_stamp('/array/measured')
                self.assertEqual({measured[stamp].modulation for stamp in touched}, {number})


if __name__ == '__main__':
    rig_run.main('modulation')
