"""Reference answers for difference equations, by statsmodels, into data/reference/time_series.json.

    pip install numpy scipy statsmodels
    python3 tools/reference_time_series.py

One record of 500 samples of an ARMA(2, 1) process (written out to 12 digits, so that every program reads the same numbers), fitted as
AR(4) by Burg and by Yule-Walker (biased autocovariances), as AR(4) by least squares without a constant, as ARMA(2, 1) by exact maximum
likelihood (statsmodels) and by the smallest sum of squares with the errors before the third sample zero (SciPy); the Ljung-Box statistic of the record itself. Coefficients in the sign convention y_t + a_1 y_{t-1} + ... = e_t + c_1 e_{t-1}.
"""

import datetime
import json
import pathlib

import numpy as np
import scipy.optimize
import scipy.signal
import statsmodels
from statsmodels.regression.linear_model import burg, yule_walker
from statsmodels.stats.diagnostic import acorr_ljungbox
from statsmodels.tsa.ar_model import AutoReg
from statsmodels.tsa.arima.model import ARIMA

rng = np.random.default_rng(20)
e = rng.standard_normal(700)
y = np.zeros(700)
for t in range(2, 700):
    y[t] = 1.5 * y[t - 1] - 0.8 * y[t - 2] + e[t] + 0.4 * e[t - 1]
y = np.array([float(f"{v:.12g}") for v in y[200:]])
centred = y - y.mean()

rho_burg, variance_burg = burg(y, 4, demean=True)
rho_walker, sigma_walker = yule_walker(y, 4, method="mle", demean=True)
squares = AutoReg(centred, lags=4, trend="n").fit()
arma = ARIMA(centred, order=(2, 0, 1), trend="n").fit()


def errors(theta):
    a1, a2, c1 = theta
    driven = centred[2:] + a1 * centred[1:-1] + a2 * centred[:-2]
    return scipy.signal.lfilter([1.0], [1.0, c1], driven)


conditional = scipy.optimize.least_squares(errors, [-1.4, 0.7, 0.3], xtol=1e-14, ftol=1e-14, gtol=1e-14)
box = acorr_ljungbox(y, lags=[10])

out = {
    "source": f"statsmodels {statsmodels.__version__}, SciPy {scipy.__version__}, tools/reference_time_series.py, {datetime.date.today()}",
    "y": y.tolist(),
    "burg": {"a": (-rho_burg).tolist(), "variance": float(variance_burg)},
    "yule_walker": {"a": (-rho_walker).tolist(), "variance": float(sigma_walker**2)},
    "least_squares": {"a": (-squares.params).tolist(), "std": squares.bse.tolist()},
    "arma": {
        "a": (-arma.arparams).tolist(),
        "c": arma.maparams.tolist(),
        "variance": float(arma.params[-1]),
        "std": arma.bse[:-1].tolist(),
    },
    "arma_conditional": {"theta": conditional.x.tolist()},
    "ljung_box_10": {"statistic": float(box["lb_stat"].iloc[0]), "probability": float(box["lb_pvalue"].iloc[0])},
}
path = pathlib.Path(__file__).parents[1] / "data/reference/time_series.json"
path.write_text(json.dumps(out, indent=1) + "\n")
