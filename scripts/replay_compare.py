"""The first difference between the messages of two runs. A module of `replay`, no program."""
import struct

import genpy

from rig_tools import FORMATS, has_header, stamp_of


class Difference:
    """Where two runs first differ on a topic."""

    def __init__(self, topic, stamp, words):
        self.topic, self.stamp, self.words = topic, stamp, words


def by_how_much(mine, theirs):
    if isinstance(mine, (int, float)) and isinstance(theirs, (int, float)) and not isinstance(mine, bool):
        return ', by %.3g' % abs(theirs - mine)
    return ''


def values_differ(path, mine, theirs):
    return '%s: recorded %r, replayed %r%s' % (path, mine, theirs, by_how_much(mine, theirs))


def bytes_difference(path, mine, theirs):
    if mine == theirs:
        return None
    at = first_difference(mine, theirs)
    return values_differ('%s[%d:]' % (path, at), mine[at:at + 8], theirs[at:at + 8])


def first_difference(mine, theirs):
    return next((i for i, pair in enumerate(zip(mine, theirs)) if pair[0] != pair[1]), min(len(mine), len(theirs)))


def cloud_difference(path, mine, theirs):
    """Words about the first number of a point that differs between two clouds of the same layout, or None."""
    step = mine.point_step
    if step == 0 or len(mine.data) != len(theirs.data) or mine.data == theirs.data:
        return bytes_difference(path + 'data', mine.data, theirs.data)
    point, offset = divmod(first_difference(mine.data, theirs.data), step)
    for field in mine.fields:
        code = '<' + FORMATS.get(field.datatype, 'B')
        size = struct.calcsize(code)
        if field.offset <= offset < field.offset + size * max(1, field.count):
            start = point * step + field.offset + (offset - field.offset) // size * size
            one, other = (struct.unpack_from(code, cloud.data, start)[0] for cloud in (mine, theirs))
            return values_differ('%spoints[%d].%s' % (path, point, field.name), one, other)
    return bytes_difference(path + 'data', mine.data, theirs.data)


def field_difference(mine, theirs, left_out=(), path=''):
    """Words about the first field in which two messages differ, or None. Sequence numbers are not compared."""
    if isinstance(mine, genpy.Message):
        cloud = mine._type == 'sensor_msgs/PointCloud2'
        inner = path + '.' if path else ''
        for name in mine.__slots__:
            if inner + name in left_out or (name == 'seq' and path.endswith('header')) or (cloud and name == 'data'):
                continue
            found = field_difference(getattr(mine, name), getattr(theirs, name), left_out, inner + name)
            if found:
                return found
        return cloud_difference(inner, mine, theirs) if cloud else None
    if isinstance(mine, (list, tuple)):
        if len(mine) != len(theirs):
            return values_differ('length of ' + path, len(mine), len(theirs))
        for i, pair in enumerate(zip(mine, theirs)):
            found = field_difference(*pair, left_out, '%s[%d]' % (path, i))
            if found:
                return found
        return None
    if isinstance(mine, bytes):
        return bytes_difference(path, mine, theirs)
    # As they are written: a zero has a sign, and what is no number is equal to itself.
    return None if repr(mine) == repr(theirs) else values_differ(path, mine, theirs)


def differs(mine, theirs, left_out):
    """Words about how two messages (serialized bytes, class) differ beside fields that are left out, or None."""
    start = 4 if has_header(mine[1]) else 0  # behind the sequence number
    if mine[0][start:] == theirs[0][start:]:
        return None
    messages = []
    for data, kind in (mine, theirs):
        messages.append(kind())
        messages[-1].deserialize(data)
    return field_difference(*messages, left_out)


def compare(topic, left_out, recorded, replayed, last, live):
    """(messages that are the same, Difference or None) of a topic. The recorder may have missed answers to the sample
    of stamp `last`; of a `live` run, to any."""
    def messages(bag):
        for _, (_, data, _, _, kind), _ in bag.read_messages(topics=[topic], raw=True):
            yield data, kind
    by_the_clock = 'header.stamp' in left_out

    def stamp(message):
        return None if by_the_clock or not has_header(message[1]) else stamp_of(message[0])
    count, ours = 0, messages(replayed)
    for mine in messages(recorded):
        when, theirs = stamp(mine), next(ours, None)
        while live and when is not None and theirs is not None and stamp(theirs) < when:
            theirs = next(ours, None)
        if theirs is None:
            return count, Difference(topic, when, 'recorded message %d, replayed none' % count)
        if stamp(theirs) != when:
            return count, Difference(topic, min(when, stamp(theirs)), 'message %d: stamp: recorded %s, replayed %s' %
                                     (count, seconds(when), seconds(stamp(theirs))))
        words = differs(mine, theirs, left_out)
        if words:
            return count, Difference(topic, when, words)
        count += 1
    more = next(ours, None)
    if more is not None and not live and stamp(more) is not None and stamp(more) < last:
        return count, Difference(topic, stamp(more), 'replayed message %d, recorded none' % count)
    return count, None


def seconds(stamp):
    return 'none' if stamp is None else '%d.%09d' % divmod(stamp, 10**9)
