//! What frequencies are in a signal: spectra, frequency response estimators, and what turns with a shaft. On slices and blocks of
//! samples; knows neither files nor machines.
