"""Messages as a rig sends them, and what makes them worse. A module of `fuzz_topics`, no program."""
import copy
import math
import random
import re
import struct
import time

import genpy
import roslib.message
from genpy import Duration, Time
from geometry_msgs.msg import TransformStamped
from sensor_msgs.msg import PointField

TYPES = {'hands/tracked': 'tactile_clay/TrackedHands', 'hands/skin': 'sensor_msgs/PointCloud2',
         'hands/bones': 'visualization_msgs/MarkerArray', 'clay/contacts': 'sensor_msgs/PointCloud2',
         'clay/particles': 'sensor_msgs/PointCloud2', 'clay/status': 'tactile_clay/ClayStatus',
         'hands/pressure': 'sensor_msgs/PointCloud2', 'array/focal_points': 'tactile_clay/FocalPointArray',
         'array/rendering': 'tactile_clay/RenderingReport', 'array/drive': 'tactile_clay/ArrayDrive',
         'array/measured': 'tactile_clay/FocalPointArray', 'array/state': 'tactile_clay/ArrayState',
         'joint_states': 'sensor_msgs/JointState', 'hands/joint_states_left': 'sensor_msgs/JointState',
         'hands/joint_states_right': 'sensor_msgs/JointState', '/tf': 'tf2_msgs/TFMessage',
         '/tf_static': 'tf2_msgs/TFMessage'}
HUGE, HUGE_ONE_IN = 20_000_000, 1000  # bytes of a list now and then
PLACEHOLDER = 'NOT_UTF8'

FLOATS = [0.0, -0.0, 1.0, -1.0, math.nan, math.inf, -math.inf, 3.4e38, -3.4e38, 1e-45, 1e9, -1e9, 1e-3]
TEXTS = ['', '%s%n%d%s%s', 'x' * 5000, '/world', 'world', 'array', 'array\n[ERROR] forged', 'tab\tbell\x07',
         PLACEHOLDER, '../../etc',
         'naïve ☃', '$(find x)', '/', 'a b']
TIMES = [(0, 0), (0, 1), (2**32 - 1, 2**32 - 1), (2**32 - 1, 999999999), (2**31, 0), (2**31 - 1, 999999999),
         (1, 2**32 - 1)]
RANGES = {'bool': (0, 1), 'byte': (-128, 127), 'char': (0, 255),
          **{'int%d' % n: (-2**(n - 1), 2**(n - 1) - 1) for n in (8, 16, 32, 64)},
          **{'uint%d' % n: (0, 2**n - 1) for n in (8, 16, 32, 64)}}


class TFMessage(genpy.Message):
    """tf2_msgs/TFMessage, whose Python package the rig does not need. It is only ever written."""
    _type, _md5sum, _has_header = 'tf2_msgs/TFMessage', '94810edda583a504dfda3829e70d7eec', False
    _full_text = 'geometry_msgs/TransformStamped[] transforms'
    __slots__, _slot_types = ['transforms'], ['geometry_msgs/TransformStamped[]']

    def __init__(self, transforms=()):
        super().__init__()
        self.transforms = list(transforms)

    def _get_types(self):
        return self._slot_types

    def serialize(self, buff):
        buff.write(struct.pack('<I', len(self.transforms)))
        for transform in self.transforms:
            transform.serialize(buff)

    @classmethod
    def sample(cls):
        transforms = []
        for parent, child in (('world', 'hand_left'), ('world', 'fuzz_1'), ('fuzz_1', 'fuzz_2'),
                              ('fuzz_2', 'hand_right_wrist')):
            transform = TransformStamped(child_frame_id=child)
            transform.header.frame_id = parent
            transform.header.stamp = Time.from_sec(time.time())
            transform.transform.rotation.w = 1.0
            transforms.append(transform)
        return cls(transforms=transforms)


FIELDS = {'hands/skin': 'x y z normal_x normal_y normal_z vx vy vz area hand:u region:u weight pad_distance',
          'clay/contacts': 'x y z fx fy fz index:u', 'clay/particles': 'x y z rgb vx vy vz density body:u',
          'hands/pressure': 'x y z normal_x normal_y normal_z pressure force area weight'}


def stamped(message, frame):
    message.header.frame_id, message.header.stamp = frame, Time.from_sec(time.time())
    return message


def usual(name, generator):
    """A message as the rig sends it, for a topic on which none passes."""
    kind = roslib.message.get_message_class(TYPES[name])
    if name in FIELDS:
        names = FIELDS[name].split()
        cloud = stamped(kind(height=1, width=200, point_step=4 * len(names), is_dense=True),
                        'array' if name == 'hands/pressure' else 'world')
        cloud.row_step = cloud.width * cloud.point_step
        cloud.fields = [PointField(field.split(':')[0], 4 * i,
                                   PointField.UINT32 if ':' in field else PointField.FLOAT32, 1)
                        for i, field in enumerate(names)]
        for _ in range(cloud.width):
            cloud.data += b''.join(struct.pack('<I', generator.randrange(200)) if ':' in field
                                   else struct.pack('<f', generator.uniform(-0.1, 0.2))
                                   for field in names)
        return cloud
    if name == 'hands/tracked':
        hands = stamped(kind(), 'world')
        hand = roslib.message.get_message_class('tactile_clay/TrackedHand')
        for side in (0, 1):
            one = hand(id=side + 1, side=side, confidence=1.0, radii=[0.008] * 26)
            for i, joint in enumerate(one.joints):
                finger, along = divmod(i, 5)
                joint.position.x, joint.position.y, joint.position.z = 0.02 * along, 0.02 * finger + 0.2 * side, 0.05
                joint.orientation.w = 1.0
            hands.hands.append(one)
        return hands
    if name in ('array/focal_points', 'array/measured'):
        point = roslib.message.get_message_class('tactile_clay/FocalPoint')
        points = stamped(kind(modulation_frequency=200.0), 'array')
        for i in range(3):
            one = point(id=i, pressure=500.0, intensity=0.5)
            one.position.x, one.position.z = 0.03 * i, 0.15
            points.points.append(one)
        return points
    if name.split('/')[-1].startswith('joint_states'):
        return stamped(kind(name=['wheel_joint', 'plate_joint'], position=[0.1, 0.2], velocity=[0.0, 0.0]), '')
    return kind()


class Fuzzer:
    """Makes messages worse, the same ones for the same seed and samples."""

    def __init__(self, seed):
        self.random = random.Random(seed)

    def number(self, kind):
        low, high = RANGES[kind]
        return self.random.choice([low, high, 0, min(1, high), self.random.randint(low, high)])

    def scalar(self, kind, old):
        if kind in RANGES:
            return self.number(kind)
        if kind in ('float32', 'float64'):
            return self.random.choice(FLOATS + [self.random.uniform(-1, 1), old * 1e3 if kind == 'float64' else 2.0])
        if kind == 'string':
            return self.random.choice(TEXTS)
        if kind in ('time', 'duration'):
            stamp = (Time if kind == 'time' else Duration)()
            stamp.secs, stamp.nsecs = self.random.choice(TIMES) if kind == 'time' else (-2**31, -1)
            if kind == 'time' and self.random.random() < 0.5:  # near now, as one who shares the clock sends
                now = time.time() + self.random.choice([0.0, 0.0, -5.0, 5.0, self.random.uniform(-0.2, 0.2)])
                stamp.secs, stamp.nsecs = int(now), int(1e9 * (now % 1.0))
            return stamp
        raise ValueError(kind)

    def bytes(self, old):
        if self.random.randrange(HUGE_ONE_IN) == 0:
            return bytes(HUGE)
        data = bytearray(old or self.random.randbytes(self.random.randrange(400)))
        for _ in range(self.random.randrange(1, 20)):
            if len(data) >= 4:
                at = 4 * self.random.randrange(len(data) // 4)
                data[at:at + 4] = self.random.choice([b'\0\0\xc0\x7f', b'\0\0\x80\x7f', b'\xff' * 4, b'\0' * 4,
                                                      self.random.randbytes(4)])
        return bytes(data[:self.random.choice([len(data), len(data), len(data) // 2, max(0, len(data) - 1)])])

    def list(self, kind, old, length):
        if kind in ('uint8', 'char'):
            return self.bytes(old) if length is None else self.random.randbytes(length)
        items = list(old)
        if length is None:
            choice = self.random.randrange(5)
            if choice == 0:
                items = []
            elif choice == 1 and len(items) < 2000:
                items = items + items
            elif choice == 2:
                items = items[:len(items) // 2]
            if choice == 3 and len(items) < 300:
                blank = (lambda: self.scalar(kind, 1.0)) if '/' not in kind else roslib.message.get_message_class(kind)
                items = items + [blank() for _ in range(self.random.randrange(1, 300))]
        for _ in range(3 if '/' not in kind and items else 0):
            at = self.random.randrange(len(items))
            items[at] = self.scalar(kind, items[at])
        return items

    def leaves(self, message):
        """Places of a message: (owner, slot, type), of a long list those of some items."""
        for slot, kind in zip(message.__slots__, message._slot_types):
            value = getattr(message, slot)
            yield message, slot, kind
            if kind == 'Header' or ('/' in kind and not kind.endswith(']')):
                yield from self.leaves(value)
            elif '/' in kind and value:
                for item in self.random.sample(list(value), min(3, len(value))):
                    yield from self.leaves(item)

    def worse(self, message):
        message = copy.deepcopy(message)
        for _ in range(self.random.choice([0, 1, 1, 2, 5, 20])):
            owner, slot, kind = self.random.choice(list(self.leaves(message)))
            found = re.fullmatch(r'(.*)\[(\d*)\]', kind)
            value = getattr(owner, slot)
            if found and not ('/' in found[1] and found[2]):
                setattr(owner, slot, self.list(found[1], value, int(found[2]) if found[2] else None))
            elif not found and '/' not in kind and kind != 'Header':
                setattr(owner, slot, self.scalar(kind, value))
        return message
