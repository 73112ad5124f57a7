"""Staircases of a plan: their rules and their steps. A module of `trial`, no program."""
import math
import statistics

from trial_yaml import is_number


class Staircase:
    """Goes to where a trial is detected with a certain probability: `down` detections in a row make the next one
    harder, `up` misses in a row easier (Levitt 1971, doi 10.1121/1.1912375). 1 up and 2 down end at 70.7 %."""

    def __init__(self, rule):
        self.rule, self.value = rule, rule['start']
        self.count, self.hits, self.misses, self.way = 0, 0, 0, 0
        self.reversals = []  # values at which it turned

    def take(self, detected):
        self.count += 1
        self.hits, self.misses = (self.hits + 1, 0) if detected else (0, self.misses + 1)
        if self.hits >= self.rule['down']:
            self.move(-1)
        elif self.misses >= self.rule['up']:
            self.move(1)

    def move(self, way):
        self.hits = self.misses = 0
        if self.way not in (0, way):
            self.reversals.append(self.value)
        self.way = way
        step = self.rule['steps'][min(len(self.reversals), len(self.rule['steps']) - 1)]
        way *= 1 if self.rule['harder'] == 'down' else -1
        value = self.value * step ** way if self.rule['scale'] == 'log' else self.value + way * step
        self.value = min(max(value, self.rule['low']), self.rule['high'])

    def done(self):
        return len(self.reversals) >= self.rule['reversals'] or self.count >= self.rule['trials']

    def threshold(self):
        """Mean of the values at which it turned with its smallest step, geometric on a log scale. None before."""
        turned = self.reversals[len(self.rule['steps']) - 1:]
        turned = turned[len(turned) % 2:]  # as many upper ones as lower ones
        if not turned:
            return None
        if self.rule['scale'] == 'log':
            return math.exp(statistics.fmean(map(math.log, turned)))
        return statistics.fmean(turned)


def read_staircase(reader, answers):
    if reader is None:
        return None
    rule = dict(key=reader.text('key', 'an argument of the rig, or NODE/parameter'),
                start=reader.number('start', -math.inf, math.inf), low=reader.number('low', -math.inf, math.inf),
                high=reader.number('high', -math.inf, math.inf), down=reader.whole('down', 1, 20, 2),
                up=reader.whole('up', 1, 20, 1), harder=reader.choice('harder', ('down', 'up'), 'down'),
                scale=reader.choice('scale', ('linear', 'log'), 'linear'),
                reversals=reader.whole('reversals', 2, 1000, 8), trials=reader.whole('trials', 1, 10000, 100),
                detected=reader.text('detected', "one of 'answers', which counts as detected"),
                steps=reader.items('steps', 'a list of steps, the first until the first reversal and so on'))
    reader.finish()
    least = 1.0 if rule['scale'] == 'log' else 0.0
    if not all(is_number(step) and step > least for step in rule['steps']):
        reader.fail('steps', "'%s' is %s, expected numbers above %g" % (reader.named('steps'), rule['steps'], least))
    if not rule['low'] <= rule['start'] <= rule['high']:
        reader.fail('start', "'%s' is %g, expected it from 'low' %g to 'high' %g" %
                    (reader.named('start'), rule['start'], rule['low'], rule['high']))
    if rule['scale'] == 'log' and rule['low'] <= 0:
        reader.fail('low', "'%s' is %g, expected it above 0 on a log scale" % (reader.named('low'), rule['low']))
    if rule['detected'] not in answers:
        reader.fail('detected', "'%s' is '%s', expected one of 'answers': %s" %
                    (reader.named('detected'), rule['detected'], ', '.join(answers) or 'there are none'))
    if rule['reversals'] < len(rule['steps']) + 1:
        reader.fail('reversals', "'%s' is %d, expected at least %d: two more than there are larger steps" %
                    (reader.named('reversals'), rule['reversals'], len(rule['steps']) + 1))
    return rule
