#!/usr/bin/env python3
"""An emulator of the SonicSurface boards behind a pseudo-terminal, written from the table of their protocol.

It shares no code with the driver. As a program, `sonic_surface.py LINK [boards [firmware]]` makes LINK a serial port to
give to the driver, and tells what the boards do until it is stopped.
"""
import math
import os
import pty
import select
import sys
import threading
import time
import tty

BAUD = 230400
CHANNELS = 256
OFF = 32
STOCK, TACTILE = 'stock', 'tactile'
PITCH = 0.0105  # m

# Channel at each place of a board, row by row from the highest y, column by column from the lowest x, as the boards are
# wired.
WIRING = [
      0,   7,   1,   2,  64,  71,  65,  66, 128, 135, 129, 130, 192, 199, 193, 194,
      4,   3,   6,   5,  68,  67,  70,  69, 132, 131, 134, 133, 196, 195, 198, 197]


def places():
    """(x, y) in m of each channel. A pair of rows is wired as the pair above it, 8 channels on."""
    found = [None] * CHANNELS
    for place in range(CHANNELS):
        row, column = divmod(place, 16)
        pair, within = divmod(row, 2)
        channel = WIRING[16 * within + column] + 8 * pair
        found[channel] = ((column - 7.5) * PITCH, (7.5 - row) * PITCH)
    assert None not in found
    return found


class Board:
    """The state of one board: what each byte does to it."""

    def __init__(self, index=0, firmware=STOCK):
        self.index, self.firmware = index, firmware
        self.selected = True
        self.counter = 0
        self.front, self.back = [OFF] * CHANNELS, [OFF] * CHANNELS
        self.clocks = True
        self.modulation_step = 10
        self.flipped = set()  # channels whose transducers are soldered the other way round
        self.corrupted = 0  # bytes that are no phase, and were taken as one
        self.overrun = 0    # bytes for channels that the board does not have

    def feed(self, byte):
        """Returns whether the byte swapped the buffers."""
        if byte == 0xFD:
            self.front, self.back = self.back, self.front
            self.counter = 0
            return True
        if byte == 0xFE:
            if self.selected:
                self.counter = 0
        elif self.firmware == TACTILE and byte >> 5 == 0b101:
            self.modulation_step = byte & 0x1F
        elif self.firmware == STOCK and byte in (0xC0, 0xC1):
            self.selected = byte - 0xC0 == self.index
        elif self.firmware == STOCK and byte in (150, 151):
            self.clocks = byte == 151
        elif self.selected:
            self.corrupted += byte > OFF
            self.overrun += self.counter >= CHANNELS
            self.back[self.counter % CHANNELS] = OFF if byte == OFF else byte & 0x1F
            self.counter += 1
        return False

    def power_on(self):
        """Every channel of the stock firmware plays phase 0 then, in both buffers; of the tactile one in the back
        buffer."""
        self.selected, self.clocks, self.counter = True, True, 0
        self.front = [0 if self.firmware == STOCK else OFF] * CHANNELS
        self.back = [0] * CHANNELS

    def scramble(self, random):
        """Whatever programs may have left behind."""
        pattern = lambda: [random.choice((OFF, random.randrange(32))) for _ in range(CHANNELS)]
        self.front, self.back = pattern(), pattern()
        self.counter = random.choice((0, 1, random.randrange(512), CHANNELS))
        if self.firmware == STOCK:
            self.selected, self.clocks = random.random() < 0.5, random.random() < 0.5

    def sounds(self):
        return self.clocks and any(value != OFF for value in self.front)

    def drive(self):
        """(phase in rad, or None where the channel is off) of each channel that plays."""
        levels, step = (16, 2) if self.firmware == TACTILE else (32, 1)
        return [None if v == OFF or not self.clocks else
                2 * math.pi * (v // step) / levels + (math.pi if n in self.flipped else 0.0)
                for n, v in enumerate(self.front)]

    def modulation(self):
        """Hz, of the tactile firmware."""
        return 1250.0 / (self.modulation_step + 1)


class Swap:
    """A swap: when its byte had come over a wire of the boards' rate, and what plays since."""

    def __init__(self, when, boards):
        self.when = when
        self.fronts = tuple(tuple(board.front) for board in boards)
        self.backs = tuple(tuple(board.back) for board in boards)
        self.sounds = any(board.sounds() for board in boards)


class Emulator:
    """Boards behind a pseudo-terminal that has the name `link`. A context manager; times are those of
    time.monotonic()."""

    def __init__(self, link, boards=1, firmware=STOCK):
        self.link, self.firmware, self.count = link, firmware, boards
        self.boards = [Board(index, firmware) for index in range(boards)]
        self.swaps, self.received, self.lag, self.wire = [], bytearray(), 0.0, 0.0
        self.lock = threading.Lock()
        self.master = self.slave = self.thread = None

    def __enter__(self):
        self.plug()
        return self

    def __exit__(self, *_):
        self.unplug()

    def plug(self):
        self.master, self.slave = pty.openpty()
        tty.setraw(self.slave)
        self.running = True
        self.thread = threading.Thread(target=self.run, daemon=True)
        self.thread.start()
        if os.path.lexists(self.link):
            os.unlink(self.link)
        os.symlink(os.ttyname(self.slave), self.link)

    def unplug(self):
        """The port goes away. What the boards play, they go on to play."""
        if self.master is None:
            return
        self.running = False
        self.thread.join()
        if os.path.lexists(self.link):
            os.unlink(self.link)
        os.close(self.slave)
        os.close(self.master)
        self.master = self.slave = None

    def power_cycle(self):
        with self.lock:
            for board in self.boards:
                board.power_on()

    def run(self):
        while self.running:
            if not select.select([self.master], [], [], 0.02)[0]:
                continue
            data = os.read(self.master, 4096)
            now = time.monotonic()
            with self.lock:
                for byte in data:
                    self.wire = max(self.wire, now) + 10.0 / BAUD
                    swapped = [board.feed(byte) for board in self.boards]
                    if any(swapped):
                        self.swaps.append(Swap(self.wire, self.boards))
                self.lag = max(self.lag, self.wire - now)
                self.received += data

    def sounds(self):
        with self.lock:
            return any(board.sounds() for board in self.boards)

    def silent_for_good(self):
        """Both buffers are silent: no swap can bring a pattern back."""
        with self.lock:
            return all(v == OFF for board in self.boards for v in board.front + board.back)

    def last_sound(self):
        """When the last sound ended, with the next swap."""
        with self.lock:
            return max(after.when for before, after in zip(self.swaps, self.swaps[1:]) if before.sounds)

    def since(self, when):
        with self.lock:
            return [swap for swap in self.swaps if swap.when >= when]

    def faults(self):
        """Number of bytes that no board should be sent."""
        with self.lock:
            return sum(board.corrupted + board.overrun for board in self.boards)


def main():
    boards = int(sys.argv[2]) if len(sys.argv) > 2 else 1
    firmware = sys.argv[3] if len(sys.argv) > 3 else STOCK
    with Emulator(sys.argv[1], boards, firmware) as emulator:
        print('%d board(s), %s firmware, at %s' % (boards, firmware, sys.argv[1]), flush=True)
        try:
            while True:
                start = time.monotonic()
                time.sleep(1)
                on = sum(v != OFF for board in emulator.boards for v in board.front + board.back)
                print('%d swaps, %d channels in use, %d bad bytes' %
                      (len(emulator.since(start)), on, emulator.faults()),
                      flush=True)
        except KeyboardInterrupt:
            pass


if __name__ == '__main__':
    main()
