//! Bodies as pictures: seen from the side and above in parallel projection, the farthest faces drawn first.

use grammar_lang::shape::{CORNERS, Face, Outline, around};
use nalgebra::{Point3, Vector3};

use super::chart::path;
use crate::markup::escape;
use crate::results::report::gather::bodies::Piece;

/// The size of a picture.
pub(super) const SIZE: (f64, f64) = (240.0, 180.0);
/// Room at each side, and at the bottom for the scale.
const MARGIN: f64 = 10.0;
const FOOT: f64 = 18.0;

/// Where it is seen from: y is up.
struct View {
    right: Vector3<f64>,
    up: Vector3<f64>,
    near: Vector3<f64>,
    light: Vector3<f64>,
}

impl View {
    fn new() -> Self {
        let near = Vector3::new(0.62, 0.52, 1.0).normalize();
        let right = Vector3::y().cross(&near).normalize();
        Self { right, up: near.cross(&right), near, light: Vector3::new(-0.25, 0.9, 0.55).normalize() }
    }

    /// Across and downwards, in m.
    fn flat(&self, point: &Point3<f64>) -> (f64, f64) {
        (self.right.dot(&point.coords), -self.up.dot(&point.coords))
    }
}

/// The surface of a piece in the world.
fn surface(piece: &Piece) -> Outline {
    let Outline { faces, balls } = piece.shape.outline();
    let face = |face: Face| Face {
        corners: face.corners.iter().map(|corner| piece.pose * corner).collect(),
        normal: piece.pose * face.normal,
    };
    let ball = |(centre, radius)| (piece.pose * centre, radius);
    Outline { faces: faces.into_iter().map(face).collect(), balls: balls.into_iter().map(ball).collect() }
}

/// Points that hold a piece between them.
fn outline(piece: &Piece) -> Vec<Point3<f64>> {
    let view = View::new();
    let Outline { faces, balls } = surface(piece);
    let rim = |(centre, radius): (Point3<f64>, f64)| {
        (0..CORNERS).flat_map(move |i| {
            let along = around(i, CORNERS);
            [
                centre + (view.right * along.y + view.up * along.z) * radius,
                centre + Vector3::new(along.y, 0.0, along.z) * radius,
            ]
        })
    };
    faces.into_iter().flat_map(|face| face.corners).chain(balls.into_iter().flat_map(rim)).collect()
}

/// How wide and high some bodies are in the picture, in m, with their shadows.
pub(super) fn extent(pieces: &[Piece]) -> (f64, f64) {
    let ((left, right), (top, bottom)) = bounds(pieces);
    (right - left, bottom - top)
}

fn ground(pieces: &[Piece]) -> f64 {
    pieces.iter().map(|piece| piece.shape.lowest(&piece.pose)).fold(f64::INFINITY, f64::min)
}

fn bounds(pieces: &[Piece]) -> ((f64, f64), (f64, f64)) {
    let view = View::new();
    let floor = ground(pieces);
    let corners = || pieces.iter().flat_map(outline);
    let shadows = corners().map(|p| Point3::new(p.x, floor, p.z));
    let all: Vec<(f64, f64)> = corners().chain(shadows).map(|p| view.flat(&p)).collect();
    let range = |of: fn(&(f64, f64)) -> f64| {
        all.iter().map(of).fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)))
    };
    (range(|p| p.0), range(|p| p.1))
}

/// How many pixels a metre has in pictures that are to hold all these bodies.
pub(super) fn scale<'a>(bodies: impl Iterator<Item = &'a [Piece]>) -> f64 {
    let room = (SIZE.0 - 2.0 * MARGIN, SIZE.1 - 2.0 * MARGIN - FOOT);
    let fits = |(width, height): (f64, f64)| (room.0 / width.max(1e-6)).min(room.1 / height.max(1e-6));
    bodies
        .filter(|pieces| !pieces.is_empty())
        .map(|pieces| fits(extent(pieces)))
        .fold(f64::INFINITY, f64::min)
}

/// A body in a picture of so many pixels to the metre.
pub(super) fn picture(pieces: &[Piece], scale: f64, told: &str) -> String {
    let view = View::new();
    let ((left, right), (top, bottom)) = bounds(pieces);
    let (dx, dy) =
        (SIZE.0 / 2.0 - scale * (left + right) / 2.0, (SIZE.1 - FOOT) / 2.0 - scale * (top + bottom) / 2.0);
    let place = |point: &Point3<f64>| {
        let (x, y) = view.flat(point);
        (x * scale + dx, y * scale + dy)
    };
    let mut marks: Vec<(f64, String)> = Vec::new();
    for piece in pieces {
        let depth = |point: &Point3<f64>| view.near.dot(&point.coords);
        let Outline { faces, balls } = surface(piece);
        for (centre, radius) in balls {
            marks.push((depth(&centre), ball(place(&centre), radius * scale, &piece.colour)));
        }
        for face in faces.iter().filter(|face| face.normal.dot(&view.near) > 1e-6) {
            let middle = face.corners.iter().map(depth).sum::<f64>() / face.corners.len().max(1) as f64;
            let bright = 0.62 + 0.42 * face.normal.dot(&view.light).max(0.0);
            let fill = shaded(&piece.colour, bright);
            let outline = path(face.corners.iter().map(place));
            marks.push((
                middle,
                format!(
                    "<path fill=\"{fill}\" stroke=\"{}\" d=\"{outline}Z\"/>",
                    shaded(&piece.colour, bright * 0.9)
                ),
            ));
        }
    }
    marks.sort_by(|a, b| a.0.total_cmp(&b.0));
    let marks: String = marks.into_iter().map(|(_, mark)| mark + "\n").collect();
    format!(
        "<svg viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"{}\">\n<g class=\"shadow\">{}</g>\n<g class=\"solid\">\n{marks}</g>\n{}</svg>",
        SIZE.0,
        SIZE.1,
        escape(told),
        shadow(pieces, &place),
        ruler(scale)
    )
}

/// What the body leaves of the ground in the dark.
fn shadow(pieces: &[Piece], place: &dyn Fn(&Point3<f64>) -> (f64, f64)) -> String {
    let floor = ground(pieces);
    let below = |piece: &Piece| {
        let points = outline(piece).into_iter().map(|p| place(&Point3::new(p.x, floor, p.z))).collect();
        format!("<path d=\"{}Z\"/>", path(hull(points).into_iter()))
    };
    pieces.iter().map(below).collect()
}

/// The corners of the convex hull of points, around it.
fn hull(mut points: Vec<(f64, f64)>) -> Vec<(f64, f64)> {
    points.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let turns =
        |a: (f64, f64), b: (f64, f64), c: (f64, f64)| (b.0 - a.0) * (c.1 - a.1) - (b.1 - a.1) * (c.0 - a.0);
    let half = |points: &mut dyn Iterator<Item = (f64, f64)>| {
        let mut chain: Vec<(f64, f64)> = Vec::new();
        for point in points {
            while let [.., a, b] = chain.as_slice()
                && turns(*a, *b, point) <= 0.0
            {
                chain.pop();
            }
            chain.push(point);
        }
        chain.pop();
        chain
    };
    let mut corners = half(&mut points.iter().copied());
    corners.extend(half(&mut points.iter().rev().copied()));
    corners
}

/// A ball: a disk with a light spot.
fn ball((x, y): (f64, f64), r: f64, colour: &str) -> String {
    let mut out = format!(
        "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{r:.1}\" fill=\"{}\" stroke=\"{}\"/>",
        shaded(colour, 0.74),
        shaded(colour, 0.6)
    );
    for (part, bright) in [(0.82, 0.84), (0.6, 0.93), (0.36, 1.0)] {
        let shift = r * (1.0 - part) * 0.62;
        out += &format!(
            "<circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"{:.1}\" fill=\"{}\"/>",
            x - shift * 0.5,
            y - shift,
            r * part,
            shaded(colour, bright)
        );
    }
    out
}

/// A round length, to compare with.
fn ruler(scale: f64) -> String {
    let lengths = [0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0];
    let Some(length) =
        lengths.into_iter().find(|length| length * scale >= 24.0).filter(|l| l * scale < 150.0)
    else {
        return String::new();
    };
    let text = if length >= 1.0 {
        format!("{length:.0} m")
    } else if length >= 0.01 {
        format!("{:.0} cm", length * 100.0)
    } else {
        format!("{:.0} mm", length * 1000.0)
    };
    let (y, end) = (SIZE.1 - 9.0, MARGIN + length * scale);
    format!(
        "<path class=\"ruler\" d=\"M{MARGIN} {0}v6M{MARGIN} {y}H{end:.1}M{end:.1} {0}v6\"/><text x=\"{1:.1}\" y=\"{2}\">{text}</text>",
        y - 3.0,
        end + 6.0,
        y + 4.0
    )
}

/// A colour made darker or lighter.
fn shaded(colour: &str, bright: f64) -> String {
    let hex = colour
        .strip_prefix('#')
        .filter(|hex| hex.len() == 6)
        .and_then(|hex| u32::from_str_radix(hex, 16).ok());
    let rgb = hex.unwrap_or(0x0099_9999);
    let channel = |shift: u32| (f64::from(rgb >> shift & 255) * bright).round().clamp(0.0, 255.0) as u8;
    format!("#{:02x}{:02x}{:02x}", channel(16), channel(8), channel(0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::design::assembly::Shape;
    use nalgebra::Isometry3;

    fn piece(shape: Shape, x: f64) -> Piece {
        Piece { shape, pose: Isometry3::translation(x, 0.0, 0.0), colour: "#336699".to_owned() }
    }

    #[test]
    fn of_a_box_three_faces_are_seen_and_of_a_cylinder_half() {
        let seen = |shape| picture(&[piece(shape, 0.0)], 1000.0, "").matches(" stroke=\"#").count();
        assert_eq!(seen(Shape::Box { half: Vector3::new(0.02, 0.02, 0.02) }), 3);
        assert_eq!(seen(Shape::Cylinder { radius: 0.01, half_length: 0.02 }), CORNERS / 2 + 1);
        assert_eq!(seen(Shape::Ball { radius: 0.02 }), 1);
    }

    #[test]
    fn what_is_nearer_is_drawn_later() {
        let cube = Shape::Box { half: Vector3::new(0.01, 0.01, 0.01) };
        let (mut near, mut far) = (piece(cube, 0.05), piece(cube, -0.05));
        (near.colour, far.colour) = ("#ff0000".to_owned(), "#0000ff".to_owned());
        let drawn = picture(&[near, far], 1000.0, "");
        let last = |colour: &str| drawn.rfind(colour).unwrap();
        let (red, blue) = (shaded("#ff0000", 0.62), shaded("#0000ff", 0.62));
        assert!(drawn.contains(&red[..3]) && last(&red[..3]) > last(&blue[3..]), "{drawn}");
    }

    #[test]
    fn every_body_fits_into_its_picture() {
        let long = [piece(Shape::Box { half: Vector3::new(1.0, 0.1, 0.1) }, 0.0)];
        let small = [piece(Shape::Ball { radius: 0.1 }, 3.0)];
        let scale = scale([&long[..], &small[..], &[]].into_iter());
        let (width, height) = extent(&long);
        assert!((width * scale - 220.0).abs() < 1e-9 && height * scale < 142.0);
        assert_eq!(super::scale([].into_iter()), f64::INFINITY);
    }

    #[test]
    fn a_hull_goes_around() {
        let square = vec![(0.0, 0.0), (1.0, 1.0), (0.5, 0.5), (1.0, 0.0), (0.0, 1.0), (0.5, 0.0)];
        assert_eq!(hull(square), [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]);
        assert_eq!(shaded("#804020", 0.5), "#402010");
        assert_eq!(shaded("green", 1.0), "#999999");
    }
}
