"""What the scripts of the rig share: names of its nodes and files, bags, and running it. A module, no program."""
import contextlib
import os
import re
import signal
import stat
import struct
import subprocess
import time
import urllib.parse

PACKAGE = 'tactile_clay'
NODES = ('hand_tracking', 'hand_simulator', 'clay_simulator', 'clay_surface', 'hand_surface', 'rig_numbers',
         'contact_pressure', 'focal_point_renderer', 'robot_state_publisher', 'simulated_array', 'array_driver',
         'boards', 'hand_skeleton', 'hand_left_state_publisher', 'hand_right_state_publisher', 'manager',
         'diagnostic_aggregator')
# Without them a run is whole.
FOR_THE_EYE = ('clay_surface', 'hand_surface', 'rig_numbers', 'hand_left_state_publisher', 'hand_right_state_publisher',
               'diagnostic_aggregator')
# The topic of the hands, by which all others are dated.
HANDS = 'hands/tracked'


class Fault(Exception):
    """One line about what is wrong."""


def one_line(text):
    return ' '.join(str(text).split())


# Files that somebody names

def open_input(path, most=16 << 20, **how):
    """Opens a regular file of at most so many bytes: a pipe would hold its reader for ever. Raises Fault and
    OSError."""
    opened = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
    status = os.fstat(opened)
    if stat.S_ISREG(status.st_mode) and status.st_size <= most:
        return open(opened, **how)
    os.close(opened)
    if not stat.S_ISREG(status.st_mode):
        raise Fault('%s: is not a regular file, expected one' % path)
    raise Fault('%s: has %d bytes, expected at most %d' % (path, status.st_size, most))


# The master

def wait_for_master(seconds, ended=lambda: False):
    """Returns once roscore is whole: what starts beside it while it is not takes it for another one. Raises Fault after
    that many seconds, and where it has `ended`."""
    import rosgraph
    master, deadline = rosgraph.Master('/' + PACKAGE), time.monotonic() + seconds
    while True:
        with contextlib.suppress(OSError, rosgraph.MasterException):
            if master.hasParam('/run_id') and master.lookupNode('/rosout'):
                return
        if ended() or time.monotonic() > deadline:
            raise Fault('no master could be started at %s' % rosgraph.get_master_uri())
        time.sleep(0.1)


# The launch of the rig

def nodes_of_rig(arguments):
    """Names of the nodes that rig.launch starts with these arguments, without those of the recorder."""
    def on(name):
        return arguments.get(name, 'false').lower() == 'true'
    without = {'array_driver' if arguments.get('device', 'simulated') == 'simulated' else 'simulated_array'}
    without |= set() if arguments.get('wire') else {'boards'}
    without |= set() if on('nodelets') else {'manager'}
    without |= set() if on('diagnostics') else {'diagnostic_aggregator'}
    without |= set() if on('skeleton') else {'hand_skeleton', 'hand_left_state_publisher', 'hand_right_state_publisher'}
    return [name for name in NODES if name not in without]


def known_arguments(share):
    """Arguments of rig.launch that have a default, in its order."""
    with open(os.path.join(share, 'launch', 'rig.launch')) as launch:
        return re.findall(r'<arg name="(\w+)" default=', launch.read())


# The rig as rig.launch has it, with further parameters in a file beside it.
LAUNCH = """<launch>
  <include file="$(find tactile_clay)/launch/rig.launch" pass_all_args="true"/>
  <rosparam command="load" file="$(dirname)/parameters.yaml"/>
</launch>
"""


def rig_environment(**changes):
    """The environment of a rig without a screen."""
    environment = {key: value for key, value in os.environ.items() if key not in ('DISPLAY', 'ROS_NAMESPACE')}
    environment.update(changes)
    return environment


def dying_with_us(command):
    """The command of a process that gets SIGINT when this one ends, also when it is killed."""
    return ['setpriv', '--pdeathsig', 'INT', *command]


def run_rig(command, environment, folder, log, over=None, **options):
    """Runs the rig to its end. Raises Fault with a line of the rig where it fails. `log`: file for its words. `over`:
    asked ten times a second, whether the rig shall end now."""
    with open(log, 'wb') as words:
        rig = subprocess.Popen(dying_with_us(command), env=environment, cwd=folder, stdout=words,
                               stdin=subprocess.DEVNULL, stderr=subprocess.STDOUT, start_new_session=True, **options)
        code, ended = None, False
        try:
            # roslaunch goes on without a node that it cannot start.
            while code is None and not ended and not any('cannot launch node' in line for line in lines_of(log)):
                with contextlib.suppress(subprocess.TimeoutExpired):
                    code = rig.wait(0.1 if over else 1)
                ended = code is None and over is not None and over()
        finally:
            if rig.poll() is None:
                os.kill(rig.pid, signal.SIGINT)
                rig.wait()
    said = lines_of(log)
    for line in said:
        again = re.match(r'tactile_clay: (\w+) .*, and is started again', line)
        if again and again.group(1) not in FOR_THE_EYE:
            raise Fault('the run is not complete: %s' % one_line(line))
    if not ended and (code != 0 or any('process has died [pid' in line for line in said)):
        faults = [line for line in said if 'FATAL' in line or line.startswith(PACKAGE + ':') or 'rror' in line]
        raise Fault('the rig does not run: %s' % one_line((faults or said[-1:] or ['it printed nothing'])[0]))


def lines_of(log):
    with open(log, errors='replace') as words:
        return re.sub(r'\x1b\[[\d;]*m', '', words.read()).splitlines()


# Files

def path_of(name, folder):
    """The path that a file key of a scene means, as src/scene/files.cpp has it."""
    def written_or_decoded(path):
        return path if os.path.exists(path) else urllib.parse.unquote(path)
    if name.startswith('package://'):
        import rospkg
        package, _, rest = name[len('package://'):].partition('/')
        return written_or_decoded(os.path.join(rospkg.RosPack().get_path(package), rest))
    if name.startswith('file://'):
        return written_or_decoded(name[len('file://'):])
    return os.path.expanduser(name) if name.startswith('~/') else os.path.join(folder, name)


def find_file(name, beside, shipped, ending):
    """A file by its path or by its name in a folder of the package, as src/scene/files.cpp finds it."""
    path = path_of(name, beside)
    others = (os.path.join(shipped, name + ending), os.path.join(beside, name + ending), os.path.join(shipped, name))
    for candidate in (path, *(() if '/' in name else others)):
        if os.path.isfile(candidate):
            return candidate
    raise OSError("no file '%s'" % name)


# Bags

COMPRESSIONS = ('none', 'lz4', 'bz2')  # of bags


def opened(path):
    import rosbag
    try:
        return rosbag.Bag(path)
    except rosbag.ROSBagUnindexedException:
        raise Fault('has no index, as an incomplete bag: `rosbag reindex` makes one') from None
    except (OSError, rosbag.ROSBagException, struct.error, ValueError) as error:
        raise Fault('is not a readable bag: %s' % error) from None


def connections(bag):
    """(topic, type, md5) of all that the bag holds."""
    return sorted({(one.topic, one.datatype, one.md5sum) for one in bag._get_connections()})


def relative(topic, namespace):
    """Name of a topic within the namespace of its rig; None for one of others."""
    space = namespace.rstrip('/') + '/'
    return topic[len(space):] if topic.startswith(space) else None


def absolute(topic, namespace):
    return namespace.rstrip('/') + '/' + topic


def stamp_of(data):
    """Stamp, ns, of a serialized message that begins with a header."""
    seconds, nanoseconds = struct.unpack_from('<II', data, 4)
    return seconds * 10**9 + nanoseconds


def has_header(kind):
    return kind._slot_types[:1] in (['std_msgs/Header'], ['Header'])


FORMATS = {1: 'b', 2: 'B', 3: 'h', 4: 'H', 5: 'i', 6: 'I', 7: 'f', 8: 'd'}  # of sensor_msgs/PointField


def columns(cloud, names):
    """Of each point of a sensor_msgs/PointCloud2 the numbers of these fields, as tuples. Raises Fault for a field that
    it does not have."""
    fields = {field.name: field for field in cloud.fields}
    for name in names:
        if name not in fields:
            raise Fault("a cloud has no field '%s'" % name)
    code, at = '<', 0
    for name in sorted(names, key=lambda name: fields[name].offset):
        code += '%dx%s' % (fields[name].offset - at, FORMATS[fields[name].datatype])
        at = fields[name].offset + struct.calcsize(FORMATS[fields[name].datatype])
    code += '%dx' % (cloud.point_step - at)
    ordered = sorted(names, key=lambda name: fields[name].offset)
    places = [ordered.index(name) for name in names]
    count = cloud.width * cloud.height
    for values in struct.iter_unpack(code, bytes(cloud.data[:count * cloud.point_step])):
        yield tuple(values[place] for place in places)
