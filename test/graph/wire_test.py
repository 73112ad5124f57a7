#!/usr/bin/env python3
"""The driver of SonicSurface boards on the simulated array behind a serial port: see wire.test."""
import math
import os
import statistics
import sys
import tempfile
import unittest

import rospy
from sensor_msgs.msg import PointCloud2
from tactile_clay.msg import ArrayDrive, ArrayState, FocalPointArray

import rig_run
from array_stream import Driver, Stream, focus
from rig_messages import columns
from rig_run import wait_until

sys.path.insert(0, os.path.join(rig_run.PACKAGE, 'test', 'emulator'))
import acoustic_field  # noqa: E402  pylint: disable=wrong-import-position
import sonic_surface  # noqa: E402  pylint: disable=wrong-import-position
from modulation_test import FREE, radiation  # noqa: E402  pylint: disable=wrong-import-position


def sources(drive):
    """What a drive plays, at the places of the boards' channels as the emulator knows them."""
    return [(x, y, phase) for (x, y), phase, amplitude in zip(sonic_surface.places(), drive.phase, drive.amplitude)
            if amplitude]


class Wire(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rospy.init_node('wire_test')
        cls.stream = Stream()
        cls.addClassCleanup(cls.stream.stop)

    def setUp(self):
        self.stream.reset()
        self.folder = tempfile.TemporaryDirectory(prefix='wire_')
        self.addCleanup(self.folder.cleanup)
        self.link = os.path.join(self.folder.name, 'port')
        self.heard = {}
        for topic, kind in (('drive', ArrayDrive), ('field', PointCloud2), ('measured', FocalPointArray),
                            ('wire_state', ArrayState)):
            self.heard[topic] = []
            subscriber = rospy.Subscriber('array/' + topic, kind, self.heard[topic].append)
            self.addCleanup(subscriber.unregister)

    def boards(self, **parameters):
        return Driver('simulated_array', wire=self.link, skin_field=False, slice_size=0.06, slice_step=0.01,
                      **parameters)

    def driver(self, options=''):
        return Driver(device='sonic_surface', port=self.link, device_options='wait=10 ' + options, publish_drive=False,
                      **FREE)

    def test_the_field_behind_the_wire(self):
        """One focal point, modulated by swapping: its phases, its peak, half of its radiation pressure, and silence in
        the end."""
        self.stream.points = [focus(0.02, -0.01, 0.17, 1.0)]
        with self.boards(), self.driver() as driver:
            steady = lambda: self.heard['field'] and len(self.heard['measured']) > 60
            wait_until(steady, 20, 'a field; the driver says\n' + driver.words())
            drive, measured = self.heard['drive'][-1], self.heard['measured'][-1]
            state = self.heard['wire_state'][-1]
            self.assertTrue(state.emitting)
            self.assertEqual(state.frames_rejected, 0)
            self.assertEqual(drive.layout, 'sonic_surface')
            playing = sources(drive)
            self.assertEqual(len(playing), 256)
            peak, pressure = acoustic_field.peak(playing, (0.02, -0.01, 0.17))
            self.assertLess(math.dist(peak, (0.02, -0.01, 0.17)), 0.001)
            self.assertAlmostEqual(measured.points[0].pressure / acoustic_field.pressure(playing, (0.02, -0.01, 0.17)),
                                   1, delta=0.01)
            shares = [tactile / radiation(amplitude ** 2) for cloud in self.heard['field'][-30:]
                      for amplitude, tactile in columns(cloud, 'pressure', 'tactile') if amplitude > 50]
            self.assertGreater(len(shares), 100)
            self.assertAlmostEqual(statistics.median(shares), 0.5, delta=0.15)  # timers of a busy machine are late
            self.stream.points = []
            wait_until(lambda: not self.heard['wire_state'][-1].emitting, 10, 'silence')
            wait_until(lambda: not any(self.heard['drive'][-1].amplitude), 10, 'a silent drive')
        self.assertFalse(os.path.lexists(self.link))

    def test_tactile_firmware(self):
        self.stream.points = [focus(-0.02, 0.01, 0.2, 1.0)]
        with self.boards(wire_firmware='tactile'), self.driver('firmware=tactile') as driver:
            wait_until(lambda: len(self.heard['measured']) > 60, 20, 'a field; the driver says\n' + driver.words())
            self.assertEqual(self.heard['wire_state'][-1].frames_rejected, 0)
            self.assertAlmostEqual(self.heard['measured'][-1].modulation_frequency, 1250 / 6, delta=0.1)
            drive = self.heard['drive'][-1]
            peak, _ = acoustic_field.peak(sources(drive), (-0.02, 0.01, 0.2))
            self.assertLess(math.dist(peak, (-0.02, 0.01, 0.2)), 0.002)
            self.assertLess(max(abs(phase * 16 / (2 * math.pi) - round(phase * 16 / (2 * math.pi)))
                                for phase in drive.phase), 1e-3)

    def test_two_boards(self):
        self.stream.points = [focus(0.08, 0.0, 0.2, 1.0)]
        with self.boards(wire_boards=2), self.driver('boards=2') as driver:
            wait_until(lambda: len(self.heard['measured']) > 30, 20, 'a field; the driver says\n' + driver.words())
            drive = self.heard['drive'][-1]
            self.assertEqual(len(drive.phase), 512)
            places = sonic_surface.places() + [(x + 0.168, y) for x, y in sonic_surface.places()]
            playing = [(x, y, phase) for (x, y), phase, amplitude in zip(places, drive.phase, drive.amplitude)
                       if amplitude]
            peak, _ = acoustic_field.peak(playing, (0.08, 0.0, 0.2))
            self.assertLess(math.dist(peak, (0.08, 0.0, 0.2)), 0.001)

    def test_a_driver_that_is_killed_leaves_silence(self):
        self.stream.points = [focus(0.0, 0.0, 0.17, 1.0)]
        with self.boards(), self.driver() as driver:
            wait_until(lambda: self.heard['wire_state'] and self.heard['wire_state'][-1].emitting, 20,
                       'a sound\n' + driver.words())
            driver.process.kill()
            wait_until(lambda: not self.heard['wire_state'][-1].emitting, 10, 'silence by the guard')

    def test_wrong_parameters_are_told(self):
        for name, value in (('wire', '/no/such/folder/port'), ('wire_firmware', 'best')):
            parameters = dict({'wire': self.link}, **{name: value})
            with Driver('simulated_array', **parameters) as boards:
                self.assertEqual(boards.process.wait(20), 1)
                boards.reader.join(5)
                self.assertIn(value, boards.words())


class Rig(unittest.TestCase):
    def test_the_whole_rig_through_the_wire(self):
        """`scripts/rig device:=sonic_surface wire:=PORT` makes the port, the boards behind it and the driver before
        it."""
        with tempfile.TemporaryDirectory(prefix='wire_') as folder:
            run = rig_run.Run(dict(hands='bag', file=rig_run.bag('press_deeper'), quality='fast',
                                   device='sonic_surface', max_points='1', modulation='am',
                                   wire=os.path.join(folder, 'port'), head_spl_cap='200', duration='3.5'),
                              ['/array/focal_points', '/array/state', '/array/wire_state', '/array/drive',
                               '/array/measured'])
        self.assertEqual(run.code, 0, run.words)
        self.assertTrue(any(state.emitting for state in run.messages['/array/state']))
        states = run.messages['/array/wire_state']
        self.assertTrue(any(state.emitting for state in states), run.words)
        self.assertEqual({state.frames_rejected for state in states}, {0})
        commanded = [message.points[0].position for message in run.messages['/array/focal_points'] if message.points]
        drives = [drive for drive in run.messages['/array/drive'] if any(drive.amplitude)]
        self.assertGreater(len(drives), 20)
        for drive in drives[::5]:
            distances = []
            for point in commanded:
                start = (point.x, point.y, point.z)
                if distances and math.dist(start, last) < 1e-4:
                    continue
                last = start
                distances.append(math.dist(acoustic_field.peak(sources(drive), start)[0], start))
            self.assertLess(min(distances), 0.002, 'the pattern belongs to a focal point')


if __name__ == '__main__':
    rig_run.main('wire')
