"""What is read out of the messages of a run: clouds, places in the world, hands that press. A module of tests."""
import math
import struct


def columns(cloud, *names):
    """Float fields of each point of a cloud: a tuple a point."""
    offset = {field.name: field.offset for field in cloud.fields}
    return [tuple(struct.unpack_from('<f', cloud.data, i * cloud.point_step + offset[name])[0] for name in names)
            for i in range(cloud.width)]


def rotate(q, v):
    """v turned by the quaternion q."""
    u, w = (q.x, q.y, q.z), q.w
    cross = lambda a, b: (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])
    t = tuple(2 * c for c in cross(u, v))
    return tuple(a + w * b + c for a, b, c in zip(v, t, cross(u, t)))


def array_to_world(run):
    """Function from a position in frame `array` to one in `world`, by the /tf_static of the run."""
    for message in run.messages['/tf_static']:
        for found in message.transforms:
            if found.header.frame_id == 'world' and found.child_frame_id == 'array':
                pose = found.transform
                shift = (pose.translation.x, pose.translation.y, pose.translation.z)
                return lambda p: tuple(a + b for a, b in zip(rotate(pose.rotation, (p.x, p.y, p.z)), shift))
    raise AssertionError('nobody told where the array is')


def distance(a, b):
    return math.dist(tuple(a), tuple(b))


def lowest_skin(hand):
    """Height of the lowest skin over the table, m: a capsule's lowest point is that of one of its end spheres."""
    return min(joint.position.z - radius for joint, radius in list(zip(hand.joints, hand.radii))[1:])


def pressing(heights, below):
    """Stamps at which a hand is lower than `below`, m, and does not yet rise: when it rises, what it leaves is a dent.

    heights: of the lowest skin over the table by stamp, m.
    """
    lowest = min(heights.values())
    rises = max(stamp for stamp, height in heights.items() if height < lowest + 1e-5)
    return [stamp for stamp, height in heights.items() if height < below and stamp <= rises]


def focal_points(run):
    """Focal points of each frame by its stamp, ns."""
    return {stamp: message.points for stamp, message in run.messages.by_stamp('/array/focal_points').items()}
