"""Runs the rig in a graph of its own, and gives back its exit code, its words and every message that passed.

A run has a master of its own on a free port. The recorder subscribes before the rig starts, and in lockstep
hand_tracking releases its first sample only when every subscriber is connected, so no message is lost.
"""
import os
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
import unittest
import xmlrpc.client
from xml.etree import ElementTree

import rosbag
import rospkg

from case_results import Results

PACKAGE = rospkg.RosPack().get_path('tactile_clay')
BAGS = os.path.join(PACKAGE, 'test', 'bags')
RECORDINGS = ('both_hands_low_confidence', 'finger_tap', 'grab', 'left_or_right', 'pinch_and_move', 'three_claps')
# One message of each of these answers each sample of the hands.
CHAIN = ['/hands/tracked', '/hands/skin', '/clay/contacts', '/hands/pressure', '/array/focal_points', '/array/state']
LOCKSTEP = {'lockstep': 'true'}


def bag(name):
    return os.path.join(BAGS, name + '.bag')


def recording(name):
    """File of recorded hands, in the folder TACTILE_CLAY_DATA or beside the checkout. Raises unittest.SkipTest."""
    data = os.environ.get('TACTILE_CLAY_DATA') or os.path.join(PACKAGE, '..', 'shared', 'data')
    path = os.path.realpath(os.path.join(data, 'hands', name + '.v6.ndjson.gz'))
    if not os.path.exists(path):
        raise unittest.SkipTest('no recording ' + name)
    return path


def wait_until(condition, seconds, what):
    """Returns once `condition()` is true. Raises AssertionError naming `what` after that many seconds."""
    deadline = time.monotonic() + seconds
    while not condition():
        if time.monotonic() > deadline:
            raise AssertionError('not within %g s: %s' % (seconds, what))
        time.sleep(0.05)


def build_space():
    """The folder of the build under test, which holds `devel`."""
    for prefix in os.environ['CMAKE_PREFIX_PATH'].split(':'):
        if os.path.exists(os.path.join(prefix, 'lib', 'tactile_clay', 'preflight')):
            return os.path.dirname(prefix)
    raise RuntimeError('no build of tactile_clay on CMAKE_PREFIX_PATH: source devel/setup.bash')


def rig_script(folder):
    """scripts/rig of this package, over the build under test instead of one of its own."""
    os.makedirs(os.path.join(folder, 'scripts'))
    for name in ('scripts/rig', 'launch'):
        os.symlink(os.path.join(PACKAGE, name), os.path.join(folder, name))
    os.symlink(build_space(), os.path.join(folder, 'build'))
    os.symlink(shutil.which('true'), os.path.join(folder, 'scripts', 'setup'))
    return os.path.join(folder, 'scripts', 'rig')


class Graph:
    """A master of its own, and the processes started in it. Use in a `with` statement: the end stops them all."""

    def __init__(self, master_options=()):
        self.master_options = list(master_options)
        self.folder = tempfile.mkdtemp(prefix='rig_run_')
        with socket.socket() as probe:
            probe.bind(('localhost', 0))
            self.port = probe.getsockname()[1]
        self.uri = 'http://localhost:%d' % self.port
        self.environment = dict(os.environ, ROS_MASTER_URI=self.uri, ROS_HOSTNAME='localhost', ROS_HOME=self.folder,
                                ROS_LOG_DIR=os.path.join(self.folder, 'log'), PYTHONUNBUFFERED='1')
        for key in ('DISPLAY', 'ROS_IP', 'ROS_NAMESPACE'):
            self.environment.pop(key, None)
        self.processes = []

    def __enter__(self):
        try:
            self.start(['rosmaster', '--core', '-p', str(self.port), *self.master_options])
            wait_until(self.alive, 30, 'a master at ' + self.uri)
        except BaseException:
            self.__exit__()
            raise
        return self

    def __exit__(self, *_):
        for process in reversed(self.processes):
            self.stop(process)
        shutil.rmtree(self.folder, ignore_errors=True)

    def start(self, command, **options):
        # Not ignored in the child, whatever this process was started with.
        signal.signal(signal.SIGINT, signal.default_int_handler)
        process = subprocess.Popen(command, env=dict(self.environment, **options.pop('environment', {})),
                                   cwd=options.pop('cwd', self.folder), stdin=subprocess.DEVNULL,
                                   stdout=options.pop('stdout', subprocess.DEVNULL),
                                   stderr=options.pop('stderr', subprocess.DEVNULL), start_new_session=True, **options)
        self.processes.append(process)
        return process

    def stop(self, process, patience=30):
        """Ctrl-C, which a terminal sends to all of a group. Returns the exit code, or None if it had to be killed."""
        if process.poll() is not None:
            return process.returncode
        os.killpg(process.pid, signal.SIGINT)
        try:
            return process.wait(patience)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            process.wait()
            return None

    def master(self):
        return xmlrpc.client.ServerProxy(self.uri)

    def alive(self):
        try:
            return self.master().getPid('/test')[0] == 1
        except OSError:
            return False

    def subscribed(self, topic):
        _, _, (_, subscribers, _) = self.master().getSystemState('/test')
        return any(name == topic and nodes for name, nodes in subscribers)

    def registered(self, node):
        return self.master().lookupNode('/test', node)[0] == 1

    def record(self, topics):
        """Starts to record. Returns once the recorder is known to the master: finish with `recorded`."""
        path = os.path.join(self.folder, 'recorded.bag')
        program = os.path.join(build_space(), 'devel', 'lib', 'tactile_clay', 'record_run')
        recorder = self.start([program, '__name:=record_of_test', '_bag:=' + path, '_topics:=' + ' '.join(topics)])
        wait_until(lambda: all(self.subscribed(topic) for topic in topics), 30, 'a recorder')
        return recorder, path

    def recorded(self, recording):
        recorder, path = recording
        if self.stop(recorder) is None:
            raise AssertionError('the recorder did not end')
        return Messages(path)

    def rig(self, arguments, **options):
        """Starts scripts/rig, by default in the graph's folder (cwd); its words come from `words`. Its sound are focal
        points, unless `arguments` have a modulation: a field costs a third of the clay's time."""
        arguments = {'modulation': 'am', **arguments}
        script = rig_script(tempfile.mkdtemp(dir=self.folder))
        with open(os.path.join(self.folder, 'words'), 'ab') as words:
            return self.start([script, 'rviz:=false'] + ['%s:=%s' % item for item in arguments.items()], stdout=words,
                              stderr=subprocess.STDOUT, **options)

    def words(self):
        with open(os.path.join(self.folder, 'words'), errors='replace') as words:
            return words.read()

    def left_processes(self):
        """Command lines of the processes that belong to this graph."""
        mark = ('ROS_MASTER_URI=' + self.uri).encode()
        mine = {process.pid for process in self.processes} | {os.getpid()}
        found = []
        for pid in filter(str.isdigit, os.listdir('/proc')):
            try:
                with open('/proc/%s/environ' % pid, 'rb') as environment:
                    belongs = mark in environment.read().split(b'\0')
                with open('/proc/%s/cmdline' % pid, 'rb') as line:
                    if belongs and int(pid) not in mine:
                        found.append(line.read().replace(b'\0', b' ').decode())
            except OSError:
                continue
        return found


class Messages:
    """What a bag holds: messages, their bytes and times (s) by topic, in the order of arrival."""

    def __init__(self, path, topics=None):
        self.by_topic, self.bytes, self.times = {}, {}, {}
        with rosbag.Bag(path) as opened:
            for topic, (_, data, _, _, kind), time_of_arrival in opened.read_messages(topics=topics, raw=True):
                message = kind()
                message.deserialize(data)
                self.by_topic.setdefault(topic, []).append(message)
                self.bytes.setdefault(topic, []).append(data)
                self.times.setdefault(topic, []).append(time_of_arrival.to_sec())

    def __getitem__(self, topic):
        return self.by_topic.get(topic, [])

    def stamps(self, topic):
        return [message.header.stamp.to_nsec() for message in self[topic]]

    def by_stamp(self, topic):
        return {message.header.stamp.to_nsec(): message for message in self[topic]}


class Run:
    """A finished run: `code`, `words`, and `messages` (a Messages) of `topics`."""

    def __init__(self, arguments, topics=None, limit=200):
        topics = CHAIN + ['/tf_static'] if topics is None else topics
        with Graph() as graph:
            recording = graph.record(topics)
            rig = graph.rig(arguments)
            try:
                self.code = rig.wait(limit)
            except subprocess.TimeoutExpired:
                graph.stop(rig)
                raise AssertionError('the rig did not end within %g s:\n%s' % (limit, graph.words()))
            self.words = graph.words()
            self.messages = graph.recorded(recording)
            self.left = graph.left_processes()


_runs = {}


def lockstep(name, **arguments):
    """The run of a shipped bag in lockstep, with focal points. Tests of one program share the run of the same
    arguments."""
    key = (name, tuple(sorted(arguments.items())))
    if key not in _runs:
        _runs[key] = Run(dict(dict(LOCKSTEP, modulation='am', hands='bag', file=bag(name)), **arguments))
    return _runs[key]


def input_stamps(name):
    return Messages(bag(name)).stamps('/hands/tracked')


def main(name):
    """Runs the test cases of the program, as rostest expects of it."""
    # A test that is stopped, such as by its time limit, still stops what it has started.
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))
    suite = unittest.defaultTestLoader.loadTestsFromModule(sys.modules['__main__'])
    results = unittest.TextTestRunner(verbosity=2, resultclass=Results).run(suite)
    results.suite.attrib.update(name=name, tests=str(results.testsRun), failures=str(len(results.failures)),
                                errors=str(len(results.errors)), skipped=str(len(results.skipped)))
    for argument in sys.argv:
        if argument.startswith('--gtest_output=xml:'):
            ElementTree.ElementTree(results.suite).write(argument.split(':', 1)[1], 'utf-8', True)
    sys.exit(0 if results.wasSuccessful() else 1)
