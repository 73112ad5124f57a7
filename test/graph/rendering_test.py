#!/usr/bin/env python3
"""What the renderer and the simulated array tell of their work: see rendering.test."""
import math
import os
import struct
import tempfile
import unittest

import rig_messages
import rig_run

TOPICS = rig_run.CHAIN + ['/tf_static', '/array/rendering', '/array/acoustics', '/array/measured', '/array/field']
AIR = 101325.0 / (287.05 * 293.15)             # kg/m^3, dry at 20 degrees C
SOUND = 331.3 * math.sqrt(293.15 / 273.15)     # m/s


class Rendering(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.run_ = rig_run.Run(dict(rig_run.LOCKSTEP, modulation='am', hands='bag', file=rig_run.bag('press_deeper'),
                                    phase_levels='32'),
                               TOPICS)
        cls.points = rig_messages.focal_points(cls.run_)
        cls.touched = [stamp for stamp, points in cls.points.items() if points]

    def test_the_run_is_worth_looking_at(self):
        self.assertEqual(self.run_.code, 0, self.run_.words)
        self.assertGreater(len(self.touched), 30)

    def test_each_frame_tells_how_it_was_rendered(self):
        reports = self.run_.messages.by_stamp('/array/rendering')
        gains = {reports[stamp].gain for stamp in self.touched}
        self.assertEqual(len(gains), 1)
        self.assertGreater(gains.pop(), 0)
        for stamp in self.touched:
            report, points = reports[stamp], self.points[stamp]
            self.assertEqual((len(report.wanted), len(report.granted)), (len(points), len(points)))
            for point, wanted, granted in zip(points, report.wanted, report.granted):
                self.assertAlmostEqual(wanted / (report.gain * point.pressure), 1, places=4)
                self.assertTrue(0 < granted <= wanted * (1 + 1e-5), (granted, wanted))
            area = self.run_.messages.by_stamp('/array/focal_points')[stamp].area
            force = 1e3 * sum(granted * place for granted, place in zip(report.granted, area))  # mN
            self.assertAlmostEqual(report.force / force, 1, delta=1e-4)
            self.assertTrue(all(6e-5 < place < 4e-4 for place in area), 'spots of 9 to 23 mm: %s' % (area,))
            self.assertAlmostEqual(report.vibration, max(0.0, 20 * math.log10(report.force / 0.4)), delta=1e-3)
            self.assertEqual(report.static_force, 0, 'AM')
            weaker = sum(granted < 0.9999 * wanted for wanted, granted in zip(report.wanted, report.granted))
            self.assertGreaterEqual(report.compressed_points, weaker)
            self.assertLessEqual(report.saturated_points, report.compressed_points)
            for error in (report.error, report.weighted_error):
                self.assertTrue(0 < error < 1, error)

    def test_the_field_does_what_was_commanded(self):
        reports = self.run_.messages.by_stamp('/array/acoustics')
        states = self.run_.messages.by_stamp('/array/state')
        measured = self.run_.messages.by_stamp('/array/measured')
        for stamp in self.touched:
            report = reports[stamp]
            self.assertEqual(list(report.id), [point.id for point in self.points[stamp]])
            self.assertLess(report.error, 0.01)
            scale = sum(a / c for a, c in zip(report.achieved, report.commanded)) / len(report.id)
            self.assertTrue(0.7 < scale < 1.05, scale)
            for achieved, point in zip(report.achieved, measured[stamp].points):
                self.assertAlmostEqual(achieved / point.pressure, 1, places=4)
            self.assertTrue(0 < report.side_lobe < 1, report.side_lobe)
            self.assertAlmostEqual(report.head_spl, states[stamp].head_spl, places=2)

    def test_tactile_pressure_is_half_the_radiation_pressure(self):
        clouds = [cloud for cloud in self.run_.messages['/array/field'] if cloud.header.stamp.to_nsec() in self.touched]
        self.assertTrue(clouds)
        for cloud in clouds[::10]:
            at = {field.name: field.offset for field in cloud.fields}
            strongest = 0
            for i in range(cloud.width):
                read = lambda name: struct.unpack_from('<f', cloud.data, i * cloud.point_step + at[name])[0]
                pressure, tactile = read('pressure'), read('tactile')
                self.assertAlmostEqual(tactile, 0.5 * pressure ** 2 / (AIR * SOUND ** 2), delta=1e-3 + 1e-3 * tactile)
                strongest = max(strongest, tactile)
            self.assertGreater(strongest, 0)

    def test_normals_of_the_skin_travel_if_they_are_asked_for(self):
        with tempfile.TemporaryDirectory() as folder:
            rig = os.path.join(folder, 'rig.yaml')
            with open(rig, 'w') as file:
                file.write('field_normals: true\n')
            run = rig_run.Run(dict(rig_run.LOCKSTEP, hands='bag', file=rig_run.bag('press_deeper'), quality='fast',
                                   modulation='field', rig=rig), rig_run.CHAIN)
        self.assertEqual(run.code, 0, run.words)
        touched = [message for message in run.messages['/array/focal_points'] if message.points]
        self.assertGreater(len(touched), 30)
        down = force = 0.0
        for message in touched:
            self.assertEqual(len(message.normal), len(message.points))
            for normal in message.normal:
                self.assertAlmostEqual(math.sqrt(normal.x ** 2 + normal.y ** 2 + normal.z ** 2), 1.0, places=3)
            down -= sum(point.pressure * normal.z for point, normal in zip(message.points, message.normal))
            force += sum(point.pressure for point in message.points)
        self.assertGreater(down, 0.3 * force, 'a finger that presses from above looks down')


if __name__ == '__main__':
    rig_run.main('rendering')
