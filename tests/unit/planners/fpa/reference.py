"""Reference of the flower pollination algorithm in plain integers, lists and loops.

It uses one compiled kernel, the fitness of a path, as an argument.
"""

import math

import numpy as np


WORD = 0xFFFFFFFF


def philox(counter, key):
    """Return Philox4x32-10 of four counter words and two key words, as published."""
    counter, key = list(counter), list(key)
    for _ in range(10):
        first, second = 0xD2511F53 * counter[0], 0xCD9E8D57 * counter[2]
        counter = [
            (second >> 32) ^ counter[1] ^ key[0],
            second & WORD,
            (first >> 32) ^ counter[3] ^ key[1],
            first & WORD,
        ]
        key = [(key[0] + 0x9E3779B9) & WORD, (key[1] + 0xBB67AE85) & WORD]
    return counter


def draw(seed, iteration, solution, number):
    return philox((number, solution, iteration & WORD, iteration >> 32), (seed & WORD, seed >> 32))


def uniform(high, low):
    return (((high << 32 | low) >> 12) + 0.5) / 2**52


def levy(a, b):
    """Return Mantegna's step with the exponent 1.5 from two uniform numbers."""
    sigma = (math.gamma(2.5) * math.sin(0.75 * math.pi) / (math.gamma(1.25) * 1.5 * 2**0.25)) ** (
        2 / 3
    )
    radius = math.sqrt(-2 * math.log(a))
    return (
        sigma
        * radius
        * math.cos(2 * math.pi * b)
        / abs(radius * math.sin(2 * math.pi * b)) ** (2 / 3)
    )


def candidate(seed, iteration, iterations, solution, paths, best, low, high):
    """Return the candidate for a solution by equations (4) and (5)."""
    count = len(paths)
    words = draw(seed, iteration, solution, 0)
    if uniform(*words[:2]) < 0.5:
        steps = []
        for number in range(2, 2 + 3 * (paths.shape[1] - 2)):
            w = draw(seed, iteration, solution, number)
            steps.append(0.1 * levy(uniform(*w[:2]), uniform(*w[2:])))
        step = np.array(steps).reshape(-1, 3) * (paths[solution] - paths[best])[1:-1]
    else:
        one = words[2] * count >> 32
        other = [j for j in range(count) if j != one][words[3] * (count - 1) >> 32]
        bound = np.interp(iteration, (1, iterations), (0.25, 0.02))
        epsilon = bound * uniform(*draw(seed, iteration, solution, 1)[:2])
        step = epsilon * (paths[one] - paths[other])[1:-1]
    path = paths[solution].copy()
    path[1:-1] = np.clip(path[1:-1] + step, low, high)
    return path


def untangled(path, fitness, worth):
    """Apply 2-opt: take the first better reversal and restart, until there is none."""
    interior = range(1, len(path) - 1)
    for first in interior:
        for last in interior:
            if last <= first:
                continue
            other = path.copy()
            other[first : last + 1] = other[first : last + 1][::-1]
            value = worth(other)
            if value > fitness:
                return untangled(other, value, worth)
    return path, fitness


def iterate(seed, iteration, iterations, two_opt, paths, fitness, low, high, worth):
    """Return the population after an iteration: paths (m, n, 3) and fitness (m,)."""
    best = int(np.argmax(fitness))
    after, values = paths.copy(), fitness.copy()
    for i in range(len(paths)):
        other = candidate(seed, iteration, iterations, i, paths, best, low, high)
        value = worth(other)
        if value > fitness[i]:
            after[i], values[i] = other, value
        if two_opt:
            after[i], values[i] = untangled(after[i], values[i], worth)
    return after, values
