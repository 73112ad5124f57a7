"""QUEST, an adaptive staircase: A. B. Watson and D. G. Pelli, Perception & Psychophysics 33, 1983, doi
10.3758/BF03202828. A module of `staircase`, no program."""
import math

BETA = 3.5    # slope of the psychometric function, per log10 of the strength (Watson & Pelli)
DELTA = 0.01  # share of answers that are slips of the finger
GAMMA = 0.5   # share of right answers of who feels nothing: one of two intervals
SPAN, GRAIN = 2.0, 0.01  # log10: thresholds that are thought of lie so far around the guess, in such steps


def right_answers(strength, threshold):
    """Share 0-1 of right answers: a Weibull function of log10 of the strength, 82 % at the threshold."""
    seen = 1.0 - (1.0 - GAMMA) * math.exp(-10.0 ** min(BETA * (strength - threshold), 3.0))
    return DELTA * GAMMA + (1.0 - DELTA) * seen


class Quest:
    """What is known of a threshold, log10 of a strength: its probability on a grid."""

    def __init__(self, guess, deviation):
        """`guess`: log10, of the threshold; `deviation`: of a normal distribution around it."""
        steps = int(round(SPAN / GRAIN))
        self.grid = [guess + GRAIN * k for k in range(-steps, steps + 1)]
        self.log = [-0.5 * ((t - guess) / deviation) ** 2 for t in self.grid]

    def next(self):
        """The strength to try: the most probable threshold."""
        return self.grid[max(range(len(self.grid)), key=self.log.__getitem__)]

    def update(self, strength, right):
        """After an answer to that strength, log10."""
        for k, threshold in enumerate(self.grid):
            share = right_answers(strength, threshold)
            self.log[k] += math.log(share if right else 1.0 - share)

    def estimate(self):
        """Mean and standard deviation of the threshold, log10."""
        most = max(self.log)
        weights = [math.exp(value - most) for value in self.log]
        total = sum(weights)
        mean = sum(w * t for w, t in zip(weights, self.grid)) / total
        return mean, math.sqrt(sum(w * (t - mean) ** 2 for w, t in zip(weights, self.grid)) / total)
