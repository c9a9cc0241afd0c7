# SPDX-License-Identifier: MIT
# SPDX-FileCopyrightText: 2026 the ryusa authors
"""How well the mean of a correlated series is known: src/analysis/statistics.c again, for the series of other programs.
Autocorrelation by FFT, Geyer's window, Wolff's correction, the cut that leaves the most independent samples, and what
such a choice feigns."""
import numpy as np

CANDIDATES, FEWEST, SELECTION = 80, 8, 12.0


def autocorrelation_time(x):
    """Integrated, in samples."""
    n = len(x)
    y = np.fft.rfft(x - x.mean(), 1 << int(np.ceil(np.log2(1.5 * n + 1))))
    covariance = np.fft.irfft(y * y.conj())[:n // 2 + 1] / (n - np.arange(n // 2 + 1))
    if covariance[0] <= 0.0:
        return 0.5
    rho = covariance / covariance[0]
    pairs = rho[2:len(rho) - 1:2] + rho[3:len(rho):2]
    ended = np.flatnonzero(pairs <= 0.0)
    window = 1 + 2 * int(ended[0] if len(ended) else len(pairs))
    return max((0.5 + rho[1:window + 1].sum()) * (1.0 + (2.0 * window + 1.0) / n), 1.0 / n)


def effective(x):
    return len(x) / max(1.0, 2.0 * autocorrelation_time(x)) if np.ptp(x) > 0.0 else len(x)


def statistics(x):
    """Mean and standard error of what follows the cut, and how many independent samples that is."""
    x = np.asarray(x, dtype=float)
    searched = len(x) >= 2 * FEWEST and np.ptp(x) > 0.0
    if searched:
        cuts = sorted({int((i / (CANDIDATES - 1)) ** 2 * 0.5 * len(x)) for i in range(CANDIDATES)})
        x = x[max(cuts, key=lambda cut: (effective(x[cut:]), -cut)):]
    if len(x) < FEWEST or np.ptp(x) == 0.0:
        return x.mean(), np.inf, len(x)
    found = len(x) / (2.0 * autocorrelation_time(x))
    number = found / (1.0 + SELECTION / found) if searched else found
    return x.mean(), np.sqrt(x.var() / number), number


def mean(x):
    return statistics(x)[:2]
