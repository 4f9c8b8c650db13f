//! `x⁺ = A_d x + B_d u` at a sample time h.
//!
//! Zero- and first-order hold by one exponential: Van Loan, IEEE Trans. Automat. Control 23 (1978), pp. 395–404; Franklin,
//! Powell & Workman, Digital Control of Dynamic Systems, 3rd ed. (1998), pp. 204–206, for the ramp. Bilinear: `s = (2/h) (z − 1)/(z + 1)`.

use super::system::StateSpace;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::numeric::expm::expm;
use crate::numeric::{Matrix, definite};
use crate::scene::study::Hold;

impl StateSpace {
    /// The same, sampled every `sample_time` seconds.
    ///
    /// # Errors
    /// `OutOfRange` for a sample time that is not positive; `Conflict` where it is sampled already; `Overflow` where the
    /// exponential keeps no digit; `Indefinite` where 2/h is a pole and the rule bilinear.
    pub fn sampled(&self, sample_time: f64, hold: Hold) -> Result<StateSpace, Error> {
        if let Some(already) = self.sample_time {
            let message = format!("it is sampled every {already} s already");
            return Err(Error::new(Code::Conflict, message).hint("sample the continuous form"));
        }
        if !(sample_time > 0.0 && sample_time.is_finite()) {
            let message = format!("a sample time of {sample_time} s is not positive");
            return Err(Error::new(Code::OutOfRange, message)
                .hint("a tenth of the shortest period of interest is a start"));
        }
        let [a, b, c, d] = match hold {
            Hold::Zero => self.zero_order(sample_time)?,
            Hold::First => self.first_order(sample_time)?,
            Hold::Bilinear => self.bilinear(sample_time)?,
        };
        Ok(StateSpace {
            a,
            b,
            c,
            d,
            sample_time: Some(sample_time),
            hold: Some(hold),
            ..self.clone()
        })
    }

    /// `exp [A B; 0 0] h = [A_d B_d; 0 1]`.
    fn zero_order(&self, h: f64) -> Result<[Matrix; 4], Error> {
        let (n, m) = (self.a.nrows(), self.b.ncols());
        let exponential = expm(&self.augmented(h, n + m))?;
        Ok([
            part(&exponential, 0, n, n),
            part(&exponential, n, n, m),
            self.c.clone(),
            self.d.clone(),
        ])
    }

    /// `exp [A B 0; 0 0 1/h; 0 0 0] h = [Φ Γ₁ Γ₂; …]`: `ξ = x − Γ₂ u` is the state, `B_d = Γ₁ − Γ₂ + Φ Γ₂`, `D_d = D + C Γ₂`.
    fn first_order(&self, h: f64) -> Result<[Matrix; 4], Error> {
        let (n, m) = (self.a.nrows(), self.b.ncols());
        let mut exponent = self.augmented(h, n + 2 * m);
        (0..m).for_each(|j| exponent[(n + j, n + m + j)] = 1.0);
        let exponential = expm(&exponent)?;
        let phi = part(&exponential, 0, n, n);
        let (gamma1, gamma2) = (part(&exponential, n, n, m), part(&exponential, n + m, n, m));
        let b = &gamma1 - &gamma2 + &phi * &gamma2;
        let d = &self.d + &self.c * &gamma2;
        Ok([phi, b, self.c.clone(), d])
    }

    /// `A_d = (1 − A h/2)⁻¹ (1 + A h/2)`, `B_d = (1 − A h/2)⁻¹ B h`, `C_d = C (1 − A h/2)⁻¹`, `D_d = D + ½ C B_d`.
    fn bilinear(&self, h: f64) -> Result<[Matrix; 4], Error> {
        let n = self.a.nrows();
        let step = |sign: f64| {
            Matrix::from_fn(n, n, |i, j| {
                f64::from(u8::from(i == j)) + sign * 0.5 * h * self.a[(i, j)]
            })
        };
        let back = step(-1.0);
        let a = definite::solve(&back, &step(1.0))?;
        let b = definite::solve(
            &back,
            &Matrix::from_fn(n, self.b.ncols(), |i, j| h * self.b[(i, j)]),
        )?;
        let c = definite::solve(&back.transpose().to_owned(), &self.c.transpose().to_owned())?
            .transpose()
            .to_owned();
        let through = &self.c * &b;
        let d = Matrix::from_fn(self.d.nrows(), self.d.ncols(), |i, j| {
            self.d[(i, j)] + 0.5 * through[(i, j)]
        });
        Ok([a, b, c, d])
    }

    /// `[A B; 0 0] h` with room.
    fn augmented(&self, h: f64, size: usize) -> Matrix {
        let (n, m) = (self.a.nrows(), self.b.ncols());
        Matrix::from_fn(size, size, |i, j| match (i < n, j < n, j < n + m) {
            (true, true, _) => h * self.a[(i, j)],
            (true, false, true) => h * self.b[(i, j - n)],
            _ => 0.0,
        })
    }
}

/// The first `rows` rows of `columns` columns from `from` on.
fn part(a: &Matrix, from: usize, rows: usize, columns: usize) -> Matrix {
    Matrix::from_fn(rows, columns, |i, j| a[(i, from + j)])
}
