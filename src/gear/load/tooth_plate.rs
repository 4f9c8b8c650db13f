//! Tooth as a plate with shear on an elastic root line: `½∫ (D κᵀ(ν)κ + (5/6) G t γ²) dA + ½∫ qᵀ C⁻¹ q ds − F w`, Ritz with Legendre
//! polynomials.
//!
//! Deflection w and rotations θ_x, θ_y are nine polynomials along the face times seven over the height each (Mindlin 1951). The root line
//! turns and moves by `E′ θ = 16.67/π M/t² + (1 − 2ν)/(1 − ν) V/t`, `E′ w = (1 − 2ν)/(1 − ν) M/t + 1.534 V` under moment and shear of a
//! unit width, E′ = E/(1 − ν²) (Weber and Banaschek 1953; O'Donnell, J. Eng. Ind. 82, 1960). A plate with shear has no limit under a point
//! load as its polynomials grow: the local part belongs to the half space, so they are few.

use std::f64::consts::PI;

use super::material::Material;
use crate::base::error::Error;
use crate::numeric::profile_matrix::ProfileMatrix;
use crate::numeric::quadrature;

/// Polynomials along the face and over the height.
const POLYNOMIALS: [usize; 2] = [9, 7];
const TERMS: usize = POLYNOMIALS[0] * POLYNOMIALS[1];
/// Shear factor of a plate.
const SHEAR_FACTOR: f64 = 5.0 / 6.0;
/// Compliances of the root line under moment and shear in plane strain.
const ROOT_TURN: f64 = 16.67 / PI;
const ROOT_SHIFT: f64 = 1.534;

/// The middle plane of a tooth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlateShape {
    /// `[x, y]` of the corners by `[toe, heel]`, each by `[root, tip]`, m: x along the tooth, y from the root up.
    pub corners: [[[f64; 2]; 2]; 2],
    /// Elastic constants.
    pub material: Material,
}

/// The compliance of a tooth that bends.
#[derive(Debug, Clone, PartialEq)]
pub struct ToothPlate {
    /// Compliance of the deflection's coefficients, row by row, m/N.
    compliance: Vec<f64>,
    /// Places of the root line: their length, m, and the moment of a unit length there under a unit of each coefficient's load, N.
    root: Vec<(f64, Vec<f64>)>,
}

/// Bending moment in the root line of a tooth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RootMoment {
    /// Over the whole root line, N·m.
    pub total: f64,
    /// Greatest of a unit length of it, N.
    pub greatest: f64,
}

/// Shape functions with their derivatives over x and y at a place of the plate.
struct ShapeAt {
    value: [f64; TERMS],
    by_x: [f64; TERMS],
    by_y: [f64; TERMS],
    /// Area, m², of a unit of both shares.
    area: f64,
    /// Length of the root line, m, of a unit of the face.
    length: f64,
}

impl ToothPlate {
    /// The plate of a thickness, m, over the shares of face and height.
    ///
    /// # Errors
    /// `IllPosed`: corners in no order, or a thickness that is not positive.
    pub fn new(
        shape: &PlateShape,
        thickness: impl Fn([f64; 2]) -> f64,
    ) -> Result<ToothPlate, Error> {
        const N: usize = 3 * TERMS;
        let mut stiffness = vec![0.0; N * N];
        let share = |x: f64| 0.5 * (x + 1.0);
        for (x, weight_x) in quadrature::nodes() {
            for (y, weight_y) in quadrature::nodes() {
                let at = [share(x), share(y)];
                let here = shape.functions(at);
                let weight = 0.25 * weight_x * weight_y * here.area;
                bend(
                    &mut stiffness,
                    &here,
                    &shape.material,
                    thickness(at),
                    weight,
                );
            }
            let at = [share(x), 0.0];
            let here = shape.functions(at);
            hold(
                &mut stiffness,
                &here,
                &shape.material,
                thickness(at),
                0.5 * weight_x * here.length,
            );
        }
        let all: Vec<usize> = (0..N).collect();
        let factor = ProfileMatrix::from_rows(&stiffness, N).cholesky(&all)?;
        let mut compliance = vec![0.0; TERMS * TERMS];
        let mut column = vec![0.0; N];
        let places = quadrature::nodes().map(|(x, weight)| {
            let at = [share(x), 0.0];
            (shape.functions(at), thickness(at), 0.5 * weight)
        });
        let places: Vec<(ShapeAt, f64, f64)> = places.collect();
        let mut root: Vec<(f64, Vec<f64>)> = (places.iter())
            .map(|(here, _, weight)| (weight * here.length, vec![0.0; TERMS]))
            .collect();
        for j in 0..TERMS {
            column.fill(0.0);
            column[j] = 1.0;
            factor.solve(&mut column);
            (0..TERMS).for_each(|i| compliance[i * TERMS + j] = column[i]);
            for ((here, t, _), (_, moment)) in places.iter().zip(&mut root) {
                let field = |k: usize| -> f64 {
                    let coefficients = column[k * TERMS..(k + 1) * TERMS].iter();
                    coefficients.zip(&here.value).map(|(a, b)| a * b).sum()
                };
                let [[of_turn, of_shift], _] = root_stiffness(&shape.material, *t);
                moment[j] = of_turn * field(2) + of_shift * field(0);
            }
        }
        Ok(ToothPlate { compliance, root })
    }

    /// Moment in the root line under the sum of shape functions, each times its force, N.
    pub fn root_moment(&self, loading: &[f64]) -> RootMoment {
        let mut moment = RootMoment {
            total: 0.0,
            greatest: 0.0,
        };
        for (length, unit) in &self.root {
            let here: f64 = unit.iter().zip(loading).map(|(a, b)| a * b).sum();
            moment.total += length * here;
            moment.greatest = moment.greatest.max(here);
        }
        moment
    }

    /// Shape functions at shares of face and height along a force whose cosine with the plate's normal is given, and the coefficients
    /// under its unit, m/N.
    pub fn load(&self, at: [f64; 2], cosine: f64) -> (Vec<f64>, Vec<f64>) {
        let [along, up] = [0, 1].map(|k| legendre(2.0 * at[k] - 1.0));
        let value = |i: usize| cosine * along[i / POLYNOMIALS[1]].0 * up[i % POLYNOMIALS[1]].0;
        let shape: Vec<f64> = (0..TERMS).map(value).collect();
        // Row by row of the symmetric matrix, so that terms of a row are independent.
        let mut response = vec![0.0; TERMS];
        for (row, factor) in self.compliance.chunks_exact(TERMS).zip(&shape) {
            let sums = response.iter_mut().zip(row);
            sums.for_each(|(sum, value)| *sum += factor * value);
        }
        (shape, response)
    }
}

impl PlateShape {
    fn functions(&self, at: [f64; 2]) -> ShapeAt {
        let [[a, d], [b, c]] = self.corners;
        let [face, height] = at;
        let by_face = [0, 1].map(|k| (1.0 - height) * (b[k] - a[k]) + height * (c[k] - d[k]));
        let by_height = [0, 1].map(|k| (1.0 - face) * (d[k] - a[k]) + face * (c[k] - b[k]));
        let area = by_face[0] * by_height[1] - by_face[1] * by_height[0];
        let [along, up] = [face, height].map(|share| legendre(2.0 * share - 1.0));
        let mut here = ShapeAt {
            value: [0.0; TERMS],
            by_x: [0.0; TERMS],
            by_y: [0.0; TERMS],
            area,
            length: f64::hypot(by_face[0], by_face[1]),
        };
        for i in 0..TERMS {
            let (p, q) = (along[i / POLYNOMIALS[1]], up[i % POLYNOMIALS[1]]);
            let (over_face, over_height) = (2.0 * p.1 * q.0, 2.0 * p.0 * q.1);
            here.value[i] = p.0 * q.0;
            here.by_x[i] = (over_face * by_height[1] - over_height * by_face[1]) / area;
            here.by_y[i] = (over_height * by_face[0] - over_face * by_height[0]) / area;
        }
        here
    }
}

/// Legendre polynomials with their derivatives: `(n + 1) P_{n+1} = (2n + 1) x P_n − n P_{n−1}`, `P′_{n+1} = P′_{n−1} + (2n + 1) P_n`.
fn legendre(x: f64) -> [(f64, f64); POLYNOMIALS[0]] {
    let mut all = [(1.0, 0.0); POLYNOMIALS[0]];
    all[1] = (x, 1.0);
    for n in 1..POLYNOMIALS[0] - 1 {
        let (factor, (p, _)) = ((2 * n + 1) as f64, all[n]);
        let (before, slope) = all[n - 1];
        all[n + 1] = (
            (factor * x * p - n as f64 * before) / (n + 1) as f64,
            slope + factor * p,
        );
    }
    all
}

/// Adds the energy of bending and shear at a place.
fn bend(stiffness: &mut [f64], here: &ShapeAt, material: &Material, t: f64, weight: f64) {
    let nu = material.poisson;
    let rigidity = t.powi(3) / (12.0 * material.plane_strain_compliance()) * weight;
    let shear = SHEAR_FACTOR * material.shear_modulus() * t * weight;
    let (x, y, one) = (&here.by_x, &here.by_y, &here.value);
    let minus: [f64; TERMS] = one.map(|v| -v);
    // Curvatures θ_x,x and θ_y,y with their coupling, the twist θ_x,y + θ_y,x, both shears w,x − θ_x and w,y − θ_y.
    add(stiffness, &[(1, x)], &[(1, x)], rigidity);
    add(stiffness, &[(2, y)], &[(2, y)], rigidity);
    add(stiffness, &[(1, x)], &[(2, y)], nu * rigidity);
    add(stiffness, &[(2, y)], &[(1, x)], nu * rigidity);
    let twist = [(1, y), (2, x)];
    add(stiffness, &twist, &twist, 0.5 * (1.0 - nu) * rigidity);
    let along = [(0, x), (1, &minus)];
    add(stiffness, &along, &along, shear);
    let up = [(0, y), (2, &minus)];
    add(stiffness, &up, &up, shear);
}

/// Moment and shear of a unit length of the root line under its turn and shift: the inverse of its compliances.
fn root_stiffness(material: &Material, t: f64) -> [[f64; 2]; 2] {
    let nu = material.poisson;
    let coupling = (1.0 - 2.0 * nu) / (1.0 - nu) / t;
    let (turn, shift) = (ROOT_TURN / (t * t), ROOT_SHIFT);
    let factor = 1.0 / (material.plane_strain_compliance() * (turn * shift - coupling * coupling));
    [
        [factor * shift, -factor * coupling],
        [-factor * coupling, factor * turn],
    ]
}

/// Adds the energy of the root line at a place.
fn hold(stiffness: &mut [f64], here: &ShapeAt, material: &Material, t: f64, weight: f64) {
    let own = root_stiffness(material, t);
    for (i, row) in [2, 0].into_iter().zip(own) {
        for (j, entry) in [2, 0].into_iter().zip(row) {
            add(
                stiffness,
                &[(i, &here.value)],
                &[(j, &here.value)],
                weight * entry,
            );
        }
    }
}

/// Adds `factor a bᵀ` of two quantities, each a sum of fields with their functions.
fn add(
    stiffness: &mut [f64],
    a: &[(usize, &[f64; TERMS])],
    b: &[(usize, &[f64; TERMS])],
    factor: f64,
) {
    for (row_field, row) in a {
        for (i, value) in row.iter().enumerate() {
            for (field, column) in b {
                let from = (row_field * TERMS + i) * 3 * TERMS + field * TERMS;
                let entries = stiffness[from..from + TERMS].iter_mut();
                let scaled = factor * value;
                entries.zip(*column).for_each(|(k, c)| *k += scaled * c);
            }
        }
    }
}
