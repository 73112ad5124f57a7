"""What a bag of a trial tells: contact by finger, work, sound, latency. A module of `trial`, no program."""
import os

import yaml

from rig_tools import HANDS, Fault, columns, has_header, opened, relative, stamp_of

SIDES = ('left', 'right')
PALM, REGIONS = 'palm', ('thumb', 'index', 'middle', 'ring', 'little', 'palm')
# Of the joint at the proximal end of the bone below a sample of skin (OpenXR, as in TrackedHand.msg): metacarpals lie
# in the palm, the wrist is taken for it.
OF_JOINT = ([PALM] * 3 + ['thumb'] * 3 + [PALM] + ['index'] * 4 + [PALM] + ['middle'] * 4 + [PALM] + ['ring'] * 4 +
            [PALM] + ['little'] * 4)
LONGEST = 0.1  # s that a message of contacts stands for, at most: hands that were lost did not touch meanwhile
OF_A_PART = ('contact_s', 'force_mean_N', 'force_max_N', 'area_mean_cm2', 'area_max_cm2')
CONTACT_FIELDS = ('fx', 'fy', 'fz', 'vx', 'vy', 'vz', 'hand', 'region', 'area')


def named(path):
    """The opened bag. Raises Fault with its path."""
    try:
        return opened(path)
    except Fault as fault:
        raise Fault('%s: %s' % (path, fault)) from None


class Part:
    """Contact of a region, or of a hand: over time."""

    def __init__(self):
        self.time = self.impulse = self.swept = self.force = self.area = 0.0

    def take(self, force, area, dt):
        """force: N, all that the clay does to it; area: m^2 of the skin that it touches"""
        size = sum(f * f for f in force) ** 0.5
        self.time, self.impulse, self.swept = self.time + dt, self.impulse + size * dt, self.swept + area * dt
        self.force, self.area = max(self.force, size), max(self.area, area)

    def numbers(self):
        time = self.time or 1.0
        return (self.time, self.impulse / time, self.force, 1e4 * self.swept / time, 1e4 * self.area)


def quantile(values, share):
    """Of a sorted list; None of an empty one."""
    return values[int(share * (len(values) - 1))] if values else None


class Summary:
    """Numbers of the bag of one run. `parts`: by (side, region), of a whole hand with the region 'hand'."""

    def __init__(self, path):
        self.path = path
        self.parts, self.work = {}, {side: 0.0 for side in SIDES}  # J, done on the clay
        self.first = self.last = self.before = None                # ns, of hands and of contacts
        self.late, self.latencies, self.levels, self.emitting = [], [], [], 0
        self.lockstep = None
        with named(path) as bag:
            names = {topic: name for topic in bag.get_type_and_topic_info().topics for name in
                     (HANDS, 'clay/contacts', 'array/state', 'rig/description') if ('/' + topic).endswith('/' + name)}
            if HANDS not in names.values():
                raise Fault('%s: has no topic %s, expected the bag of a run' % (path, HANDS))
            for topic, message, _ in bag.read_messages(topics=list(names)):
                getattr(self, names[topic].replace('/', '_'))(message)
        self.latencies.sort()

    def hands_tracked(self, message):
        stamp = message.header.stamp.to_nsec()
        self.first = stamp if self.first is None else self.first
        self.last = stamp

    def rig_description(self, message):
        told = yaml.safe_load(message.data)['parameters'].get('clay_simulator', {})
        self.lockstep = str(told.get('lockstep', False)).lower() == 'true'

    def clay_contacts(self, message):
        stamp = message.header.stamp.to_nsec()
        dt = 0.0 if self.before is None else min(max(1e-9 * (stamp - self.before), 0.0), LONGEST)
        self.before = stamp
        touched = {}
        if message.width == 0:
            return
        try:
            points = list(columns(message, CONTACT_FIELDS))
        except Fault as fault:
            raise Fault('%s: clay/contacts: %s, expected a bag of this version' % (self.path, fault)) from None
        for fx, fy, fz, vx, vy, vz, hand, region, area in points:
            side = SIDES[hand] if hand < 2 else None
            if side is None or region >= len(OF_JOINT):
                continue
            self.work[side] -= (fx * vx + fy * vy + fz * vz) * dt
            for part in ('hand', OF_JOINT[region]):
                sums = touched.setdefault((side, part), [0.0, 0.0, 0.0, 0.0])
                for k, value in enumerate((fx, fy, fz, area)):
                    sums[k] += value
        for key, (fx, fy, fz, area) in touched.items():
            self.parts.setdefault(key, Part()).take((fx, fy, fz), area, dt)

    def array_state(self, message):
        self.late.append(message.frames_late)
        self.latencies.append(1e3 * message.latency)
        self.emitting += message.emitting
        if message.emitting:
            self.levels.append(message.head_spl)

    def rows(self):
        """(name, value or None) of all numbers, in one order for all bags."""
        yield 'seconds', None if self.first is None else 1e-9 * (self.last - self.first)
        for side in SIDES:
            for region in ('hand', *REGIONS):
                part = self.parts.get((side, region), Part())
                for name, number in zip(OF_A_PART, part.numbers()):
                    yield '%s_%s_%s' % (side, region, name), number
            yield side + '_work_mJ', 1e3 * self.work[side]
        yield 'work_mJ', 1e3 * sum(self.work.values())
        yield 'head_level_max_dB', max(self.levels) if self.levels else None
        yield 'frames_emitting', self.emitting
        yield 'frames_late', max(self.late) - self.late[0] if self.late else None
        live = not self.lockstep  # in lockstep stamps are those of the recording
        yield 'latency_p50_ms', quantile(self.latencies, 0.5) if live else None
        yield 'latency_p99_ms', quantile(self.latencies, 0.99) if live else None

    def lines(self):
        """For people: what was touched, one line a part."""
        told = dict(self.rows())

        def number(name, words):
            return '' if told[name] is None else ', ' + words % told[name]
        yield '%s: %.2f s, work on the clay %.3g mJ%s%s%s%s' % (
            os.path.basename(self.path), told['seconds'] or 0.0, told['work_mJ'],
            number('head_level_max_dB', 'at most %.1f dB at the head'), number('frames_late', '%d frames late'),
            number('latency_p50_ms', 'hand to array %.1f ms'), number('latency_p99_ms', 'p99 %.1f ms'))
        for side in SIDES:
            for region in ('hand', *REGIONS):
                if (side, region) in self.parts:
                    yield '  %-5s %-6s contact %6.2f s, force %6.3f N (most %6.3f), area %5.2f cm2 (most %5.2f)' % (
                        (side, region) + self.parts[side, region].numbers())


def trim(path, new, start, end):
    """Copies to a new bag what lies from `start` to `end`, s after the first sample of the hands, and what was told
    before once for all (latched topics, tf_static). Returns how many messages that are."""
    import rosbag
    if os.path.lexists(new):
        raise Fault("'%s' exists already, expected the name of a new bag" % new)
    with named(path) as bag:
        topics = bag.get_type_and_topic_info().topics
        hands = next((topic for topic in topics if ('/' + topic).endswith('/' + HANDS)), None)
        if hands is None:
            raise Fault('%s: has no topic %s, expected the bag of a run' % (path, HANDS))
        namespace = hands[:-len(HANDS)] or '/'
        first = next((stamp_of(raw[1]) for _, raw, _ in bag.read_messages(topics=[hands], raw=True)), None)
        last = max(stamp_of(raw[1]) for _, raw, _ in bag.read_messages(topics=[hands], raw=True))
        if first is None or first + 1e9 * start > last:
            raise Fault('%s: --from %g is after its end, expected less than %.3f s' %
                        (path, start, 1e-9 * (last - first)))
        low, high = first + int(1e9 * start), first + int(1e9 * end)
        now, count = first, 0
        with rosbag.Bag(new, 'w', compression=bag.get_compression_info().compression) as copy:
            for topic, raw, when, header in bag.read_messages(raw=True, return_connection_header=True):
                dated = has_header(raw[4]) and relative(topic, namespace) not in (None, 'joint_states', 'rig/changes')
                stamp = stamp_of(raw[1]) if dated else now
                now = stamp if topic == hands else now
                latched = header.get('latching', b'0') in (b'1', '1') or topic.endswith('tf_static')
                if low <= stamp <= high or (latched and stamp < low):
                    copy.write(topic, raw, when, raw=True, connection_header=header)
                    count += 1
    return count
