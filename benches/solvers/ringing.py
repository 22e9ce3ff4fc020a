"""The pulse that makes a cavity ring, and the frequency at which it does so."""

import numpy as np

#: All programs compute so long, and are listened to when the pulse is over.
SECONDS, OVER = 1.8e-9, 0.4e-9
#: Middle and width of the pulse's spectrum, as openEMS has them: 1.8 periods of the width long.
MIDDLE, WIDTH = 13e9, 8e9
#: The lowest mode of a ball of radius 1 cm lies in this band, and no other.
BAND = (11e9, 15e9)


def pulse(time: float) -> float:
    """A pulse that is over after 0.36 ns."""
    start = 9 / (2 * np.pi * WIDTH)
    return float(np.cos(2 * np.pi * MIDDLE * (time - start)) * np.exp(-((2 * np.pi * WIDTH * (time - start) / 3) ** 2)))


def frequency_of(time: np.ndarray, voltage: np.ndarray) -> float:
    """The frequency of the strongest mode in the band: the signal as a sum of exponentials, by the shift of its singular vectors (ESPRIT)."""
    dt = (time[-1] - time[0]) / (len(time) - 1)
    every = max(1, int(1 / (160e9 * dt)))
    signal = voltage[time > OVER][::every]
    half = len(signal) // 2
    rows = np.lib.stride_tricks.sliding_window_view(signal, half)
    _, values, vectors = np.linalg.svd(rows, full_matrices=False)
    n_modes = min(int((values > 1e-5 * values[0]).sum()), half - 1)
    basis = vectors[:n_modes].T
    shifts = np.linalg.eigvals(np.linalg.lstsq(basis[:-1], basis[1:], rcond=None)[0])
    powers = np.exp(np.arange(len(signal))[:, None] * np.log(shifts))
    amplitudes = abs(np.linalg.lstsq(powers, signal.astype(complex), rcond=None)[0])
    found = np.angle(shifts) / (2 * np.pi * dt * every)
    inside = (found > BAND[0]) & (found < BAND[1])
    return float(found[np.argmax(amplitudes * inside)])
