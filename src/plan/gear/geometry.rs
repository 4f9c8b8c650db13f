//! Geometry of a cylindrical pair as a list of quantities: first the drawing data of each gear, then the pair (ISO 21771-1:2024).

use std::f64::consts::PI;

use crate::gear::cylindrical::member::Member;
use crate::gear::cylindrical::pair::Pair;

/// One quantity of a pair.
#[derive(Debug, Clone, PartialEq)]
pub struct GearQuantity {
    /// Name of ISO 21771.
    pub name: &'static str,
    /// Symbol.
    pub symbol: &'static str,
    /// Unit of the values.
    pub unit: QuantityUnit,
    /// The values.
    pub value: QuantityValue,
}

/// Unit in which a quantity is shown, with its factor from SI.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum QuantityUnit {
    /// A number.
    One,
    /// mm.
    Millimetre,
    /// deg.
    Degree,
    /// 1/mm.
    PerMillimetre,
}

/// Values of a quantity, in its unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum QuantityValue {
    /// Values of pinion and gear; `None` where it does not exist.
    Each([Option<f64>; 2]),
    /// Value of the pair.
    Pair(f64),
}

impl QuantityUnit {
    /// The unit as text.
    pub fn text(self) -> &'static str {
        match self {
            QuantityUnit::One => "",
            QuantityUnit::Millimetre => "mm",
            QuantityUnit::Degree => "deg",
            QuantityUnit::PerMillimetre => "1/mm",
        }
    }

    fn of_si(self, value: f64) -> f64 {
        match self {
            QuantityUnit::One => value,
            QuantityUnit::Millimetre => 1e3 * value,
            QuantityUnit::Degree => value.to_degrees(),
            QuantityUnit::PerMillimetre => 1e-3 * value,
        }
    }
}

impl GearQuantity {
    /// Key in documents: the name in words with the unit, `base_diameter_mm`.
    pub fn key(&self) -> String {
        let words = self.name.split(|c: char| !c.is_alphanumeric());
        let name = words
            .filter(|w| !w.is_empty())
            .collect::<Vec<_>>()
            .join("_");
        match self.unit.text() {
            "" => name,
            "1/mm" => format!("{name}_per_mm"),
            unit => format!("{name}_{unit}"),
        }
    }
}

/// Collects quantities in SI.
#[derive(Default)]
pub(super) struct Quantities(pub(super) Vec<GearQuantity>);

impl Quantities {
    pub(super) fn each(
        &mut self,
        name: &'static str,
        symbol: &'static str,
        unit: QuantityUnit,
        values: [f64; 2],
    ) {
        let shown = |x: f64| x.is_finite().then(|| unit.of_si(x));
        let value = QuantityValue::Each(values.map(shown));
        self.0.push(GearQuantity {
            name,
            symbol,
            unit,
            value,
        });
    }

    pub(super) fn pair(
        &mut self,
        name: &'static str,
        symbol: &'static str,
        unit: QuantityUnit,
        value: f64,
    ) {
        let value = QuantityValue::Pair(unit.of_si(value));
        self.0.push(GearQuantity {
            name,
            symbol,
            unit,
            value,
        });
    }
}

/// The quantities of a pair.
pub fn quantities(pair: &Pair) -> Vec<GearQuantity> {
    use QuantityUnit::{Degree, Millimetre, One};
    let mut all = Quantities::default();
    let of = |value: fn(&Member) -> f64| [value(&pair.members[0]), value(&pair.members[1])];
    all.each("number of teeth", "z", One, of(|m| f64::from(m.gear.teeth)));
    all.each(
        "profile shift coefficient",
        "x",
        One,
        of(|m| m.gear.profile_shift),
    );
    all.each(
        "generating profile shift coefficient",
        "x_E",
        One,
        of(|m| m.generating_shift(m.mean_thickness_deviation())),
    );
    all.each(
        "tip alteration coefficient",
        "k",
        One,
        of(Member::tip_alteration),
    );
    all.each("face width", "b", Millimetre, of(|m| m.face_width));
    all.each(
        "reference diameter",
        "d",
        Millimetre,
        of(|m| m.gear.reference_diameter()),
    );
    all.each(
        "base diameter",
        "d_b",
        Millimetre,
        of(|m| m.gear.base_diameter()),
    );
    all.each("tip diameter", "d_a", Millimetre, of(Member::tip_diameter));
    all.each(
        "root diameter",
        "d_f",
        Millimetre,
        of(|m| m.root_diameter(m.gear.profile_shift)),
    );
    all.each(
        "generated root diameter",
        "d_fE",
        Millimetre,
        pair.outlines.map(|o| 2.0 * o.root_radius),
    );
    all.each(
        "root form diameter",
        "d_Ff",
        Millimetre,
        pair.outlines.map(|o| 2.0 * o.form_radius),
    );
    all.each(
        "normal tooth thickness",
        "s_n",
        Millimetre,
        of(|m| m.gear.nominal_thickness()),
    );
    all.each(
        "mean normal tooth thickness",
        "s_nm",
        Millimetre,
        of(Member::mean_thickness),
    );
    all.each(
        "transverse tip thickness",
        "s_at",
        Millimetre,
        pair.outlines
            .map(|o| o.thickness(o.tip_radius).unwrap_or(0.0)),
    );
    let gear = &pair.members[0].gear;
    let working = pair.working_diameters();
    all.pair("normal module", "m_n", Millimetre, gear.module);
    all.pair("normal pressure angle", "α_n", Degree, gear.pressure_angle);
    all.pair(
        "transverse pressure angle",
        "α_t",
        Degree,
        gear.transverse_pressure_angle(),
    );
    let angles =
        |radii: [f64; 2]| [0, 1].map(|k| pair.members[k].gear.pressure_angle_at(2.0 * radii[k]));
    let [tips, forms, roots] = [
        pair.outlines.map(|o| o.tip_radius),
        pair.outlines.map(|o| o.form_radius),
        pair.outlines.map(|o| o.root_radius),
    ];
    all.each("tip pressure angle", "α_at", Degree, angles(tips));
    all.each("root form pressure angle", "α_Fft", Degree, angles(forms));
    all.each("root pressure angle", "α_ft", Degree, angles(roots));
    all.pair("helix angle", "β", Degree, gear.helix.abs());
    all.pair("gear ratio", "u", One, pair.ratio());
    all.pair(
        "reference centre distance",
        "a_d",
        Millimetre,
        pair.reference_centre_distance(),
    );
    all.pair("centre distance", "a", Millimetre, pair.centre_distance);
    all.pair(
        "working pressure angle",
        "α_wt",
        Degree,
        pair.working_pressure_angle,
    );
    all.each("working pitch diameter", "d_w", Millimetre, working);
    all.each(
        "active tip diameter",
        "d_Na",
        Millimetre,
        pair.active_tip_diameters(),
    );
    all.each(
        "active root diameter",
        "d_Nf",
        Millimetre,
        pair.active_root_diameters(),
    );
    all.each(
        "bottom clearance",
        "c",
        Millimetre,
        pair.bottom_clearances(),
    );
    all.pair(
        "transverse base pitch",
        "p_bt",
        Millimetre,
        pair.base_pitch(),
    );
    all.pair(
        "transverse pitch",
        "p_t",
        Millimetre,
        PI * gear.reference_diameter() / f64::from(gear.teeth),
    );
    let ratios = pair.contact_ratios();
    all.pair("path of contact", "g_α", Millimetre, pair.path_length());
    all.pair("transverse contact ratio", "ε_α", One, ratios.transverse);
    all.pair("overlap ratio", "ε_β", One, ratios.overlap);
    all.pair("total contact ratio", "ε_γ", One, ratios.total);
    all.0
}
