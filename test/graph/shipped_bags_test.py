#!/usr/bin/env python3
"""What the shipped hands do to the clay: see shipped_bags.test."""
import math
import struct
import unittest

import rig_run


def bodies(cloud):
    """Particles of clay/particles by body: lists of (x, y, z), m."""
    offset = {field.name: field.offset for field in cloud.fields}
    found = {}
    for i in range(cloud.width):
        at = i * cloud.point_step
        position = struct.unpack_from('<3f', cloud.data, at + offset['x'])
        found.setdefault(struct.unpack_from('<I', cloud.data, at + offset['body'])[0], []).append(position)
    return found


def mean(values):
    values = list(values)
    return sum(values) / len(values)


class ShippedBags(unittest.TestCase):
    def play(self, name, **arguments):
        run = rig_run.Run(dict(rig_run.LOCKSTEP, hands='bag', file=rig_run.bag(name), **arguments),
                          rig_run.CHAIN + ['/clay/particles'])
        self.assertEqual((run.code, run.left), (0, []), run.words)
        stamps = rig_run.input_stamps(name)
        for topic in rig_run.CHAIN + ['/clay/particles']:
            self.assertEqual(run.messages.stamps(topic), stamps, topic)
        clouds = run.messages['/clay/particles']
        for cloud in (clouds[0], clouds[-1]):
            for body in bodies(cloud).values():
                self.assertTrue(all(math.isfinite(c) for position in body for c in position))
        # The hands are not there, then they are felt, then they are gone.
        felt = [bool(message.points) for message in run.messages['/array/focal_points']]
        self.assertFalse(felt[0] or felt[-1])
        self.assertGreater(sum(felt), 120)
        return bodies(clouds[30]), bodies(clouds[-1])  # once settled, and in the end

    def test_all_four_blocks_are_kneaded(self):
        before, after = self.play('knead')
        self.assertEqual(sorted(before), [0, 1, 2, 3])
        for body, name in enumerate(('red', 'yellow', 'green', 'blue')):
            self.assertEqual(len(before[body]), len(after[body]))
            moved = mean(math.dist(a, b) for a, b in zip(before[body], after[body]))
            self.assertGreater(moved, 0.005, name)
            # In a block that was only pushed, particles keep their distances.
            changed = mean(abs(math.dist(before[body][0], a) - math.dist(after[body][0], b))
                           for a, b in zip(before[body], after[body]))
            self.assertGreater(changed, 0.001, name + ' was pushed, not pressed')
            for x, y, z in after[body]:
                self.assertTrue(abs(x) < 0.2 and abs(y) < 0.2 and 0.0 < z < 0.1, '%s at %s' % (name, (x, y, z)))

    def test_the_lump_is_shaped_and_stays_on_the_wheel(self):
        before, after = (found[0] for found in self.play('potter', scene='potters_wheel'))
        self.assertEqual(len(before), 4169)
        # Taller than it was, and narrower where the hands have most of their skin.
        radius = lambda x, y: math.hypot(x, y)
        waist = lambda lump: mean(radius(x, y) for x, y, z in lump if 0.01 < z < 0.02)
        self.assertGreater(max(z for _, _, z in after), max(z for _, _, z in before) + 0.002)
        self.assertLess(waist(after), waist(before) - 0.0005)
        self.assertLess(radius(mean(x for x, _, _ in after), mean(y for _, y, _ in after)), 0.005)
        on_the_wheel = sum(radius(x, y) < 0.1 and 0.0 < z < 0.12 for x, y, z in after)
        self.assertGreater(on_the_wheel, 0.99 * len(after))


if __name__ == '__main__':
    rig_run.main('shipped_bags')
