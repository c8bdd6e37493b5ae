"""The compass: an "angular Gaussian" over headings (Wu & Bell 2003, eq. 12).

    P(b | theta) = (cos^2((b - theta) / 2))^(1 / eps)

For small eps, cos^2(x / 2) = 1 - x^2 / 4 + ... gives exp(-x^2 / (4 eps)), a Gaussian of variance
2 eps; so a compass of standard deviation sigma has eps = sigma^2 / 2.
"""

import numpy as np
from numpy.typing import NDArray

OUTLIER = 0.01
"""Floor of the likelihood: iron nearby can turn a compass by any angle."""


def compass_likelihood(
    headings: NDArray[np.float64], yaw: float, sigma: float, outlier: float = OUTLIER
) -> NDArray[np.float64]:
    """Return P(yaw | heading) of headings (n,), 1 at the best; `sigma` in rad.

    Without outliers (`outlier=0`) this is eq. 12 to the letter.
    """
    exponent = 2.0 / sigma**2
    angular_gaussian = np.cos((yaw - headings) / 2.0) ** 2
    likelihood: NDArray[np.float64] = (1.0 - outlier) * angular_gaussian**exponent + outlier
    return likelihood
