//! Checks what actuators say about how they are made: their material, and the chamber or the thread that bends them.

use super::Declarations;
use super::fields::{Fields, Sign, Values};
use crate::diagnostics::{Code, Diagnostic};
use crate::eval::Value;
use crate::ir::{self, BentBy, Chamber, Construction, Field, Form, Hole, Material, Thread, Ty};
use crate::shape::Shape;
use crate::source::Span;
use crate::syntax::ast;
use crate::types::expressions::context::Context;
use crate::types::expressions::fit::article;
use crate::units::{self, Dimension};

/// Fields of an actuator that bends; the last two are blocks.
pub(super) const FIELDS: [&str; 3] = ["material", "chamber", "thread"];
pub(super) const BLOCKS: [&str; 2] = ["chamber", "thread"];

/// The fields of a material.
const MATERIAL: [(&str, Dimension); 4] = [
    ("young", Dimension::PRESSURE),
    ("poisson", Dimension::NUMBER),
    ("density", Dimension::DENSITY),
    ("loss", Dimension::NUMBER),
];
const EXAMPLE: &str = "material = dragon_skin_30";
const CHAMBER: Fields<'static> =
    Fields::values(&["width", "height", "radius", "offset", "pressure", "winding", "sheet"]);
const THREAD: Fields<'static> = Fields::values(&["offset", "pull"]);

/// Rubber has 0.499 and more; how far a chamber bends an actuator then no longer changes.
const MOST_POISSON: f64 = 0.4995;
/// A wall is at least this share of the height of a section: what is thinner cannot be computed.
const THINNEST: f64 = 0.02;

/// Half of a section's width and height, and whether it is round, m.
#[derive(Clone, Copy)]
struct RowSection {
    half: [f64; 2],
    is_round: bool,
}

impl Declarations<'_> {
    /// How an actuator is made, as far as it says. What is wrong is reported, and left out: only `sgc fit` reads it.
    pub(super) fn construction(
        &mut self,
        from: &Values<'_>,
        (segment, axis): (Option<&Field<Form>>, &Field<[f64; 3]>),
        cx: &Context,
    ) -> Option<Construction> {
        let group = |name: &str| from.groups.get(name).copied();
        let (chamber, thread) = (group("chamber"), group("thread"));
        let Some((name, tree)) = from.values.get("material") else {
            if let Some(drive) = chamber.or(thread) {
                let message = format!("an actuator with a `{}` needs a `material`", drive.name.text);
                self.report(
                    Diagnostic::new(Code::MISSING_FIELD, drive.name.span, message)
                        .label("says what bends it, but nothing says what it is made of")
                        .help(format!("add a line such as `{EXAMPLE}`")),
                );
            }
            return None;
        };
        if let (Some(chamber), Some(thread)) = (chamber, thread) {
            self.report(
                Diagnostic::new(
                    Code::DUPLICATE,
                    thread.name.span,
                    "an actuator has a chamber or a thread, not both",
                )
                .label("a second drive")
                .also(chamber.name.span, "the first drive")
                .help("keep the one that bends it"),
            );
        }
        let section = self.section(name.span, segment, axis);
        let material = self.material(tree, cx);
        let drive = if let Some(block) = chamber {
            let values = self.values(block, "a chamber", CHAMBER);
            Some(self.chamber(&values, section?, cx).map(BentBy::Chamber))
        } else if let Some(block) = thread {
            let values = self.values(block, "a thread", THREAD);
            Some(self.thread(&values, section?, cx).map(BentBy::Thread))
        } else {
            None
        };
        section?;
        Some(Construction {
            material: material?,
            bent_by: drive.map_or(Some(None), |drive| drive.map(Some))?,
        })
    }

    /// The section of a row, if elements can stand for it.
    fn section(
        &mut self,
        place: Span,
        segment: Option<&Field<Form>>,
        axis: &Field<[f64; 3]>,
    ) -> Option<RowSection> {
        let (message, help) = match segment? {
            Field::Fixed(Form { shape: Shape::Cylinder { radius, .. }, .. }) => {
                return Some(RowSection { half: [*radius; 2], is_round: true });
            }
            Field::Fixed(Form { shape: Shape::Box { half }, .. }) => {
                if let Some([width, height]) = ir::across(axis, [half.x, half.y, half.z]) {
                    return Some(RowSection { half: [width, height], is_round: false });
                }
                (
                    "of boxes that bend askew",
                    "let the joint bend about z or about y, or write the segment as a cylinder, or leave `material` out",
                )
            }
            Field::Fixed(_) => (
                "of other shapes than boxes and cylinders",
                "write the segment as a box or a cylinder, or leave `material` out",
            ),
            Field::Varies(_) => (
                "whose segments differ from part to part",
                "give `segment` one size, or leave `material` out",
            ),
        };
        self.report(
            Diagnostic::new(
                Code::OUT_OF_DOMAIN,
                place,
                format!("a material cannot be fitted to actuators {message}"),
            )
            .label("`sgc fit` cannot read it")
            .help(help),
        );
        None
    }

    /// A record with the fields that a material has; it may have others.
    fn material(&mut self, tree: &ast::Expr, cx: &Context) -> Option<Material> {
        let expr = self.expressions.infer(tree, &mut cx.clone());
        if expr.ty == Ty::Unknown {
            return None;
        }
        let Ty::Record(_, fields) = expr.ty.clone() else {
            self.report(
                Diagnostic::new(Code::WRONG_TYPE, tree.span, "`material` must be a record of a material")
                    .label(format!("this is {}", article(&expr.ty)))
                    .help(format!("write for example `{EXAMPLE}`")),
            );
            return None;
        };
        let place = |(name, dimension): &(&str, Dimension)| {
            fields.iter().position(|(field, ty)| field == name && *ty == Ty::Quantity(*dimension))
        };
        let places: Vec<Option<usize>> = MATERIAL.iter().map(place).collect();
        if let Some((lacking, dimension)) =
            places.iter().zip(MATERIAL).find(|(place, _)| place.is_none()).map(|(_, field)| field)
        {
            let ty = Ty::Quantity(dimension);
            self.report(
                Diagnostic::new(Code::MISSING_FIELD, tree.span, format!("this material has no `{lacking} : {ty}`"))
                    .label("incomplete")
                    .help("use `MaterialData` of `std.materials`, or a record with the fields `young`, `poisson`, `density` and `loss`"),
            );
            return None;
        }
        let Value::List(values) = self.expressions.constant(&expr)? else { return None };
        let numbers: Option<Vec<f64>> =
            places.into_iter().map(|place| values.get(place?).and_then(Value::as_number)).collect();
        let [young, poisson, density, loss] = numbers?[..] else { return None };
        let wrong = if young <= 0.0 {
            Some(("`young` must be above 0", units::shown(young, Dimension::PRESSURE)))
        } else if density <= 0.0 {
            Some(("`density` must be above 0", units::shown(density, Dimension::DENSITY)))
        } else if !(0.0..=MOST_POISSON).contains(&poisson) {
            Some(("`poisson` must lie within 0 .. 0.4995: rubber has about 0.49", poisson.to_string()))
        } else if loss < 0.0 {
            Some(("`loss` must not be below 0", loss.to_string()))
        } else {
            None
        };
        if let Some((must, value)) = wrong {
            self.report(
                Diagnostic::new(Code::OUT_OF_DOMAIN, tree.span, must)
                    .label(format!("here it is {value}"))
                    .help("correct the material where it is declared"),
            );
            return None;
        }
        Some(Material { young, poisson, density, loss })
    }

    fn chamber(&mut self, from: &Values<'_>, section: RowSection, cx: &Context) -> Option<Chamber> {
        let mut length = |name: &str, example: &str| {
            self.number(from, name, Dimension::LENGTH, Sign::Positive, example, cx)
        };
        let (hole, half) = if section.is_round {
            let radius = length("radius", "4 mm")?;
            (Hole::Round { radius }, [radius; 2])
        } else {
            let (width, height) = (length("width", "12 mm"), length("height", "10 mm"));
            let (width, height) = (width?, height?);
            (Hole::Box { width, height }, [0.5 * width, 0.5 * height])
        };
        let wrong: &[&str] = if section.is_round { &["width", "height"] } else { &["radius"] };
        for name in wrong {
            if let Some((name, _)) = from.values.get(name) {
                let (a, b) = if section.is_round {
                    ("a cylinder", "`radius`")
                } else {
                    ("a box", "`width` and `height`")
                };
                self.report(
                    Diagnostic::new(
                        Code::UNKNOWN_FIELD,
                        name.span,
                        format!("the chamber of {a} has no `{}`", name.text),
                    )
                    .label("not known")
                    .help(format!("a chamber has the form of its segment: give {b}")),
                );
            }
        }
        let offset = self.optional(from, "offset", Dimension::LENGTH, cx)?;
        let pressure = self.number(from, "pressure", Dimension::PRESSURE, Sign::Positive, "1 bar", cx);
        let winding = self.optional(from, "winding", Dimension::STIFFNESS, cx)?;
        let sheet = self.optional(from, "sheet", Dimension::STIFFNESS, cx)?;
        for (name, value) in [("winding", winding), ("sheet", sheet)] {
            if let (true, Some((_, tree))) = (value < 0.0, from.values.get(name)) {
                self.report(
                    Diagnostic::new(Code::OUT_OF_DOMAIN, tree.span, format!("`{name}` must not be below 0"))
                        .label(format!("this is {}", units::shown(value, Dimension::STIFFNESS)))
                        .help(format!("write for example `{name} = 200 N/mm`")),
                );
            }
        }
        let sides = [section.half[0] - half[0], section.half[1] - half[1] - offset.abs()];
        let wall = sides[0].min(sides[1]);
        let thinnest = THINNEST * 2.0 * section.half[1];
        if wall < thinnest {
            let message = if wall <= 0.0 {
                "the chamber does not lie within the segment".to_owned()
            } else {
                format!("the thinnest wall of the chamber measures {}", units::shown(wall, Dimension::LENGTH))
            };
            self.report(
                Diagnostic::new(Code::OUT_OF_DOMAIN, from.place(), message)
                    .label(format!(
                        "it must leave {} on each side",
                        units::shown(thinnest, Dimension::LENGTH)
                    ))
                    .help("make the chamber smaller, or move it closer to the axis"),
            );
            return None;
        }
        if sheet > 0.0 && section.is_round {
            let place = from.values.get("sheet").map_or(from.place(), |(name, _)| name.span);
            self.report(
                Diagnostic::new(Code::OUT_OF_DOMAIN, place, "a cylinder has no flat side for a sheet")
                    .label("not possible here")
                    .help("move the chamber off the axis with `offset`, or make the segment a box"),
            );
            return None;
        }
        if offset < 0.0 && sheet == 0.0 {
            let place = from.values.get("offset").map_or(from.place(), |(_, tree)| tree.span);
            self.report(
                Diagnostic::new(
                    Code::OUT_OF_DOMAIN,
                    place,
                    "air in this chamber bends the actuator backwards",
                )
                .label("a positive `offset` is away from the side to which it bends")
                .help("write the offset without its minus sign, and turn the actuator where it is attached"),
            );
            return None;
        }
        if offset == 0.0 && sheet == 0.0 {
            self.report(
                Diagnostic::new(Code::OUT_OF_DOMAIN, from.place(), "air in this chamber would not bend the actuator")
                    .label("it lies in the middle, and all walls are alike")
                    .help("move it off the axis, such as `offset = 1 mm`, or add a sheet that does not stretch, such as `sheet = 200 N/mm`"),
            );
            return None;
        }
        Some(Chamber { hole, offset, pressure: pressure?, winding, sheet })
    }

    fn thread(&mut self, from: &Values<'_>, section: RowSection, cx: &Context) -> Option<Thread> {
        let offset = self.number(from, "offset", Dimension::LENGTH, Sign::Positive, "6 mm", cx);
        let pull = self.number(from, "pull", Dimension::FORCE, Sign::Positive, "10 N", cx);
        let offset = offset?;
        if offset > section.half[1] {
            let place = from.values.get("offset").map_or(from.place(), |(_, tree)| tree.span);
            self.report(
                Diagnostic::new(Code::OUT_OF_DOMAIN, place, "the thread lies outside the segment")
                    .label(format!(
                        "the segment ends {} from its axis",
                        units::shown(section.half[1], Dimension::LENGTH)
                    ))
                    .help("write how far the thread lies from the axis of the actuator"),
            );
            return None;
        }
        Some(Thread { offset, pull: pull? })
    }

    /// A number that is 0 where it is not given; none if it is wrong.
    fn optional(&mut self, from: &Values<'_>, name: &str, dimension: Dimension, cx: &Context) -> Option<f64> {
        if !from.values.contains_key(name) {
            return Some(0.0);
        }
        self.value(from, name, &Ty::Quantity(dimension), "0", cx)?.0.as_number()
    }
}
