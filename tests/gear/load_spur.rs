//! Spur teeth as plates on the solver of contact lines, against the theory of Weber and Banaschek, c′ of ISO 6336-1 and the energy method.

use geardyn::internals::gear::cylindrical::pair::Pair;
use geardyn::internals::gear::load::body::{Body, FootLoad};
use geardyn::internals::gear::load::compliance::{StiffnessMethod, compare_methods};
use geardyn::internals::gear::load::contact_line::{ContactCell, ContactLine, ToothLoad};
use geardyn::internals::gear::load::hertz::{ContactModel, FlankContact};
use geardyn::internals::gear::load::iso6336::IsoStiffness;
use geardyn::internals::gear::load::loaded_lines::LoadedLines;
use geardyn::internals::gear::load::material::Material;
use geardyn::internals::gear::load::tooth::ToothSection;
use geardyn::internals::gear::load::tooth_plate::{PlateShape, ToothPlate};

use crate::load_mesh::pair;
use crate::load_space::STEEL;
use crate::verification::within;

/// Line load, N/m, of the module 3 mm: 300 N/mm of the module 10 mm.
const LINE_LOAD: f64 = 90e3;
/// Face width, m: eighty modules, since ends soften a narrow face.
const WIDTH: f64 = 0.24;
const CELLS: usize = 40;

/// A tooth of a pair, loaded where its flank touches at the pitch point.
struct Tooth {
    section: ToothSection,
    foot: FootLoad,
    roll: f64,
    /// `[half thickness, height above the root circle]` from the root to the tip, m.
    flank: Vec<[f64; 2]>,
}

impl Tooth {
    fn new(pair: &Pair, k: usize) -> Tooth {
        let outline = &pair.outlines[k];
        let section = ToothSection::new(outline, STEEL[0]).unwrap();
        let roll = pair.path_points().c.roll[k];
        let flank = outline.flank(2000, 4000);
        let above_root = |[x, y]: [f64; 2]| [x, y - outline.root_radius];
        Tooth {
            foot: section.foot_load(roll),
            section,
            roll,
            flank: flank.into_iter().map(above_root).collect(),
        }
    }

    fn thickness(&self, height: f64) -> f64 {
        let after = self.flank.partition_point(|p| p[1] < height);
        let i = after.clamp(1, self.flank.len() - 1);
        let [a, b] = [self.flank[i - 1], self.flank[i]];
        let share = ((height - a[1]) / (b[1] - a[1])).clamp(0.0, 1.0);
        2.0 * (a[0] + share * (b[0] - a[0]))
    }

    fn depth(&self) -> f64 {
        self.section.depth(self.roll)
    }

    /// The load on the plate of this tooth at a share of the face.
    fn on_plate(&self) -> impl Fn(f64) -> ToothLoad {
        let top = self.flank[self.flank.len() - 1][1];
        let shape = PlateShape {
            corners: [0.0, WIDTH].map(|x| [[x, 0.0], [x, top]]),
            material: STEEL[0],
        };
        let plate = ToothPlate::new(&shape, |[_, up]| self.thickness(up * top)).unwrap();
        let (height, cosine, depth) = (self.foot.height / top, self.foot.angle.cos(), self.depth());
        move |face| {
            let (shape, response) = plate.load([face, height], cosine);
            ToothLoad {
                depth,
                shape,
                response,
            }
        }
    }

    /// `cos²β [∫ (u − y)²/D dy + 1.2/G ∫ dy/t]` up to a height, for a unit line load at the height u of the force's line, with
    /// `D = E t³/12/rigidity`.
    fn beam(&self, to: f64, rigidity: f64) -> f64 {
        let (u, cosine) = (self.foot.height, self.foot.angle.cos());
        let Material { young, .. } = STEEL[0];
        let shear = 1.2 / STEEL[0].shear_modulus();
        let pieces = self.flank.windows(2).filter(|w| w[0][1] < to);
        let sum: f64 = pieces
            .map(|w| {
                let end = w[1][1].min(to);
                let (middle, step) = (0.5 * (w[0][1] + end), end - w[0][1]);
                let t = w[0][0] + w[1][0];
                step * (12.0 * rigidity * (u - middle).powi(2) / (young * t.powi(3)) + shear / t)
            })
            .sum();
        cosine * cosine * sum
    }

    /// Half plane under the tooth without the part of the force along the height.
    fn body(&self) -> f64 {
        let upright = FootLoad {
            angle: 0.0,
            ..self.foot
        };
        self.foot.angle.cos().powi(2) * Body::HalfPlane.compliance(&upright, &STEEL[0])
    }
}

/// Stiffness of one pair at the pitch point through the solver of contact lines, Pa.
fn as_plates(pair: &Pair, teeth: &[Tooth; 2]) -> f64 {
    let loads = teeth.each_ref().map(Tooth::on_plate);
    let roll = pair.path_points().c.roll;
    let cell = |i: usize| {
        let face = (i as f64 + 0.5) / CELLS as f64;
        ContactCell {
            along: face * WIDTH,
            length: WIDTH / CELLS as f64,
            gap: 0.0,
            arm: 1.0,
            curvature: roll[0].recip() + roll[1].recip(),
            on_edge: false,
            ellipse: None,
            teeth: Some([loads[0](face), loads[1](face)]),
        }
    };
    let line = ContactLine {
        pair: 0,
        cells: (0..CELLS).map(cell).collect(),
    };
    let lines = LoadedLines::new(vec![line], STEEL);
    LINE_LOAD / lines.solve(LINE_LOAD * WIDTH, None).unwrap().turn
}

/// Flattening of both flanks by Weber and Banaschek, m²/N.
fn contact(pair: &Pair, teeth: &[Tooth; 2]) -> f64 {
    let roll = pair.path_points().c.roll;
    let flanks = FlankContact {
        radius: (roll[0].recip() + roll[1].recip()).recip(),
        depths: teeth.each_ref().map(Tooth::depth),
    };
    let model = ContactModel::Logarithmic {
        line_load: LINE_LOAD,
    };
    model.compliance(&flanks, &STEEL)
}

const TEETH: [[u32; 2]; 4] = [[24, 95], [30, 30], [62, 62], [20, 60]];

/// Plates on the solver of contact lines are wide beams up to the line of the force on a half plane, with the flattening between them.
/// Source: Weber and Banaschek, Schriftenreihe Antriebstechnik 11, 1953: `10.92 ∫ (u − y)²/t³ + 3.1 ∫ 1/t + 5.2 (u/S)² + u/S + 1.4`, summed
/// over the outline.
#[test]
fn ref_plates_are_the_theory_of_weber_and_banaschek() {
    for teeth in TEETH {
        let pair = pair(teeth, 0.0, [0.0; 2]);
        let both = [0, 1].map(|k| Tooth::new(&pair, k));
        let tooth = |t: &Tooth| t.beam(t.foot.height, 0.91) + t.body();
        let theory = (tooth(&both[0]) + tooth(&both[1]) + contact(&pair, &both)).recip();
        let ratio = as_plates(&pair, &both) / theory;
        println!("{teeth:?}: {ratio:.4}");
        within("stiffness of a pair", (ratio - 1.0).abs(), 0.01);
    }
}

/// Plates and c′ of ISO 6336-1: the theoretical c′_th C_B within 4 %, and c′ = 0.8 c′_th C_B below them by C_M, which is measured, not elastic.
/// Source: ISO 6336-1:2006, eqs. 82 to 84.
#[test]
fn ref_spur_pairs_as_plates_reach_the_theoretical_stiffness() {
    for teeth in TEETH {
        let pair = pair(teeth, 0.0, [0.0; 2]);
        let both = [0, 1].map(|k| Tooth::new(&pair, k));
        let iso = IsoStiffness::new(&pair, &STEEL, [None; 2]);
        let found = as_plates(&pair, &both);
        let theory = found / (iso.theoretical * iso.rack_factor) - 1.0;
        println!(
            "{teeth:?}: {:.2} N/(mm µm), {:+.1} % of c′_th C_B, {:+.1} % of c′",
            1e-9 * found,
            100.0 * theory,
            100.0 * (found / iso.single - 1.0)
        );
        within("theoretical stiffness", theory.abs(), 0.04);
        assert!((0.19..0.26).contains(&(found / iso.single - 1.0)));
    }
}

/// The energy method on the same half plane differs from the plates by narrow beams, the beam from the force's line up to the contact and
/// compression along the height: with these the same sums over the outline give it to 1e-6.
#[test]
fn law_energy_method_beside_plates() {
    for teeth in TEETH {
        let pair = pair(teeth, 0.0, [0.0; 2]);
        let both = [0, 1].map(|k| Tooth::new(&pair, k));
        let contact_model = ContactModel::Logarithmic {
            line_load: LINE_LOAD,
        };
        let method = StiffnessMethod::Energy {
            bodies: [Body::HalfPlane; 2],
            contact: contact_model,
        };
        let energy = compare_methods(&pair, &[method], &STEEL).unwrap()[0].at_pitch_point;
        let tooth = |t: &Tooth| {
            // The contact lies a depth up the force's line from the middle.
            let height = t.foot.height + t.depth() * t.foot.angle.sin();
            let compression = t.section.compliance(t.roll).axial;
            t.beam(height, 1.0) + compression + Body::HalfPlane.compliance(&t.foot, &STEEL[0])
        };
        let sums = (tooth(&both[0]) + tooth(&both[1]) + contact(&pair, &both)).recip();
        within("stiffness of a pair", (energy / sums - 1.0).abs(), 1e-6);
        let plates = as_plates(&pair, &both) / energy;
        println!("{teeth:?}: plates {plates:.4} of the energy method");
        assert!((1.07..1.12).contains(&plates));
    }
}
