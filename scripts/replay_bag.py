"""What a bag tells of its run: what it was, its messages as of today, its changes. A module of `replay`, no program."""
import os
import struct

import rosbag
import rosbag.migration
import roslib.message
import rospkg
import yaml

from rig_tools import PACKAGE, Fault, absolute, connections, one_line, opened, relative

FORMAT = 1  # of the description
CHANGES = 'rig/changes'


def description_of(bag):
    """(namespace, description) of the one run that the bag holds."""
    topics = [topic for topic, kind, _ in connections(bag)
              if topic.endswith('/rig/description') and kind == 'std_msgs/String']
    if not topics:
        raise Fault('has no topic rig/description: it was recorded by an older release, or not by record:= or '
                           'record.launch')
    texts = {(topic, message.data) for topic, message, _ in bag.read_messages(topics=topics)}
    if len(texts) != 1:
        raise Fault('has %d descriptions (%s), expected that of one run' % (len(texts), ', '.join(topics)))
    topic, text = texts.pop()
    try:
        told = yaml.safe_load(text)
        number, version = told['format'], str(told['package']['version'])
        if number == FORMAT:
            require_parts(told)
    except (yaml.YAMLError, KeyError, TypeError) as error:
        raise Fault('%s cannot be read, expected the YAML of describe_rig: %s' %
                           (topic, one_line(error))) from None
    here = installed_version()
    if number != FORMAT or version.split('.')[0] != here.split('.')[0]:
        raise Fault('is of version %s (description %s), expected version %s (description %d): replay it with '
                           'the release that recorded it' % (version, number, here.split('.')[0] + '.x', FORMAT))
    for entry in told['files']:
        if 'missing' in entry:
            raise Fault("has no %s '%s': %s" % (entry['role'], entry['name'], entry['missing']))
    return topic[:-len('/rig/description')] or '/', told


def require_parts(told):
    """Raises KeyError or TypeError where a description lacks what a replay is made from."""
    for part, kind in (('namespace', str), ('nodes', list), ('arguments', dict), ('parameters', dict), ('files', list)):
        if not isinstance(told[part], kind):
            raise TypeError("'%s' is no %s" % (part, kind.__name__))
    for node in ('hand_tracking', 'clay_simulator'):
        if not isinstance(told['parameters'][node], dict):
            raise TypeError("'%s' has no parameters" % node)
    for entry in told['files']:
        texts = [entry['role'], entry['name']]
        texts += [] if 'missing' in entry else [entry['path'], entry['text'] if 'text' in entry else entry['zlib']]
        if not all(isinstance(text, str) for text in texts):
            raise TypeError("a file of role '%s' has parts that are no texts" % entry['role'])
    if not any(entry['role'] == 'scene' for entry in told['files']):
        raise KeyError('a file of role scene')


def installed_version():
    return rospkg.RosPack().get_manifest(PACKAGE).version


def own_rules():
    return os.path.join(rospkg.RosPack().get_path(PACKAGE), 'config', 'migration.bmr')


def changed_since(kind, md5):
    """Whether a message type is one of this package whose definition is another here."""
    if not kind.startswith(PACKAGE + '/'):
        return False
    known = roslib.message.get_message_class(kind)
    return known is None or known._md5sum != md5


def migrated(path, folder, rules):
    """The bag with the messages of this release: itself, or a copy that rules for `rosbag fix` made; and of each topic
    the fields that its messages did not have then."""
    with opened(path) as bag:
        changed = [one for one in connections(bag) if changed_since(*one[1:])]
        if not changed:
            return path, {}
        migrator, targets = rosbag.migration.MessageMigrator([own_rules()] + rules, plugins=False), {}
        copy, unknown = os.path.join(folder, 'migrated.bag'), {}
        with rosbag.Bag(copy, 'w') as written:
            for topic, raw, when, header in bag.read_messages(raw=True, return_connection_header=True):
                if changed_since(raw[0], raw[2]):
                    if (topic, raw[2]) not in targets:
                        targets[topic, raw[2]] = target_of(migrator, topic, raw[4])
                        unknown[topic] = set(targets[topic, raw[2]].__slots__) - set(raw[4].__slots__)
                    new = targets[topic, raw[2]]
                    raw = migrator.migrate_raw(raw, (new._type, None, new._md5sum, None, new))
                    header = dict(header, type=new._type, md5sum=new._md5sum, message_definition=new._full_text)
                written.write(topic, raw, when, raw=True, connection_header=header)
    print('replay: migrated by rules: %s' % ', '.join(topic for topic, _, _ in changed))
    for topic, fields in sorted(unknown.items()):
        if fields:
            print('replay: not compared, because the recorded %s does not have them: %s'
                  % (topic, ', '.join(sorted(fields))))
    return copy, unknown


def target_of(migrator, topic, old):
    """The type to which rules bring messages of an older type."""
    new = migrator.find_target(old)
    rules = [] if new is None else migrator.expand_rules([node.rule for node in migrator.find_path(old, new)])
    if new is None or not all(rule.valid for rule in rules):
        raise Fault('has messages of another version: %s of %s (md5 %s, here %s): replay it with the release '
                           'that recorded it, or give rules for `rosbag fix` (--rules FILE.bmr)'
                           % (old._type, topic, old._md5sum, new._md5sum if new else 'none'))
    return new


def require_whole(bag, topic):
    """The number of samples of the hands. Raises Fault where one is missing: the clay comes from all of them."""
    before, count = None, 0
    for _, (_, data, _, _, _), _ in bag.read_messages(topics=[topic], raw=True):
        sequence, = struct.unpack_from('<I', data)
        if before is None and sequence > 1:
            raise Fault('begins with sample %d of %s, expected the first: what the clay went through before is '
                               'not in it' % (sequence, topic))
        if before is not None and sequence != before + 1:
            raise Fault('lacks samples %d to %d of %s' % (before + 1, sequence - 1, topic))
        before, count = sequence, count + 1
    if count == 0:
        raise Fault('has no message on %s' % topic)
    return count


def changes_of(bag, namespace):
    """The parameters that were changed during the run, as ~changes of each node has them. Raises Fault where
    the bag tells that something was changed, but not when."""
    changes, before = {}, {}
    for _, message, _ in bag.read_messages(topics=[absolute(CHANGES, namespace)]):
        if message.header.seq > before.get(message.node, 0) + 1:
            raise Fault('lacks changes of parameters of %s on %s' % (message.node, CHANGES))
        before[message.node] = message.header.seq
        stamp = message.header.stamp
        changes.setdefault(message.node, []).append({'stamp': [stamp.secs, stamp.nsecs],
                                                     'parameters': message.parameters})
    updates = {}
    for topic, (_, data, _, _, _), _ in bag.read_messages(raw=True, connection_filter=lambda topic, *_: topic.endswith(
            '/parameter_updates')):
        updates.setdefault(relative(topic, namespace), set()).add(data)
    for topic, values in updates.items():
        if topic and len(values) > 1 and topic.split('/')[0] not in changes:
            raise Fault('parameters were changed during the run (%s), but it has no %s, which has the frames of the '
                        'changes' % (topic, CHANGES))
    changes.pop('hand_tracking', None)  # its filters have made the hands that are played
    return changes
