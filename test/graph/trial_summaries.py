"""Cases of trial_test.py about what a bag of a trial tells. A module, no program."""
import os
import shutil
import struct
import sys
import tempfile
import unittest

import rosbag
import rospy
from sensor_msgs.msg import PointCloud2, PointField
from std_msgs.msg import Header
from tactile_clay.msg import ArrayState, TrackedHands

import rig_run

sys.path.insert(0, os.path.join(rig_run.PACKAGE, 'scripts'))
from rig_tools import Fault
from trial_summary import Summary, trim

SIDE, REGION = 1, 9  # right hand, bone of the index finger that begins at its distal joint


def cloud(stamp, points):
    names = ('x', 'y', 'z', 'fx', 'fy', 'fz', 'index', 'vx', 'vy', 'vz', 'hand', 'region', 'area')
    whole = ('index', 'hand', 'region')
    fields = [PointField(name, 4 * k, PointField.UINT32 if name in whole else PointField.FLOAT32, 1)
              for k, name in enumerate(names)]
    code = '<' + ''.join('I' if name in whole else 'f' for name in names)
    step = 4 * len(names)
    return PointCloud2(header=Header(stamp=stamp, frame_id='world'), height=1, width=len(points), fields=fields,
                       point_step=step, row_step=step * len(points), is_dense=True,
                       data=b''.join(struct.pack(code, *point) for point in points))


class Summaries(unittest.TestCase):
    """A finger pushes with 2 N down at 0.1 m/s for a second: 0.2 J; another hand lies still with 1 N."""

    def setUp(self):
        self.folder = tempfile.mkdtemp(prefix='trial_test_')
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)
        self.bag = os.path.join(self.folder, 'run.bag')
        with rosbag.Bag(self.bag, 'w') as bag:
            for k in range(101):
                stamp = rospy.Time(1000 + k // 50, k % 50 * 20000000)
                points = [(0, 0, 0, 0, 0, 1.5, 7, 0, 0, -0.1, SIDE, REGION, 1e-4),
                          (0, 0, 0, 0, 0, 0.5, 8, 0, 0, -0.1, SIDE, REGION, 2e-4)]
                points = points if 0 < k <= 50 else []
                still = [(0, 0, 0, 0, 0.6, 0.8, 9, 0, 0, 0, 0, 0, 5e-4)]
                bag.write('/lab/hands/tracked', TrackedHands(header=Header(stamp=stamp)), stamp)
                bag.write('/lab/clay/contacts', cloud(stamp, points + (still if k > 50 else [])), stamp)
                state = ArrayState(header=Header(stamp=stamp), emitting=k > 50, head_spl=k, latency=1e-3 * k,
                                   frames_late=k // 40)
                bag.write('/lab/array/state', state, stamp)

    def test_numbers_of_a_known_run(self):
        told = dict(Summary(self.bag).rows())
        for name, expected in dict(
                seconds=2.0, right_index_contact_s=1.0, right_index_force_mean_N=2.0, right_index_force_max_N=2.0,
                right_index_area_mean_cm2=3.0, right_hand_force_max_N=2.0, right_thumb_contact_s=0.0,
                right_work_mJ=200.0, left_palm_contact_s=1.0, left_palm_force_mean_N=1.0, left_palm_area_max_cm2=5.0,
                left_work_mJ=0.0, work_mJ=200.0, head_level_max_dB=100.0, frames_emitting=50, frames_late=2,
                latency_p50_ms=50.0, latency_p99_ms=99.0).items():
            self.assertAlmostEqual(told[name], expected, delta=1e-4 * max(1.0, expected), msg=name)

    def test_a_part_of_a_bag(self):
        new = os.path.join(self.folder, 'part.bag')
        trim(self.bag, new, 0.5, 1.0)
        told = dict(Summary(new).rows())
        self.assertAlmostEqual(told['seconds'], 0.5, delta=1e-6)
        self.assertAlmostEqual(told['right_index_contact_s'], 0.5, delta=1e-6)
        for start, path, words in ((0.5, new, 'exists already'), (3.0, new + '2', 'is after its end')):
            with self.assertRaisesRegex(Fault, words):
                trim(self.bag, path, start, 4.0)
