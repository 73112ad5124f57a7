#!/usr/bin/env python3
"""Two hosts, each a network namespace: see two_hosts.test."""
import os
import shutil
import subprocess
import sys
import time
import unittest

import rig_run
from rig_run import wait_until

INSIDE = 'TACTILE_CLAY_HOSTS'  # set where this program runs in its namespaces, or to why it does not
HERE, THERE = '10.66.0.1', '10.66.0.2'  # addresses of the two hosts
MASTER = 'http://%s:11311' % HERE
SILENT_WITHIN = 1.0  # s, after the master is gone (doc/reference/safety.md, "Whoever supervises")
SLACK = 0.5          # s, of a line on its way through a pipe of a busy machine


def run(command, check=True):
    return subprocess.run(command.split(), check=check, stdin=subprocess.DEVNULL, capture_output=True, text=True)


class There:
    """A host with a cable to this one."""

    def __init__(self):
        self.process = subprocess.Popen(['unshare', '--net', 'sleep', 'infinity'], stdin=subprocess.DEVNULL)
        self.enter = ['nsenter', '--net', '--target', str(self.process.pid)]
        mine = os.readlink('/proc/self/ns/net')
        wait_until(lambda: os.readlink('/proc/%d/ns/net' % self.process.pid) != mine, 10, 'a namespace')
        run('ip link set lo up')
        run('ip link add here type veth peer name there')
        run('ip link set there netns %d' % self.process.pid)
        run('ip addr add %s/24 dev here' % HERE)
        run('ip link set here up')
        for command in ('ip link set lo up', 'ip addr add %s/24 dev there' % THERE, 'ip link set there up'):
            run(' '.join(self.enter + [command]))

    def stop(self):
        self.process.kill()
        self.process.wait()


class TwoHosts(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        if os.environ[INSIDE] != 'yes':
            raise unittest.SkipTest('no network namespaces: ' + os.environ[INSIDE])
        cls.there = There()
        cls.addClassCleanup(cls.there.stop)
        os.environ.update(ROS_MASTER_URI=MASTER, ROS_IP=HERE)
        os.environ.pop('ROS_HOSTNAME', None)
        master = subprocess.Popen(['rosmaster', '--core', '-p', '11311'], stdin=subprocess.DEVNULL,
                                  stdout=subprocess.DEVNULL)
        cls.addClassCleanup(master.wait)
        cls.addClassCleanup(master.terminate)
        import rosgraph
        wait_until(rosgraph.is_master_online, 30, 'a master')
        import rospy
        rospy.init_node('two_hosts_test', disable_signals=True)
        from array_stream import States, Stream
        cls.states, cls.stream = States(), Stream()
        cls.addClassCleanup(cls.stream.stop)

    def driver(self, *command, **environment):
        """An array_driver on the other host."""
        from array_stream import Driver
        return Driver(command=[*self.there.enter, *command], environment=dict(environment, ROS_IP=THERE),
                      device='debug', check_stamps='true')

    def expect_sound(self, driver, since):
        try:
            self.states.wait(lambda state: state.emitting, since, 30)
        except AssertionError as error:
            raise AssertionError('%s\nthe driver says\n%s' % (error, driver.words())) from error

    def test_a_cable_that_is_pulled(self):
        since = time.monotonic()
        with self.driver() as driver:
            self.expect_sound(driver, since)
            time.sleep(1.0)
            pulled = time.monotonic()
            run('ip link set here down')
            wait_until(lambda: driver.said('is silent', pulled), 10, 'silence; the driver says\n' + driver.words())
            self.assertLess(driver.said('is silent', pulled) - pulled, SILENT_WITHIN + SLACK, driver.words())
            time.sleep(2.0)
            self.assertIsNone(driver.process.poll(), driver.words())
            put_back = time.monotonic()
            run('ip link set here up')
            self.expect_sound(driver, put_back)

    def test_clocks_that_are_apart(self):
        if shutil.which('faketime') is None:
            self.skipTest('no faketime')
        for ahead in (5, -5):
            with self.subTest(ahead=ahead):
                since = time.monotonic()
                with self.driver('faketime', '-f', '%+ds' % ahead, FAKETIME_DONT_FAKE_MONOTONIC='1'):
                    _, state = self.states.wait(lambda state: 'stale' in state.silent_reason, since)
                    self.assertRegex(state.silent_reason, r"stamps are [45]\.[0-9]+ s %s this computer's clock: "
                                     "compare the hosts' clocks" % ('behind' if ahead > 0 else 'ahead of'))
                    time.sleep(0.3)
                    with self.states.came:
                        self.assertFalse([state for when, state in self.states.states
                                          if when > since and state.emitting])


if __name__ == '__main__':
    if INSIDE not in os.environ:
        probe = run('unshare --user --map-root-user --net ip link add here type veth peer name there', check=False)
        if probe.returncode == 0:
            os.environ[INSIDE] = 'yes'
            os.execvp('unshare', ['unshare', '--user', '--map-root-user', '--net', sys.executable] + sys.argv)
        os.environ[INSIDE] = ' '.join(probe.stderr.split()) or 'unshare failed'
    rig_run.main('two_hosts')
