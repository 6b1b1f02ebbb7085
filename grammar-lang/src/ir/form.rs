//! How grammars write shapes: the functions that make them, and what each makes of its lengths.

use std::collections::BTreeMap;

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use crate::shape::Shape;

/// A shape as a part has it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Kept", into = "Kept")]
pub struct Form {
    /// The shape about its own axes.
    pub shape: Shape,
    /// Whether its own x axis is the y axis of the part: it stands.
    pub stands: bool,
}

/// A function that makes shapes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Solid {
    /// Edge lengths along x, y and z.
    Box,
    /// Radius.
    Sphere,
    /// Radius, then length along x.
    Cylinder,
    /// Radius, then height along y.
    Disk,
    /// Radius, then length along x with both ends.
    Capsule,
}

impl Solid {
    /// What is written.
    #[must_use]
    pub fn usage(self) -> &'static str {
        match self {
            Self::Box => "box(x, y, z)",
            Self::Sphere => "sphere(radius)",
            Self::Cylinder => "cylinder(radius, length)",
            Self::Disk => "disk(radius, height)",
            Self::Capsule => "capsule(radius, length)",
        }
    }

    /// What it makes.
    #[must_use]
    pub fn doc(self) -> &'static str {
        match self {
            Self::Box => "box(x, y, z): a box with these edges.",
            Self::Sphere => "sphere(radius)",
            Self::Cylinder => "cylinder(radius, length), its axis along x.",
            Self::Disk => "disk(radius, height), its axis upright.",
            Self::Capsule => {
                "capsule(radius, length): a cylinder along x with hemispherical ends; its length includes these ends."
            }
        }
    }

    /// How a grammar writes it.
    #[must_use]
    pub fn text(self) -> &'static str {
        self.usage().split('(').next().unwrap_or_default()
    }

    /// How many lengths it takes.
    #[must_use]
    pub fn lengths(self) -> usize {
        self.usage().split(',').count()
    }

    /// The shape that lengths in m make.
    ///
    /// # Errors
    ///
    /// A sentence: they are not as many as it takes, or make no such shape.
    pub fn form(self, lengths: &[f64]) -> Result<Form, &'static str> {
        let (shape, stands) = match (self, lengths) {
            (Self::Box, &[x, y, z]) => (Shape::Box { half: Vector3::new(x, y, z) / 2.0 }, false),
            (Self::Sphere, &[radius]) => (Shape::Ball { radius }, false),
            (Self::Cylinder | Self::Disk, &[radius, length]) => {
                (Shape::Cylinder { radius, half_length: length / 2.0 }, self == Self::Disk)
            }
            (Self::Capsule, &[radius, length]) if length < 2.0 * radius => {
                return Err(
                    "a capsule is at least as long as it is wide: its length includes its round ends",
                );
            }
            (Self::Capsule, &[radius, length]) => {
                (Shape::Capsule { radius, half_straight: length / 2.0 - radius }, false)
            }
            _ => return Err("another number of lengths"),
        };
        Ok(Form { shape, stands })
    }
}

impl Form {
    /// The function that makes it, and the lengths that it takes, m.
    #[must_use]
    pub fn written(&self) -> (Solid, Vec<f64>) {
        match self.shape {
            Shape::Box { half } => (Solid::Box, (half * 2.0).iter().copied().collect()),
            Shape::Ball { radius } => (Solid::Sphere, vec![radius]),
            Shape::Cylinder { radius, half_length } => {
                (if self.stands { Solid::Disk } else { Solid::Cylinder }, vec![radius, 2.0 * half_length])
            }
            Shape::Capsule { radius, half_straight } => {
                (Solid::Capsule, vec![radius, 2.0 * (half_straight + radius)])
            }
        }
    }

    /// How far it reaches from its centre along the part's x, y and z, m.
    #[must_use]
    pub fn half_extents(&self) -> Vector3<f64> {
        let own = self.shape.half_extents();
        if self.stands { Vector3::new(own.y, own.x, own.z) } else { own }
    }
}

/// A shape in a file: its function with its lengths.
#[derive(Serialize, Deserialize)]
#[serde(transparent)]
struct Kept(BTreeMap<Solid, Lengths>);

#[derive(Serialize, Deserialize)]
#[serde(untagged)]
enum Lengths {
    One(f64),
    Several(Vec<f64>),
}

impl From<Form> for Kept {
    fn from(form: Form) -> Self {
        let (solid, lengths) = form.written();
        let lengths = match lengths.as_slice() {
            [one] => Lengths::One(*one),
            _ => Lengths::Several(lengths),
        };
        Self(BTreeMap::from([(solid, lengths)]))
    }
}

impl TryFrom<Kept> for Form {
    type Error = &'static str;

    fn try_from(Kept(kept): Kept) -> Result<Self, Self::Error> {
        let mut forms = kept.into_iter().map(|(solid, lengths)| match lengths {
            Lengths::One(one) => solid.form(&[one]),
            Lengths::Several(several) => solid.form(&several),
        });
        match (forms.next(), forms.next()) {
            (Some(form), None) => form,
            _ => Err("a shape is one function with its lengths"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ir::Function;

    #[test]
    fn a_shape_is_written_as_it_was_read() {
        let all = Function::ALL.iter().filter_map(|function| match function {
            Function::Solid(solid) => Some(*solid),
            _ => None,
        });
        for solid in all {
            assert_eq!(Function::named(solid.text()), Some(Function::Solid(solid)));
            let lengths: Vec<f64> = (0..solid.lengths()).map(|i| 0.25 * (2 * i + 1) as f64).collect();
            let form = solid.form(&lengths).unwrap();
            assert_eq!(form.written(), (solid, lengths));
            let kept = serde_json::to_string(&form).unwrap();
            assert_eq!(serde_json::from_str::<Form>(&kept).unwrap(), form, "{kept}");
        }
        let kept =
            |solid: Solid, lengths: &[f64]| serde_json::to_string(&solid.form(lengths).unwrap()).unwrap();
        assert_eq!(kept(Solid::Box, &[1.0, 2.0, 3.0]), r#"{"box":[1.0,2.0,3.0]}"#);
        assert_eq!(kept(Solid::Sphere, &[1.0]), r#"{"sphere":1.0}"#);
        assert_eq!(kept(Solid::Disk, &[1.0, 2.0]), r#"{"disk":[1.0,2.0]}"#);
        assert!(serde_json::from_str::<Form>(r#"{"box":[1.0]}"#).is_err());
    }
}
