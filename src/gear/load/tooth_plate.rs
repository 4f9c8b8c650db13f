//! Tooth as a shear-deformable plate on an elastic root line: `½∫ (D κᵀ(ν)κ + (5/6) G t γ²) dA + ½∫ qᵀ C⁻¹ q ds − F w`, Ritz with Legendre
//! polynomials.
//!
//! Deflection w and rotations θ_x, θ_y have nine polynomials along the face times seven over the height (Mindlin 1951). The root line
//! has rotation `E′ θ = 16.67/π M/t² + (1 − 2ν)/(1 − ν) V/t` and deflection `E′ w = (1 − 2ν)/(1 − ν) M/t + 1.534 V` for M and V per
//! unit width, E′ = E/(1 − ν²) (Weber and Banaschek 1953; O'Donnell, J. Eng. Ind. 82, 1960). This plate diverges under a point
//! load with the number of polynomials: the local deflection belongs to the half space, so the number is small.

use std::f64::consts::PI;

use super::material::Material;
use crate::base::error::Error;
use crate::numeric::profile_matrix::ProfileMatrix;
use crate::numeric::quadrature;

/// Number of polynomials along the face and over the height.
const POLYNOMIALS: [usize; 2] = [9, 7];
const TERMS: usize = POLYNOMIALS[0] * POLYNOMIALS[1];
/// Shear correction factor of the plate.
const SHEAR_FACTOR: f64 = 5.0 / 6.0;
/// Compliance coefficients of the root line under moment and shear in plane strain.
const ROOT_ROTATION: f64 = 16.67 / PI;
const ROOT_DEFLECTION: f64 = 1.534;

/// Middle plane of a tooth with its elastic constants.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlateShape {
    /// `[x, y]` of the corners by `[toe, heel]`, each by `[root, tip]`, m: x along the tooth, y from the root up.
    pub corners: [[[f64; 2]; 2]; 2],
    /// Elastic constants.
    pub material: Material,
}

/// Bending compliance of a tooth plate.
#[derive(Debug, Clone, PartialEq)]
pub struct ToothPlate {
    /// Compliance matrix of the deflection coefficients, row by row, m/N.
    compliance: Vec<f64>,
    /// Quadrature points of the root line: length, m, and moment per unit length for a unit load of each coefficient, N.
    root: Vec<(f64, Vec<f64>)>,
}

/// Bending moment in the root line of a tooth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RootMoment {
    /// Total moment over the root line, N·m.
    pub total: f64,
    /// Largest moment per unit length, N.
    pub greatest: f64,
}

/// Shape functions with their derivatives over x and y at a point of the plate.
struct Shapes {
    value: [f64; TERMS],
    by_x: [f64; TERMS],
    by_y: [f64; TERMS],
    /// Jacobian: area per unit of both shares, m².
    area: f64,
    /// Length of the root line per unit of the face share, m.
    length: f64,
}

impl ToothPlate {
    /// Tooth plate with a thickness, m, over the shares of face and height.
    ///
    /// # Errors
    /// `IllPosed`: corners out of order, or a thickness that is not positive.
    pub fn new(
        shape: &PlateShape,
        thickness: impl Fn([f64; 2]) -> f64,
    ) -> Result<ToothPlate, Error> {
        const N: usize = 3 * TERMS;
        let mut stiffness = vec![0.0; N * N];
        let share = |x: f64| 0.5 * (x + 1.0);
        for (x, weight_x) in quadrature::nodes() {
            for (y, weight_y) in quadrature::nodes() {
                let shares = [share(x), share(y)];
                let basis = shape.functions(shares);
                let weight = 0.25 * weight_x * weight_y * basis.area;
                add_plate(
                    &mut stiffness,
                    &basis,
                    &shape.material,
                    thickness(shares),
                    weight,
                );
            }
            let shares = [share(x), 0.0];
            let basis = shape.functions(shares);
            add_root(
                &mut stiffness,
                &basis,
                &shape.material,
                thickness(shares),
                0.5 * weight_x * basis.length,
            );
        }
        let unknowns: Vec<usize> = (0..N).collect();
        let factor = ProfileMatrix::from_rows(&stiffness, N).cholesky(&unknowns)?;
        let mut compliance = vec![0.0; TERMS * TERMS];
        let mut column = vec![0.0; N];
        let points = quadrature::nodes().map(|(x, weight)| {
            let shares = [share(x), 0.0];
            (shape.functions(shares), thickness(shares), 0.5 * weight)
        });
        let points: Vec<(Shapes, f64, f64)> = points.collect();
        let mut root: Vec<(f64, Vec<f64>)> = (points.iter())
            .map(|(basis, _, weight)| (weight * basis.length, vec![0.0; TERMS]))
            .collect();
        for j in 0..TERMS {
            column.fill(0.0);
            column[j] = 1.0;
            factor.solve(&mut column);
            (0..TERMS).for_each(|i| compliance[i * TERMS + j] = column[i]);
            for ((basis, t, _), (_, moment)) in points.iter().zip(&mut root) {
                let field = |k: usize| -> f64 {
                    let coefficients = column[k * TERMS..(k + 1) * TERMS].iter();
                    coefficients.zip(&basis.value).map(|(a, b)| a * b).sum()
                };
                let [[by_rotation, by_deflection], _] = root_stiffness(&shape.material, *t);
                moment[j] = by_rotation * field(2) + by_deflection * field(0);
            }
        }
        Ok(ToothPlate { compliance, root })
    }

    /// Bending moment in the root line under a load in terms of the shape functions, N.
    pub fn root_moment(&self, loading: &[f64]) -> RootMoment {
        let mut moment = RootMoment {
            total: 0.0,
            greatest: 0.0,
        };
        for (length, unit) in &self.root {
            let value: f64 = unit.iter().zip(loading).map(|(a, b)| a * b).sum();
            moment.total += length * value;
            moment.greatest = moment.greatest.max(value);
        }
        moment
    }

    /// Shape functions at shares of face and height for a force of a given cosine to the plate normal, and the deflection coefficients
    /// for a unit force, m/N.
    pub fn load(&self, shares: [f64; 2], cosine: f64) -> (Vec<f64>, Vec<f64>) {
        let [along, up] = [0, 1].map(|k| legendre(2.0 * shares[k] - 1.0));
        let value = |i: usize| cosine * along[i / POLYNOMIALS[1]].0 * up[i % POLYNOMIALS[1]].0;
        let shape: Vec<f64> = (0..TERMS).map(value).collect();
        // Row by row of the symmetric matrix: terms of a row are independent.
        let mut response = vec![0.0; TERMS];
        for (row, factor) in self.compliance.chunks_exact(TERMS).zip(&shape) {
            let sums = response.iter_mut().zip(row);
            sums.for_each(|(sum, value)| *sum += factor * value);
        }
        (shape, response)
    }
}

impl PlateShape {
    fn functions(&self, shares: [f64; 2]) -> Shapes {
        let [[a, d], [b, c]] = self.corners;
        let [face, height] = shares;
        let by_face = [0, 1].map(|k| (1.0 - height) * (b[k] - a[k]) + height * (c[k] - d[k]));
        let by_height = [0, 1].map(|k| (1.0 - face) * (d[k] - a[k]) + face * (c[k] - b[k]));
        let area = by_face[0] * by_height[1] - by_face[1] * by_height[0];
        let [along, up] = [face, height].map(|share| legendre(2.0 * share - 1.0));
        let mut values = Shapes {
            value: [0.0; TERMS],
            by_x: [0.0; TERMS],
            by_y: [0.0; TERMS],
            area,
            length: f64::hypot(by_face[0], by_face[1]),
        };
        for i in 0..TERMS {
            let (p, q) = (along[i / POLYNOMIALS[1]], up[i % POLYNOMIALS[1]]);
            let (over_face, over_height) = (2.0 * p.1 * q.0, 2.0 * p.0 * q.1);
            values.value[i] = p.0 * q.0;
            values.by_x[i] = (over_face * by_height[1] - over_height * by_face[1]) / area;
            values.by_y[i] = (over_height * by_face[0] - over_face * by_height[0]) / area;
        }
        values
    }
}

/// Legendre polynomials with derivatives: `(n + 1) P_{n+1} = (2n + 1) x P_n − n P_{n−1}`, `P′_{n+1} = P′_{n−1} + (2n + 1) P_n`.
fn legendre(x: f64) -> [(f64, f64); POLYNOMIALS[0]] {
    let mut p_n = [(1.0, 0.0); POLYNOMIALS[0]];
    p_n[1] = (x, 1.0);
    for n in 1..POLYNOMIALS[0] - 1 {
        let (factor, (p, _)) = ((2 * n + 1) as f64, p_n[n]);
        let (before, slope) = p_n[n - 1];
        p_n[n + 1] = (
            (factor * x * p - n as f64 * before) / (n + 1) as f64,
            slope + factor * p,
        );
    }
    p_n
}

/// Adds the stiffness of bending and shear at a quadrature point.
fn add_plate(stiffness: &mut [f64], basis: &Shapes, material: &Material, t: f64, weight: f64) {
    let nu = material.poisson;
    let rigidity = t.powi(3) / (12.0 * material.plane_strain_compliance()) * weight;
    let shear = SHEAR_FACTOR * material.shear_modulus() * t * weight;
    let (x, y, one) = (&basis.by_x, &basis.by_y, &basis.value);
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

/// Root-line stiffness per unit length, moment and shear over rotation and deflection: the inverse compliance matrix.
fn root_stiffness(material: &Material, t: f64) -> [[f64; 2]; 2] {
    let nu = material.poisson;
    let coupling = (1.0 - 2.0 * nu) / (1.0 - nu) / t;
    let (by_m, by_v) = (ROOT_ROTATION / (t * t), ROOT_DEFLECTION);
    let factor = 1.0 / (material.plane_strain_compliance() * (by_m * by_v - coupling * coupling));
    [
        [factor * by_v, -factor * coupling],
        [-factor * coupling, factor * by_m],
    ]
}

/// Adds the stiffness of the root line at a quadrature point.
fn add_root(stiffness: &mut [f64], basis: &Shapes, material: &Material, t: f64, weight: f64) {
    let root = root_stiffness(material, t);
    for (i, row) in [2, 0].into_iter().zip(root) {
        for (j, entry) in [2, 0].into_iter().zip(row) {
            add(
                stiffness,
                &[(i, &basis.value)],
                &[(j, &basis.value)],
                weight * entry,
            );
        }
    }
}

/// Adds the stiffness terms `factor a bᵀ` of two linear forms, each a sum of fields with their functions.
fn add(
    stiffness: &mut [f64],
    a: &[(usize, &[f64; TERMS])],
    b: &[(usize, &[f64; TERMS])],
    factor: f64,
) {
    for (row_field, row) in a {
        for (i, value) in row.iter().enumerate() {
            for (field, column) in b {
                let start = (row_field * TERMS + i) * 3 * TERMS + field * TERMS;
                let entries = stiffness[start..start + TERMS].iter_mut();
                let scaled = factor * value;
                entries.zip(*column).for_each(|(k, c)| *k += scaled * c);
            }
        }
    }
}
