"""Cases of sonic_surface_test.py about how the boards become silent. A module, no program."""
import os
import signal
import subprocess
import time

from rig_run import wait_until
from sonic_surface_boards import FRAME, SILENCE, SLACK, Boards


class Silence(Boards):
    def test_points_that_end(self):
        emulator, _ = self.rig()
        self.stream.points = []
        self.expect_silence(emulator, time.monotonic(), 0.1 + SLACK)

    def test_stream_that_ends(self):
        """Stale after 100 ms; the gate's rule, and the device's own hold behind it."""
        for options, timeout, limit in (('', 0.1, 0.1), ('', 10.0, 0.2), ('hold=10', 0.1, 0.1)):
            with self.subTest(options=options, stale_timeout=timeout):
                emulator, driver = self.rig(options=options, stale_timeout=timeout)
                self.stream.stop()
                self.expect_silence(emulator, self.stream.last_sent, limit + SLACK)
                driver.__exit__()
                emulator.__exit__()
                self.renew_stream()

    def test_stream_that_ends_without_limits_sounds_on(self):
        emulator, _ = self.rig(options='hold=10', stale_timeout=10.0)
        self.stream.stop()
        self.addCleanup(self.renew_stream)
        time.sleep(1.0)
        self.assertTrue(any(swap.sounds for swap in emulator.since(time.monotonic() - 0.3)))

    def test_ends(self):
        for name in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            with self.subTest(name):
                emulator, driver = self.rig()
                since = time.monotonic()
                driver.process.send_signal(name)
                self.expect_silence(emulator, since, 0.5 + SLACK)
                self.assertEqual(driver.process.wait(5), 0)
                emulator.__exit__()

    def test_killed(self):
        """kill -9 of the driver and of its process group: the guard process silences the boards."""
        for kill in (os.kill, os.killpg):
            with self.subTest(kill.__name__):
                self.stream.modulation_frequency = 0.0  # sounds without a pause
                emulator, driver = self.rig()
                since = time.monotonic()
                kill(driver.process.pid, signal.SIGKILL)
                self.expect_silence(emulator, since, 2 * FRAME + SLACK)
                emulator.__exit__()

    def test_killed_without_guard_sounds_on(self):
        emulator, driver = self.rig(options='guard=false')
        self.stream.modulation_frequency = 0.0
        time.sleep(0.3)
        driver.process.kill()
        driver.process.wait()
        time.sleep(0.5)
        self.assertTrue(emulator.sounds(), 'closing the port alone silences nothing')

    def test_hangs(self):
        """A driver that is stopped: the guard silences the boards; when it goes on, so does the sound."""
        self.stream.modulation_frequency = 0.0  # sounds without a pause
        emulator, driver = self.rig()
        since = time.monotonic()
        driver.process.send_signal(signal.SIGSTOP)
        self.expect_silence(emulator, since, 0.25 + SLACK)
        driver.process.send_signal(signal.SIGCONT)
        wait_until(emulator.sounds, 10, 'a sound')

    def guard(self, driver):
        """Number of the guard process of a driver."""
        found = subprocess.run(['ps', '-o', 'pid=,comm=', '--ppid', str(driver.process.pid)], stdout=subprocess.PIPE,
                               check=True,
                               universal_newlines=True).stdout.split()
        self.assertEqual(found[1::2], ['silence_guard'])
        return int(found[0])

    def test_guard_that_is_killed(self):
        """The driver silences the boards itself, says so, and stays silent: nobody would silence them if it died
        too."""
        self.stream.modulation_frequency = 0.0  # sounds without a pause
        emulator, driver = self.rig()
        since = time.monotonic()
        os.kill(self.guard(driver), signal.SIGKILL)
        self.expect_silence(emulator, since, 0.25 + SLACK)
        _, state = self.states.wait(lambda state: not state.emitting)
        self.assertIn('the guard process is gone', state.silent_reason)
        time.sleep(0.5)
        self.assertTrue(emulator.silent_for_good())

    def test_guard_that_is_frozen(self):
        """Silent until the guard answers again."""
        self.stream.modulation_frequency = 0.0
        emulator, driver = self.rig()
        guard = self.guard(driver)
        since = time.monotonic()
        os.kill(guard, signal.SIGSTOP)
        self.expect_silence(emulator, since, 0.25 + SLACK)
        _, state = self.states.wait(lambda state: not state.emitting)
        self.assertIn('the guard process does not answer', state.silent_reason)
        os.kill(guard, signal.SIGCONT)
        wait_until(emulator.sounds, 10, 'a sound')
        # And a driver that ends is not held up by a guard that is frozen.
        os.kill(guard, signal.SIGSTOP)
        driver.process.send_signal(signal.SIGINT)
        self.assertEqual(driver.process.wait(5), 0)
        self.assertTrue(emulator.silent_for_good())

    def test_unplugged_and_plugged_in(self):
        emulator, driver = self.rig()
        since = time.monotonic()
        emulator.unplug()
        _, state = self.states.wait(lambda state: not state.emitting, since)
        _, state = self.states.wait(lambda state: 'gone' in state.silent_reason, since)
        self.assertIn(emulator.link, state.silent_reason)
        time.sleep(1.5)
        emulator.power_cycle()
        again = time.monotonic()
        emulator.received.clear()
        emulator.plug()
        self.states.wait(lambda state: state.emitting, again)
        wait_until(emulator.sounds, 10, 'a sound after plugging in')
        self.assertEqual(bytes(emulator.received[:len(SILENCE)]), SILENCE)
        self.assertEqual(emulator.faults(), 0)
        told = [line for line in driver.lines if emulator.link in line]
        self.assertEqual(len(told), 1, ''.join(driver.lines))
        self.assertIn('is gone', told[0])
