//! Kinds of physical quantity: dimension, SI unit and the units accepted in files.

/// Powers of metre, kilogram, second and radian.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Dimension(pub [i8; 4]);

impl Dimension {
    /// A bare number.
    pub const DIMENSIONLESS: Dimension = Dimension([0; 4]);

    /// This times `other` to the power `power`; absent where a power leaves the range of sense.
    pub fn times(self, other: Dimension, power: i8) -> Option<Dimension> {
        let mut product = self.0;
        for (a, b) in product.iter_mut().zip(other.0) {
            *a = a.checked_add(b.checked_mul(power)?)?;
        }
        Some(Dimension(product))
    }

    /// The same with the angle counted as a number.
    pub fn without_angle(self) -> Dimension {
        let [m, kg, s, _] = self.0;
        Dimension([m, kg, s, 0])
    }
}

/// Declares every kind once: its name for users, its powers of m, kg, s and rad, whether the radian may be left out,
/// and the units named in messages, the SI unit first.
macro_rules! kinds {
    ($($kind:ident $name:literal [$m:literal $kg:literal $s:literal $rad:literal] $drops:literal $units:literal)*) => {
        /// Kind of a physical quantity.
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub enum QuantityKind { $(#[doc = concat!("A ", $name, ", such as in ", $units, ".")] $kind,)* }

        impl QuantityKind {
            /// Every kind, in the order of this table.
            pub const ALL: &'static [QuantityKind] = &[$(QuantityKind::$kind,)*];

            /// Name of the kind.
            pub fn name(self) -> &'static str {
                match self { $(QuantityKind::$kind => $name,)* }
            }

            /// Dimension: powers of metre, kilogram, second and radian.
            pub fn dimension(self) -> Dimension {
                match self { $(QuantityKind::$kind => Dimension([$m, $kg, $s, $rad]),)* }
            }

            /// The radian may be left out of its unit: N·m is taken as N·m/rad.
            pub fn angle_is_optional(self) -> bool {
                match self { $(QuantityKind::$kind => $drops,)* }
            }

            /// Units it is commonly written in, the SI unit first.
            pub fn units(self) -> &'static str {
                match self { $(QuantityKind::$kind => $units,)* }
            }
        }
    };
}

kinds! {
    Mass "mass" [0 1 0 0] false "kg, g, t"
    Inertia "moment of inertia" [2 1 0 0] false "kg·m², kg·cm², g·mm²"
    Density "density" [-3 1 0 0] false "kg/m³, g/cm³"
    Length "length" [1 0 0 0] false "m, mm, µm, in"
    Angle "angle" [0 0 0 1] false "rad, deg, arcmin, arcsec"
    Time "time" [0 0 1 0] false "s, ms, min"
    Speed "speed of rotation" [0 0 -1 1] false "rad/s, rpm, Hz"
    Frequency "frequency" [0 0 -1 1] false "Hz, kHz, rad/s"
    PerSecond "rate" [0 0 -1 0] false "1/s, 1/ms"
    Force "force" [1 1 -2 0] false "N, kN, lbf"
    Torque "torque" [2 1 -2 0] false "N·m, kN·m, lbf·ft"
    Pressure "pressure" [-1 1 -2 0] false "Pa, GPa, N/mm²"
    Stiffness "translational stiffness" [0 1 -2 0] false "N/m, N/µm, kN/mm"
    Damping "translational damping" [0 1 -1 0] false "N·s/m, N·s/mm"
    TorsionalStiffness "torsional stiffness" [2 1 -2 -1] true "N·m/rad, kN·m/rad, N·m/deg"
    TorsionalDamping "torsional damping" [2 1 -1 -1] true "N·m·s/rad, kN·m·s/rad"
    ForcePerAngle "force per angle" [1 1 -2 -1] true "N/rad, kN/rad, N/deg"
    ForceRatePerAngle "force per speed of rotation" [1 1 -1 -1] true "N·s/rad, N·s/deg"
    TorquePerLength "torque per displacement" [1 1 -2 0] false "N·m/m, N"
    TorqueRatePerLength "torque per velocity" [1 1 -1 0] false "N·m·s/m, N·s"
}

impl QuantityKind {
    /// The SI unit a bare number has where a file says `units = "SI"`.
    pub fn si_unit(self) -> &'static str {
        self.units().split(',').next().unwrap_or_default()
    }

    /// The unit a bare number has on the command line.
    pub fn bare_unit(self) -> &'static str {
        match self {
            QuantityKind::Speed => "rpm",
            QuantityKind::Length => "mm",
            QuantityKind::Angle => "deg",
            _ => self.si_unit(),
        }
    }

    /// Kind of quantity with exactly this dimension, if any.
    pub fn from_dimension(dimension: Dimension) -> Option<QuantityKind> {
        QuantityKind::ALL
            .iter()
            .copied()
            .find(|kind| kind.dimension() == dimension)
    }

    /// A unit of dimension `given` can state this kind.
    pub fn accepts(self, given: Dimension) -> bool {
        let own = self.dimension();
        given == own || (self.angle_is_optional() && given == own.without_angle())
    }
}
