//! The meshes of the helical planetary gear: how far its teeth are pressed together, in the detail
//! that is asked for, and how stiff they are over the mesh period. The formulas stand in
//! `helical_motion`.

/// Detail of the motion that a model includes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Detail {
    /// Rotations alone, as with rigid bearings (equation 28).
    Torsional,
    /// Bearings, pressure angles as at rest.
    ConstantAngle,
    /// Bearings, pressure angles as the paper prints them.
    PrintedAngle,
    /// Bearings, compressions of involutes at their actual centres.
    ExactAngle,
}

impl Detail {
    /// All, in the order of their detail.
    pub const ALL: [Detail; 4] = [
        Detail::Torsional,
        Detail::ConstantAngle,
        Detail::PrintedAngle,
        Detail::ExactAngle,
    ];

    pub fn name(self) -> &'static str {
        match self {
            Detail::Torsional => "torsional",
            Detail::ConstantAngle => "constant angle",
            Detail::PrintedAngle => "varying angle as printed",
            Detail::ExactAngle => "varying angle, exact",
        }
    }
}

/// Compression of a mesh by the centres of its gears, its gradient, and the pressure angle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Approach {
    pub compression: f64,
    pub by_u: f64,
    pub by_v: f64,
    pub angle: f64,
}

/// One kind of mesh.
#[derive(Clone, Copy, Debug)]
pub(super) struct MeshGeometry {
    /// 1 for the sun, -1 for the ring.
    pub side: f64,
    /// Sum of the base radii of sun and planet, or difference of those of ring and planet.
    pub base: f64,
    pub pins: f64,
    rest: RestAngle,
}

/// The pressure angle at rest with its functions: a rate needs them a million times.
#[derive(Clone, Copy, Debug)]
struct RestAngle {
    angle: f64,
    sin: f64,
    cos: f64,
    tan: f64,
}

impl RestAngle {
    fn new(angle: f64) -> Self {
        let (sin, cos) = angle.sin_cos();
        let tan = angle.tan();
        Self {
            angle,
            sin,
            cos,
            tan,
        }
    }
}

impl MeshGeometry {
    pub fn new(side: f64, base: f64, rest_angle: f64, pins: f64) -> Self {
        Self {
            side,
            base,
            pins,
            rest: RestAngle::new(rest_angle),
        }
    }

    /// Pressure angle at rest, rad.
    pub fn rest_angle(&self) -> f64 {
        self.rest.angle
    }

    pub fn set_rest_angle(&mut self, angle: f64) {
        self.rest = RestAngle::new(angle);
    }

    pub fn approach(&self, detail: Detail, u: f64, v: f64) -> Approach {
        let Self {
            side,
            base,
            pins,
            rest,
        } = *self;
        if matches!(detail, Detail::Torsional | Detail::ConstantAngle) {
            let RestAngle { sin, cos, .. } = rest;
            return Approach {
                compression: -side * (u - pins) * sin - v * cos,
                by_u: -side * sin,
                by_v: -cos,
                angle: rest.angle,
            };
        }
        let square = u * u + v * v;
        let distance = square.sqrt();
        let angle = (base / distance).acos();
        let tan = angle.tan();
        let turn = v.atan2(u);
        if detail == Detail::ExactAngle {
            let (involute, involute_at_rest) = (tan - angle, rest.tan - rest.angle);
            return Approach {
                compression: -base * (turn + side * (involute - involute_at_rest)),
                by_u: -base * (side * tan * u - v) / square,
                by_v: -base * (side * tan * v + u) / square,
                angle,
            };
        }
        let (sin, cos) = (angle - side * turn).sin_cos();
        let by_angle = v * sin - side * (u - pins) * cos;
        Approach {
            compression: -side * (u - pins) * sin - v * cos,
            by_u: -side * sin + by_angle * (u / tan + side * v) / square,
            by_v: -cos + by_angle * (v / tan - side * u) / square,
            angle,
        }
    }
}

/// Trapezoid over the mesh period: the stiffness of a mesh.
#[derive(Clone, Copy, Debug)]
pub(super) struct Wave {
    pub least: f64,
    pub most: f64,
    pub edge: f64,
    /// Part of the period with more pairs in contact, mean of the flanks.
    pub share: f64,
}

impl Wave {
    pub fn at(&self, periods: f64) -> f64 {
        let place = periods - periods.floor();
        let up = (place / self.edge).min(1.0);
        let down = ((self.share + self.edge - place) / self.edge).clamp(0.0, 1.0);
        self.least + (self.most - self.least) * up.min(down)
    }
}

/// Compression, stiffness and pressure angle of one mesh.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct MeshState {
    pub compression_m: f64,
    pub stiffness_n_per_m: f64,
    pub angle_rad: f64,
}
