"""Focal points and hands as a rig sends them, and an array driver of the test's own, for tests of devices."""
import os
import signal
import subprocess
import threading
import time

import rospy
from geometry_msgs.msg import Point
from tactile_clay.msg import ArrayState, FocalPoint, FocalPointArray, TrackedHand, TrackedHands

import rig_run

RATE = 60.0      # Hz
PATIENCE = 20.0  # s, for what has no time of its own
PROGRAMS = os.path.join(rig_run.build_space(), 'devel', 'lib', 'tactile_clay')
PROGRAM = os.path.join(PROGRAMS, 'array_driver')


def focus(x=0.0, y=0.0, z=0.17, intensity=0.5, number=1):
    return FocalPoint(id=number, position=Point(x, y, z), pressure=1000.0, intensity=intensity)


class Stream:
    """Hands and focal points at 60 Hz in a thread of its own, as a renderer sends them."""

    def __init__(self):
        self.publisher = rospy.Publisher('array/focal_points', FocalPointArray, queue_size=1, tcp_nodelay=True)
        self.hands_publisher = rospy.Publisher('hands/tracked', TrackedHands, queue_size=1, tcp_nodelay=True)
        self.reset()
        self.running, self.last_sent = True, time.monotonic()
        self.thread = threading.Thread(target=self.run, daemon=True)
        self.thread.start()

    def reset(self):
        self.points, self.frame, self.age, self.modulation_frequency = [focus()], 'array', 0.0, 200.0
        self.modulation, self.normals = 0, []
        self.hands = [TrackedHand()]  # None: no word of the hands

    def run(self):
        while self.running:
            message = FocalPointArray(points=self.points, modulation_frequency=self.modulation_frequency,
                                      modulation=self.modulation, normal=self.normals)
            message.header.frame_id = self.frame
            message.header.stamp = rospy.Time.now() - rospy.Duration(self.age)
            if self.hands is not None:
                hands = TrackedHands(hands=self.hands)
                hands.header.stamp = message.header.stamp
                self.hands_publisher.publish(hands)
            self.publisher.publish(message)
            self.last_sent = time.monotonic()
            time.sleep(1.0 / RATE)

    def stop(self):
        self.running = False
        self.thread.join()


class States:
    """Every array/state, with the time at which it came."""

    def __init__(self):
        self.states, self.came = [], threading.Condition()
        self.subscriber = rospy.Subscriber('array/state', ArrayState, self.receive)

    def receive(self, state):
        with self.came:
            self.states.append((time.monotonic(), state))
            self.came.notify_all()

    def wait(self, condition, since=None, patience=PATIENCE):
        """The first state from now on (or from `since`) that meets the condition, with the time at which it came."""
        since = time.monotonic() if since is None else since
        deadline = time.monotonic() + patience
        with self.came:
            while True:
                for came, state in self.states:
                    if came >= since and condition(state):
                        return came, state
                if not self.came.wait(max(deadline - time.monotonic(), 0.0)):
                    raise AssertionError('no such state; the last one:\n%s' % (self.states[-1:] or 'none'))


class Driver:
    """An array_driver, or another program, with private parameters. Use in a `with` statement: the end stops it.
    `command`, with `environment` in addition to ours: what starts it, such as faketime."""

    def __init__(self, program='array_driver', command=(), environment=None, **parameters):
        self.program, self.parameters = program, parameters
        self.command, self.environment = command, dict(os.environ, **(environment or {}))

    def __enter__(self):
        # An earlier driver leaves its parameters on the server.
        if rospy.has_param('/' + self.program):
            rospy.delete_param('/' + self.program)
        for name, value in self.parameters.items():
            rospy.set_param('/%s/%s' % (self.program, name), value)
        self.process = subprocess.Popen([*self.command, os.path.join(PROGRAMS, self.program)], env=self.environment,
                                        stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                                        start_new_session=True, errors='replace')
        self.read = []  # (when it came, line)
        self.reader = threading.Thread(target=self.run, daemon=True)
        self.reader.start()
        return self

    def run(self):
        for line in self.process.stdout:
            self.read.append((time.monotonic(), line))

    def __exit__(self, *_):
        if self.process.poll() is None:
            os.killpg(self.process.pid, signal.SIGCONT)
            os.killpg(self.process.pid, signal.SIGINT)
            try:
                self.process.wait(10)
            except subprocess.TimeoutExpired:
                os.killpg(self.process.pid, signal.SIGKILL)
                self.process.wait()
        self.reader.join(5)

    @property
    def lines(self):
        return [line for _, line in list(self.read)]

    def words(self):
        return ''.join(self.lines)

    def said(self, words, since=0.0):
        """When it first said that; None where it has not."""
        return next((when for when, line in list(self.read) if when >= since and words in line), None)
