"""What a session of trials hears and tells: keys of the terminal, and topics. A module of `trial`, no program."""
import os
import select
import sys
import termios
import threading
import time
import tty

import rosgraph
import rospy
import yaml
from std_msgs.msg import String

from rig_tools import HANDS

START = 'start'  # what trial/answer takes for the Enter key
CONNECTING = 2.0  # s, at most, for a program that answers; one that was killed stays registered and never connects


class Keys:
    """Keys of the terminal, one at a time; none where the input is no terminal. Use in a `with` statement."""

    def __enter__(self):
        self.before = termios.tcgetattr(sys.stdin) if sys.stdin.isatty() else None
        if self.before:
            tty.setcbreak(sys.stdin)
        return self

    def __exit__(self, *_):
        if self.before:
            termios.tcsetattr(sys.stdin, termios.TCSADRAIN, self.before)

    def pressed(self):
        """A key that was pressed, or None."""
        if not self.before or not select.select([sys.stdin], [], [], 0)[0]:
            return None
        return os.read(sys.stdin.fileno(), 1).decode(errors='replace')


class Link:
    """What passes between the session and others: instructions and states out, answers in."""

    def __init__(self):
        rospy.init_node('trial', disable_signals=True)
        self.instruction = rospy.Publisher('trial/instruction', String, queue_size=1, latch=True)
        self.state = rospy.Publisher('trial/state', String, queue_size=1, latch=True)
        self.lock, self.came, self.began = threading.Lock(), [], None
        answers = rospy.Subscriber('trial/answer', String, self.receive, queue_size=10)
        rospy.Subscriber(HANDS, rospy.AnyMsg, self.sample, queue_size=1)
        self.connect(answers)

    @staticmethod
    def connect(answers):
        """Waits for the programs that answer: whoever sees a state can answer it at once, and is heard."""
        deadline = time.monotonic() + CONNECTING
        while time.monotonic() < deadline:
            publishers = dict(rosgraph.Master('trial').getSystemState()[0])
            if answers.get_num_connections() >= len(publishers.get(answers.resolved_name, [])):
                return
            time.sleep(0.02)

    def receive(self, message):
        with self.lock:
            self.came.append(message.data.strip())

    def sample(self, _):
        if self.began is None:
            self.began = time.monotonic()

    def forget(self, keys):
        """What came too early."""
        with self.lock:
            self.came = []
        while keys.pressed() is not None:
            pass

    def take(self, keys, words):
        """The next of these words that came on the topic or by its key, or None. Others are told and forgotten."""
        with self.lock:
            came, self.came = self.came, []
        key = keys.pressed()
        came += [word for word in words if key is not None and (word[:1] == key or (word == START and key in '\r\n'))]
        for word in came:
            if word in words:
                return word
            print("trial: answer '%s' left out, expected %s" % (word, ' or '.join(words) or 'none now'), flush=True)
        return None

    def tell(self, phase, trial):
        told = dict(phase=phase)
        if trial:
            told.update(trial=trial['number'], block=trial['block']['name'], condition=trial['condition'],
                        practice=trial['practice'], repetition=trial['repetition'],
                        settings={key: value for key, value in trial['settings'].items()})
            if trial['value'] is not None:
                told['value'] = trial['value']
        self.state.publish(yaml.safe_dump(told, sort_keys=False))
