"""The folder of a session of trials, its table, and the runs of its trials. A module of `trial`, no program."""
import contextlib
import csv
import datetime
import fcntl
import io
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import urllib.parse

import rosgraph
import rospy
import yaml

from rig_tools import LAUNCH, Fault, dying_with_us, run_rig, wait_for_master
from trial_link import START, Keys, Link
from trial_yaml import text_of

PATIENCE = 40.0  # s, for a master to come and for the rig of a run that was killed to end


@contextlib.contextmanager
def master():
    """A master where none answers, for as long as the session goes."""
    uri = rosgraph.get_master_uri()
    if rosgraph.is_master_online():
        yield
        return
    address = urllib.parse.urlparse(uri)
    if not rosgraph.network.is_local_address(address.hostname or ''):
        raise Fault('no master answers at %s: start one there' % uri)
    process = subprocess.Popen(dying_with_us(['roscore', '-p', str(address.port or 11311)]), stdin=subprocess.DEVNULL,
                               stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True)
    try:
        wait_for_master(PATIENCE, lambda: process.poll() is not None)
        yield
    finally:
        process.send_signal(signal.SIGINT)
        process.wait()


class Table:
    """trials.csv: one row for each trial that ended. It is written whole, so that a row is there or is not."""

    def __init__(self, folder, keys=()):
        self.path = os.path.join(folder, 'trials.csv')
        self.columns = ['trial', 'block', 'condition', 'practice', 'repetition', *keys, 'answer', 'answer_s',
                        'began_utc', 'seconds', 'bag']
        self.rows = []
        if os.path.exists(self.path):
            with open(self.path, newline='') as file:
                self.rows = list(csv.DictReader(file))

    def add(self, row):
        text = io.StringIO()
        writer = csv.DictWriter(text, self.columns, lineterminator='\n')
        writer.writeheader()
        writer.writerows(self.rows + [row])
        write_whole(self.path, text.getvalue())
        self.rows.append({key: str(row.get(key, '')) for key in self.columns})


def write_whole(path, text):
    """Writes a file so that after a crash it is as before, or as it should be."""
    with open(path + '.new', 'w') as file:
        file.write(text)
        file.flush()
        os.fsync(file.fileno())
    os.replace(path + '.new', path)


class Session:
    """The folder of a session, locked as long as this process, or a rig that it started, is there."""

    def __init__(self, plan):
        self.plan, self.folder = plan, plan.session_folder
        try:
            os.makedirs(self.folder, exist_ok=True)
            self.lock = os.open(os.path.join(self.folder, 'lock'), os.O_CREAT | os.O_RDWR, 0o644)
        except OSError as error:
            raise Fault("%s: the folder of the session '%s' cannot be made: %s" %
                        (plan.path, self.folder, error.strerror)) from None
        self.hold()
        known = os.path.join(self.folder, 'plan.yaml')
        if os.path.exists(known):
            with open(known, encoding='utf-8') as file:
                if file.read() != plan.text:
                    raise Fault("%s: is not the plan with which the session in '%s' began, expected the same, or "
                                "another 'session' or 'participant'" % (plan.path, self.folder))
        else:
            order = dict(seed=plan.seed, order=plan.order(), staircases='which condition comes next is drawn from '
                         'seed, block and number of the trial')
            write_whole(os.path.join(self.folder, 'order.yaml'), yaml.safe_dump(order, sort_keys=False))
            write_whole(known, plan.text)
        with open(os.path.join(self.folder, 'order.yaml')) as file:
            self.order = yaml.safe_load(file)['order']
        self.table = Table(self.folder, plan.keys())

    def hold(self):
        deadline, told = time.monotonic() + PATIENCE, False
        while True:
            try:
                fcntl.flock(self.lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
                return
            except OSError:
                if time.monotonic() > deadline:
                    raise Fault("the session in '%s' is being run by another process" % self.folder) from None
            if not told:
                print('trial: waits for the end of the earlier rig', flush=True)
            told = True
            time.sleep(0.2)

    def set_aside(self, path):
        """Keeps what an earlier try of a trial left under another name."""
        stem, end = os.path.splitext(path)
        for left in (path, path + '.active'):
            if os.path.lexists(left):
                k = 1
                while any(os.path.lexists('%s_unfinished_%d%s%s' % (stem, k, end, more)) for more in ('', '.active')):
                    k += 1
                os.rename(left, '%s_unfinished_%d%s%s' % (stem, k, end, left[len(path):]))

    def run(self):
        count, fewer = self.plan.max_trials()
        print('trial: session %s of %s in %s: %d of %s%d trials are done' % (
            self.plan.session, self.plan.participant, self.folder, len(self.table.rows), 'at most ' * fewer, count),
            flush=True)
        with master(), Keys() as keys:
            link = Link()
            trial = self.plan.next_trial(self.order, self.table.rows)
            while trial:
                self.run_trial(trial, link, keys)
                self.tell_block(trial)
                trial = self.plan.next_trial(self.order, self.table.rows)
            link.tell('ended', None)
            rospy.rostime.wallsleep(0.2)  # for those who listen
        print('trial: the session is complete: %d trials' % len(self.table.rows))

    def run_trial(self, trial, link, keys):
        block = trial['block']
        name = '%03d_%s_%s%s' % (trial['number'], block['name'], trial['condition'], '_practice' * trial['practice'])
        bag, log = (os.path.join(self.folder, name + end) for end in ('.bag', '.log'))
        for path in (bag, log):
            self.set_aside(path)
        value = '' if trial['value'] is None else ', %s %s' % (block['staircase']['key'], text_of(trial['value']))
        print('trial %d: %sblock %s, condition %s%s' % (trial['number'], 'practice ' * trial['practice'], block['name'],
                                                        trial['condition'], value))
        if trial['instruction']:
            print('  ' + trial['instruction'].strip().replace('\n', '\n  '))
        sys.stdout.flush()
        link.instruction.publish(trial['instruction'])
        link.forget(keys)
        if block['start'] == 'ask':
            link.tell('waiting', trial)
            print('  [Enter] starts the trial', flush=True)
            while link.take(keys, [START]) is None:
                time.sleep(0.02)
        answer = self.run_rig(trial, bag, log, link, keys)
        if block['answers'] and answer[0] == '':
            link.tell('answer', trial)
            print('  ' + ', '.join('[%s] %s' % (word[:1], word) for word in block['answers']), flush=True)
            while answer[0] == '':
                answer = self.answer_of(link.take(keys, block['answers']), link)
                time.sleep(0.02)
        self.table.add({'trial': trial['number'], 'block': block['name'], 'condition': trial['condition'],
                        'practice': 'yes' if trial['practice'] else 'no', 'repetition': trial['repetition'],
                        **{key: text_of(trial['settings'][key]) for key in self.plan.keys()
                           if key in trial['settings']},
                        'answer': answer[0], 'answer_s': answer[1], 'began_utc': self.began,
                        'seconds': '%.3f' % self.seconds, 'bag': os.path.basename(bag)})
        link.tell('done', trial)

    @staticmethod
    def answer_of(word, link):
        """(answer, s after the first sample of the trial)"""
        if word is None:
            return ('', '')
        return (word, '' if link.began is None else '%.3f' % (time.monotonic() - link.began))

    def run_rig(self, trial, bag, log, link, keys):
        """Runs the rig of a trial. Returns its answer, ('', '') where none came yet."""
        plan, block, answer = self.plan, trial['block'], ('', '')
        settings = {'rviz': False, **trial['settings']}
        arguments = {key: value for key, value in settings.items() if '/' not in key}
        arguments.update(duration=block['duration'], record=bag, record_skin=plan.skin,
                         record_compression=plan.compression)
        parameters = {}
        for key, value in settings.items():
            *path, last = key.split('/')
            inner = parameters
            for part in path:
                inner = inner.setdefault(part, {})
            if path:
                inner[last] = value

        def over():
            nonlocal answer
            if link.began is None:
                link.forget(keys)
            elif block['answers'] and answer[0] == '':
                answer = self.answer_of(link.take(keys, block['answers']), link)
            return block['ends'] == 'answer' and answer[0] != ''
        folder = tempfile.mkdtemp(prefix='trial_')
        try:
            launch = os.path.join(folder, 'trial.launch')
            for path, text in ((launch, LAUNCH), (os.path.join(folder, 'parameters.yaml'), yaml.safe_dump(parameters))):
                with open(path, 'w') as file:
                    file.write(text)
            link.began = None
            link.tell('running', trial)
            self.began = datetime.datetime.utcnow().isoformat(timespec='seconds') + 'Z'
            start = time.monotonic()
            run_rig(['roslaunch', launch] + ['%s:=%s' % (key, text_of(value)) for key, value in arguments.items()],
                    dict(os.environ, PWD=plan.folder), plan.folder, log, over, pass_fds=(self.lock,))
            self.seconds = time.monotonic() - (link.began or start)
        except Fault as fault:
            raise Fault('trial %d: %s (%s)' % (trial['number'], fault, log)) from None
        finally:
            shutil.rmtree(folder, ignore_errors=True)
        if not os.path.exists(bag):
            raise Fault("trial %d: the rig ended without the bag '%s' (%s)" % (trial['number'], bag, log))
        return answer

    def tell_block(self, trial):
        block = trial['block']
        if block['staircase'] and not trial['practice']:
            for line in stair_lines(self.plan, block, self.table.rows, trial['condition']):
                print('  ' + line, flush=True)


def stair_lines(plan, block, rows, only=None):
    for name, stair in plan.staircases(block, rows).items():
        if only in (None, name) and (only is None or stair.done()):
            threshold = stair.threshold()
            yield 'staircase %s, %s: %d trials, %d reversals, %s' % (
                block['name'], name, stair.count, len(stair.reversals),
                'no threshold yet' if threshold is None else 'threshold %.6g' % threshold)
