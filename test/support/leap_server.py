#!/usr/bin/env python3
"""Replays recorded Leap v6 messages over a websocket, as a tracker's service does.

    leap_server.py FILE [--rate HZ] [--loop] [...]

Written from RFC 6455 and the protocol's description, with nothing of the package, so that it can test it. Prints JSON,
one object a line: {"port": N} once it listens, {"request": PATH} for each client, {"text": MESSAGE} for what a client
says, {"close": CODE} for a client's goodbye (null where it left without), {"sent": N} after the last frame, {"frame":
N, "time": T} after those of --tell, T in s since 1970.
"""
import argparse
import base64
import gzip
import hashlib
import json
import socket
import struct
import sys
import threading
import time

GUID = '258EAFA5-E914-47DA-95CA-C5AB0DC85B11'
CONTINUATION, TEXT, BINARY, CLOSE, PING, PONG = 0, 1, 2, 8, 9, 10


def say(**words):
    sys.stdout.write(json.dumps(words) + '\n')
    sys.stdout.flush()


def frame(opcode, payload, final=True):
    head = bytes([(0x80 if final else 0) | opcode])
    if len(payload) < 126:
        head += bytes([len(payload)])
    elif len(payload) < 65536:
        head += b'\x7e' + struct.pack('>H', len(payload))
    else:
        head += b'\x7f' + struct.pack('>Q', len(payload))
    return head + payload


class Client:
    def __init__(self, connection):
        self.connection = connection
        self.lock = threading.Lock()
        self.stream = connection.makefile('rb')
        self.gone = threading.Event()

    def shake_hands(self, refuse):
        request = self.stream.readline().decode().split()
        headers = {}
        while True:
            line = self.stream.readline().decode().strip()
            if not line:
                break
            key, value = line.split(':', 1)
            headers[key.lower()] = value.strip()
        assert request[0] == 'GET' and headers['upgrade'].lower() == 'websocket', (request, headers)
        assert headers['sec-websocket-version'] == '13'
        say(request=request[1])
        if refuse:
            return self.connection.sendall(b'HTTP/1.1 404 Not Found\r\nContent-Length: 0\r\n\r\n')
        accept = base64.b64encode(hashlib.sha1((headers['sec-websocket-key'] + GUID).encode()).digest()).decode()
        self.connection.sendall(('HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n'
                                 'Sec-WebSocket-Accept: %s\r\n\r\n' % accept).encode())
        threading.Thread(target=self.hear, daemon=True).start()
        return None

    def send(self, opcode, payload, final=True):
        with self.lock:
            self.connection.sendall(frame(opcode, payload, final))

    def hear(self):
        try:
            while True:
                first, second = self.stream.read(2)
                length = second & 0x7f
                if length == 126:
                    length, = struct.unpack('>H', self.stream.read(2))
                elif length == 127:
                    length, = struct.unpack('>Q', self.stream.read(8))
                assert second & 0x80, 'a client masks what it sends'
                mask = self.stream.read(4)
                data = bytes(b ^ mask[i % 4] for i, b in enumerate(self.stream.read(length)))
                opcode = first & 0x0f
                if opcode == PING:
                    self.send(PONG, data)
                elif opcode == CLOSE:
                    say(close=struct.unpack('>H', data[:2])[0] if data else 1005)
                    self.send(CLOSE, data[:2])
                    break
                elif opcode == TEXT:
                    say(text=data.decode())
        except (OSError, ValueError):
            say(close=None)
        self.gone.set()

    def leave(self):
        self.gone.set()
        try:
            self.connection.shutdown(socket.SHUT_RDWR)
        except OSError:
            pass
        self.connection.close()


def split(payload, parts):
    """A message in fragments: the first says what it is, the last that it is the last."""
    size = max(1, len(payload) // parts)
    pieces = [payload[i:i + size] for i in range(0, len(payload), size)]
    return [(TEXT if i == 0 else CONTINUATION, piece, i + 1 == len(pieces)) for i, piece in enumerate(pieces)]


GARBAGE = [(TEXT, b'{"hands": [', True), (TEXT, b'', True), (TEXT, b'[1, 2, 3]', True),
           (BINARY, bytes(range(256)), True),
           (TEXT, b'{"timestamp": "soon", "hands": []}', True), (TEXT, b'{"timestamp": 7, "hands": 5}', True),
           (TEXT, b'{"event": {"type": "deviceEvent", "state": 3}}', True), (TEXT, b'null', True)]


class Tracker:
    """The frames go on over the clients, as a device's do."""

    def __init__(self, options):
        self.options = options
        opened = gzip.open if options.file.endswith('.gz') else open
        with opened(options.file, 'rt') as lines:
            self.frames = [line.strip().encode() for line in lines if line.strip()]
        self.next, self.shift, self.sent = 0, 0, 0

    def device_event(self, attached=True):
        number = self.options.numeric_ids
        state = {'attached': attached, 'id': 5021 if number else 'LP5021', 'streaming': attached, 'type': 'peripheral'}
        return json.dumps({'event': {'type': 'deviceEvent', 'state': state}}).encode()

    def stamped(self, line):
        """Looped, the device's clock goes on."""
        if not self.shift:
            return line
        message = json.loads(line)
        if 'timestamp' in message:
            message['timestamp'] += self.shift
        return json.dumps(message).encode()

    def advance(self):
        self.next += 1
        if self.next == len(self.frames) and self.options.loop:
            stamps = [json.loads(line).get('timestamp') for line in self.frames]
            stamps = [stamp for stamp in stamps if stamp is not None]
            self.shift += stamps[-1] - stamps[0] + (stamps[-1] - stamps[0]) // max(1, len(stamps) - 1)
            self.next = 0

    def serve(self, client):
        options = self.options
        client.send(TEXT, b'{"serviceVersion":"test","version":6}' if options.numeric_ids else b'{"version":6}')
        client.send(TEXT, self.device_event())
        due, of_client = time.monotonic(), 0
        while not client.gone.is_set():
            if self.next == len(self.frames):
                say(sent=self.sent)
                return client.gone.wait()
            if options.garbage and of_client % options.garbage == options.garbage - 1:
                for piece in GARBAGE:
                    client.send(*piece)
            payload = self.stamped(self.frames[self.next])
            for piece in split(payload, options.fragments):
                client.send(*piece)
            if options.fragments > 1:
                client.send(PING, b'are you there')
            if self.next in options.tell:
                say(frame=self.next, time=time.time())
            self.sent += 1
            of_client += 1
            self.advance()
            if options.unplug and of_client == options.unplug:
                client.send(TEXT, self.device_event(attached=False))
                return client.gone.wait()
            if options.disconnect and of_client == options.disconnect:
                return None  # as a service that is killed
            due += 1.0 / options.rate
            time.sleep(max(0.0, due - time.monotonic()))
        return None


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument('file', help='messages, one a line, plain or .gz')
    parser.add_argument('--port', type=int, default=0)
    parser.add_argument('--rate', type=float, default=100.0, help='frames a second')
    parser.add_argument('--loop', action='store_true')
    parser.add_argument('--fragments', type=int, default=1, help='of each message; with pings between')
    parser.add_argument('--garbage', type=int, default=0, help='what is no message, before each so many frames')
    parser.add_argument('--disconnect', type=int, default=0, help='breaks each connection after so many frames')
    parser.add_argument('--tell', type=int, nargs='*', default=[], help='frames whose sending is told')
    parser.add_argument('--unplug', type=int, default=0, help='the device is gone after so many frames')
    parser.add_argument('--refuse', action='store_true', help='is no websocket server')
    parser.add_argument('--numeric-ids', action='store_true', help='of devices; else strings')
    options = parser.parse_args()
    tracker = Tracker(options)
    listener = socket.socket()
    listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    listener.bind(('127.0.0.1', options.port))
    listener.listen()
    say(port=listener.getsockname()[1])
    while True:
        connection, _ = listener.accept()
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        client = Client(connection)
        try:
            client.shake_hands(options.refuse)
            if not options.refuse:
                tracker.serve(client)
        except (OSError, AssertionError, KeyError, ValueError, IndexError) as error:
            print('leap_server: %r' % error, file=sys.stderr)
        client.leave()


if __name__ == '__main__':
    try:
        main()
    except KeyboardInterrupt:
        pass
