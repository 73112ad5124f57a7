#!/usr/bin/env python3
"""The emergency stop: see stop.test."""
import os
import pty
import subprocess
import tempfile
import time
import unittest

import rospy
from sensor_msgs.msg import PointCloud2
from std_msgs.msg import Empty
from std_srvs.srv import Trigger
from tactile_clay.msg import ArrayDrive

import rig_run
from array_stream import PATIENCE, PROGRAMS, Driver, States, Stream
from rig_run import wait_until

STOPPED = 'emergency stop'


class Stop(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rospy.init_node('stop_test')
        cls.states = States()
        cls.topics = {name: rospy.Publisher('array/' + name, Empty, queue_size=1) for name in ('stop', 'reset')}

    def array(self, program, **parameters):
        """An array that emits; it ends with the test."""
        driver = Driver(program, **parameters)
        driver.__enter__()
        self.addCleanup(driver.__exit__)
        self.stream = Stream()
        self.addCleanup(self.stream.stop)
        self.states.wait(lambda state: state.emitting)
        return driver

    def call(self, name):
        rospy.wait_for_service(name, PATIENCE)
        answer = rospy.ServiceProxy(name, Trigger)()
        self.assertTrue(answer.success, answer.message)

    def publish(self, name):
        publisher = self.topics[name]
        wait_until(lambda: publisher.get_num_connections() > 0, 10, 'an array on array/' + name)
        publisher.publish(Empty())

    def expect_stop(self, act):
        """`act` stops the array, and it stays stopped."""
        since = time.monotonic()
        act()
        came, state = self.states.wait(lambda state: not state.emitting and state.silent_reason.startswith(STOPPED),
                                       since)
        time.sleep(0.3)
        with self.states.came:
            self.assertFalse([state for when, state in self.states.states if when > came and state.emitting])
        return state

    def expect_sound(self, act):
        since = time.monotonic()
        act()
        self.states.wait(lambda state: state.emitting, since)

    def test_the_same_names_for_every_array(self):
        for program, parameters in (('array_driver', dict(device='debug')), ('simulated_array', {})):
            with self.subTest(program):
                driver = self.array(program, **parameters)
                for stop in (lambda: self.call('array/stop'), lambda: self.publish('stop'),
                             lambda: self.call(program + '/stop')):
                    self.expect_stop(stop)
                    self.expect_sound(lambda: self.call('array/reset'))
                self.expect_stop(lambda: self.publish('stop'))
                self.expect_sound(lambda: self.publish('reset'))
                self.expect_stop(lambda: self.publish('stop'))
                self.expect_sound(lambda: self.call(program + '/reset'))
                self.doCleanups()
                self.assertEqual(driver.process.returncode, 0, driver.words())

    def test_state_is_latched(self):
        self.array('array_driver', device='debug')
        self.call('array/stop')
        self.stream.stop()
        since = time.monotonic()
        late = States()
        self.addCleanup(late.subscriber.unregister)
        self.assertIn(STOPPED, late.wait(lambda _: True, since)[1].silent_reason)

    def test_a_busy_callback_does_not_delay_it(self):
        """A field of four million places keeps the callbacks of the array busy for seconds."""
        drives, fields = [], []
        self.array('simulated_array', slice_size=1.0, slice_step=0.0005, skin_field=False)
        watch = rospy.Subscriber('array/drive', ArrayDrive, lambda drive: drives.append(max(drive.amplitude)))
        field = rospy.Subscriber('array/field', PointCloud2, lambda cloud: fields.append(time.monotonic()),
                                 buff_size=1 << 26)
        self.addCleanup(watch.unregister)
        self.addCleanup(field.unregister)
        stop = rospy.ServiceProxy('array/stop', Trigger, persistent=True)
        self.addCleanup(stop.close)
        wait_until(lambda: fields, 60, 'the first field')  # so the array begins with the next one now
        first = len(fields)
        start = time.monotonic()
        self.assertTrue(stop().success)
        answered = time.monotonic()
        wait_until(lambda: drives and drives[-1] == 0.0, 10, 'a silent drive')
        silent = time.monotonic()
        wait_until(lambda: len(fields) > first, 60, 'the field, which took longer')
        busy = fields[first] - start
        print('answered after %.0f ms, silent after %.0f ms, busy for %.1f s' %
              (1e3 * (answered - start), 1e3 * (silent - start), busy))
        self.assertGreater(busy, 2 * (silent - start))

    def array_stop(self, *arguments, **streams):
        program = subprocess.Popen([os.path.join(PROGRAMS, 'array_stop')] + list(arguments), stdout=subprocess.PIPE,
                                   stderr=subprocess.STDOUT, start_new_session=True, **streams)
        self.addCleanup(program.wait)
        self.addCleanup(program.kill)
        self.addCleanup(program.stdout.close)
        self.said = b''
        return program

    def hear(self, program, words):
        while words not in self.said:
            more = os.read(program.stdout.fileno(), 4096)
            self.assertTrue(more, self.said)
            self.said += more
        self.said = self.said.split(words, 1)[1]

    def test_keys(self):
        self.array('array_driver', device='debug')
        master, slave = pty.openpty()
        self.addCleanup(os.close, master)
        program = self.array_stop(stdin=slave)
        os.close(slave)
        self.hear(program, b'connected to 1')
        for key in (b' ', b'\x1b[A', b'\x1a'):  # the space bar, an arrow, Ctrl-Z
            self.expect_stop(lambda: os.write(master, key))
            self.hear(program, b'STOPPED: 1 array(s)')
            self.expect_sound(lambda: os.write(master, b'r'))
        # Whoever leaves, leaves it silent.
        self.expect_stop(lambda: os.write(master, b'\x03'))
        self.assertEqual(program.wait(10), 0)
        self.call('array/reset')

    def test_lines_and_an_array_that_comes_later(self):
        program = self.array_stop(stdin=subprocess.PIPE)
        self.hear(program, b'NO ARRAY')
        program.stdin.write(b'\n')
        program.stdin.flush()
        self.hear(program, b'NOT CONFIRMED')
        with Driver('array_driver', device='debug'):
            self.hear(program, b'STOPPED')
            stream = Stream()
            self.addCleanup(stream.stop)
            self.states.wait(lambda state: state.silent_reason.startswith(STOPPED))
            self.expect_sound(lambda: (program.stdin.write(b'reset\n'), program.stdin.flush()))
            self.expect_stop(program.stdin.close)  # nobody is there any more
            self.assertEqual(program.wait(10), 0)
            self.call('array/reset')

    def test_a_switch(self):
        self.array('array_driver', device='debug')
        with tempfile.TemporaryDirectory() as folder:
            fifo = os.path.join(folder, 'switch')
            os.mkfifo(fifo)
            program = self.array_stop('switch:=' + fifo, stdin=subprocess.DEVNULL)
            self.hear(program, b'connected to 1')

            def tread():
                with open(fifo, 'wb') as switch:
                    switch.write(b'r')  # a switch never resets
            self.expect_stop(tread)
            self.assertIsNone(program.poll())
            self.expect_sound(lambda: self.call('array/reset'))
            program.terminate()
            self.assertEqual(program.wait(10), 0)
            self.states.wait(lambda state: state.silent_reason.startswith(STOPPED))
            self.call('array/reset')
        missing = subprocess.run([os.path.join(PROGRAMS, 'array_stop'), 'switch:=/nowhere'], stdout=subprocess.PIPE,
                                 timeout=20,
                                 stderr=subprocess.STDOUT, check=False)
        self.assertEqual(missing.returncode, 1)
        self.assertIn(b"'/nowhere' cannot be opened", missing.stdout)

    def test_boards_are_silent_beside_two_busy_loops(self):
        """How soon is printed: it depends on the machine."""
        done = subprocess.run([os.path.join(PROGRAMS, 'measure_stop'), 'rounds:=40'], stdout=subprocess.PIPE,
                              timeout=60,
                              stderr=subprocess.STDOUT, check=False, errors='replace')
        print(done.stdout)
        self.assertEqual(done.returncode, 0, done.stdout)


if __name__ == '__main__':
    rig_run.main('stop')
