# SPDX-License-Identifier: MIT
# SPDX-FileCopyrightText: 2026 the ryusa authors
"""How well the mean of a correlated series is known: src/analysis/statistics.c again, for the series of other programs.
Autocorrelation by FFT, Geyer's window, Wolff's correction, and the cut that leaves the most independent samples."""
import numpy as np

CANDIDATES, FEWEST = 80, 8


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


def mean(x):
    """Mean and standard error of what follows the cut."""
    x = np.asarray(x, dtype=float)
    if len(x) >= 2 * FEWEST and np.ptp(x) > 0.0:
        cuts = sorted({int((i / (CANDIDATES - 1)) ** 2 * 0.5 * len(x)) for i in range(CANDIDATES)})
        x = x[max(cuts, key=lambda cut: (effective(x[cut:]), -cut)):]
    if len(x) < FEWEST or np.ptp(x) == 0.0:
        return x.mean(), np.inf
    return x.mean(), np.sqrt(x.var() * 2.0 * autocorrelation_time(x) / len(x))
