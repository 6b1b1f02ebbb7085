//! Built-in words, functions and attributes: what each is called and means, in one place each. Those of one
//! stage are an enumeration of their own, which that stage matches without a wildcard: what the checker
//! lets a grammar read, the engine must know.

use serde::{Deserialize, Serialize};

use super::{Difference, JointKind, Solid, Ty};
use crate::units::Dimension;

macro_rules! words {
    ($(#[$meta:meta])* $name:ident { $($variant:ident $text:literal $doc:literal;)* }
     $($(#[$of_meta:meta])* $of:ident($inner:ident) { $($one:ident)* })*) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
        #[serde(rename_all = "snake_case")]
        pub enum $name {
            $(#[doc = $doc] $variant,)*
            $($(#[$of_meta])* #[serde(untagged)] $of($inner),)*
        }
        impl $name {
            /// Every one, in the order of the reference.
            pub const ALL: &[Self] = &[$(Self::$variant,)* $($(Self::$of($inner::$one)),*),*];
            /// How a grammar writes it.
            #[must_use]
            pub fn text(self) -> &'static str { match self { $(Self::$variant => $text,)* $(Self::$of(of) => of.text(),)* } }
            /// What it means.
            #[must_use]
            pub fn doc(self) -> &'static str { match self { $(Self::$variant => $doc,)* $(Self::$of(of) => of.doc(),)* } }
            /// The one that a grammar writes like this.
            #[must_use]
            pub fn named(text: &str) -> Option<Self> { Self::ALL.iter().copied().find(|w| w.text() == text) }
        }
    };
}

words! {
    /// Words that a stage gives a value to.
    Word {
        Pi "pi" "The number 3.14159...";
        Cycle "cycle" "Where a pattern is in its cycle, from 0 to 1.";
        Time "t" "The time since the motion began.";
        Closed "closed" "Both valves of an actuator are closed: it keeps its air.";
        Inflate "inflate" "An actuator's valve lets air in.";
        Vent "vent" "An actuator's valve lets air out.";
        Now "now" "The control moment at which a sensor reads.";
        Before "before" "The last moment before at which a policy decided.";
        ControlInterval "control_interval" "The time between two control moments.";
    }
    /// Of a motion.
    Motion(MotionWord) { Period Start End Duration FrameInterval Elements }
    /// Of a search.
    Search(SearchWord) { Temperature Iteration Best Idle Refused Stagnant Deviation Chain Spread Tuned Parent Spent }
    /// Of the design.
    Design(DesignWord) { Middle Connected NoOverlap }
}

words! {
    /// What terms read of the simulated motion.
    MotionWord {
        Period "period" "The period of the cyclic actuation.";
        Start "start" "The time at which the motion begins.";
        End "end" "The time at which the motion ends.";
        Duration "duration" "How long the motion lasts.";
        FrameInterval "frame_interval" "The time between two recorded frames of the motion.";
        Elements "elements" "All rigid pieces of the body.";
    }
}

words! {
    /// What schedules, weights and mutations read of the search.
    SearchWord {
        Temperature "temperature" "The temperature of the annealing, on the scale of the objective.";
        Iteration "iteration" "How many iterations have been completed.";
        Best "best" "The best value so far.";
        Idle "idle" "Iterations since the best value improved.";
        Refused "refused" "Moves in a row that were not accepted.";
        Stagnant "stagnant" "Iterations in a row in which no move was accepted.";
        Deviation "deviation" "The standard deviation of the values of the random walk.";
        Chain "chain" "The number of an annealing chain, from 0.";
        Spread "spread" "The standard deviation of the samples, as a share of the ranges.";
        Tuned "tuned" "How often the curves of this body were tuned before.";
        Parent "parent" "The value of the design from which this one was made.";
        Spent "spent" "The share of its evaluations that the run has spent.";
    }
}

words! {
    /// What everything reads of the design.
    DesignWord {
        Middle "middle" "The place in the middle of the lattice.";
        Connected "connected" "Whether the design is in one piece.";
        NoOverlap "no_overlap" "Whether no two parts overlap; touching is allowed.";
    }
}

words! {
    /// Built-in functions.
    Function {
        Abs "abs" "The absolute value.";
        Min "min" "The least of several values.";
        Max "max" "The greatest of several values.";
        Clamp "clamp" "clamp(x, low, high): x, limited to the range from low to high.";
        Floor "floor" "Rounds down to a whole number.";
        Ceil "ceil" "Rounds up to a whole number.";
        Round "round" "The nearest whole number.";
        Fraction "fraction" "The fractional part: a number minus its floor.";
        Sqrt "sqrt" "The square root.";
        Exp "exp" "The exponential of a number.";
        Ln "ln" "The natural logarithm of a number.";
        Sin "sin" "The sine of an angle.";
        Cos "cos" "The cosine of an angle.";
        Tan "tan" "The tangent of an angle.";
        Asin "asin" "asin(number): the angle of this sine, -90 deg to 90 deg.";
        Acos "acos" "acos(number): the angle of this cosine, 0 deg to 180 deg.";
        Atan2 "atan2" "atan2(y, x): the angle from the direction of x to that of y, -180 deg to 180 deg.";
        Arc "arc" "arc(radius, angle): the length of an arc.";
        Length "length" "The length of a vector.";
        Horizontal "horizontal" "The length of the horizontal part of a vector.";
        Height "height" "The vertical part of a vector.";
        Vector "vector" "vector(x, y, z), with y up.";
        Angle "angle" "angle(a, b): the angle of the rotation from a to b.";
        Heading "heading" "heading(rotation): where x points along the ground, seen from above; left of forward is positive.";
        Bearing "bearing" "bearing(vector): where a vector points along the ground, seen from above; left of forward is positive.";
        Inclination "inclination" "inclination(rotation): how far the y axis leans from the vertical, 0 deg to 180 deg.";
        Rotated "rotated" "rotated(vector, rotation): turns a vector by a rotation, such as from the frame of a body into the axes of the world.";
        Inverse "inverse" "inverse(rotation): the opposite rotation.";
        Wrap "wrap" "wrap(angle): the same direction within -180 deg .. 180 deg.";
        Count "count" "How many parts of a kind, or items of a list, there are.";
        Each "each" "each(list, n): every item n times in a row.";
        Repeat "repeat" "repeat(x, n): a list of n times x.";
        First "first" "The first item of a list.";
        Last "last" "The last item of a list.";
        Bezier "bezier" "A Bezier curve over a cycle, through the first and last of its control points.";
        Cycle "cycle" "cycle(period, shares, states, phase): states of valves that take turns, each for its share of the period.";
        Normal "normal" "normal(mean, standard deviation): a distribution.";
        Uniform "uniform" "uniform(low, high): a distribution.";
        Gain "gain" "gain(n): what the best value gained in the last n iterations.";
    }
    /// A function that asks the design.
    Design(DesignFunction) { Cell Region Neighbours Images HangingOn }
    /// A function that makes shapes.
    Solid(Solid) { Box Sphere Cylinder Disk Capsule }
}

words! {
    /// Functions that ask the design.
    DesignFunction {
        Cell "cell" "cell(x, y, z): a place of the lattice, counted from 0.";
        Region "region" "region(c, x, y, z): the places whose offsets from a cell are these numbers or ranges, as far as the lattice reaches.";
        Neighbours "neighbours" "The parts that are joined to a part, or the cells to a cell: up to 18.";
        Images "images" "The images of a part under the symmetry, without itself.";
        HangingOn "hanging_on" "The parts that hang on a part, directly or through others.";
    }
}

words! {
    /// Attributes of a part.
    PartAttribute {
        Turn "turn" "Its rotation about the port that holds it.";
        Image "image" "Which image of the symmetry it is: 0 for an original, then 1, 2, ...";
        OwnImage "own_image" "Whether it is its own image: it lies on the plane of a mirror.";
        Depth "depth" "How many joints lie between it and the core.";
        Mass "mass" "Its mass.";
        Holder "holder" "The part that holds it; the core holds itself.";
        Port "port" "The port that it is attached to; the core has none.";
        Twin "twin" "Its first image, or itself.";
        Place "place" "Where its frame is in the body as it is attached: the centre of a block, the base of an actuator, from the centre of the core.";
        Facing "facing" "The direction in which its x axis points (of a block its front, of an actuator its tip), in the frame of the core.";
        Upward "upward" "The direction in which its y axis points (its top), in the frame of the core.";
        Sideways "sideways" "The direction in which its z axis points (its right), in the frame of the core.";
        Centre "centre" "Its centre of mass in the frame of the core.";
        PlaceAtRest "place_at_rest" "Where its frame is as a motion begins, with all joints at `neutral`, from the centre of the core.";
        FacingAtRest "facing_at_rest" "The direction in which its x axis points as a motion begins, in the frame of the core; of a row that of its base.";
        UpwardAtRest "upward_at_rest" "The direction in which its y axis points as a motion begins, in the frame of the core; of a row that of its base.";
        SidewaysAtRest "sideways_at_rest" "The direction in which its z axis points as a motion begins, in the frame of the core; of a row that of its base.";
        CentreAtRest "centre_at_rest" "Its centre of mass as a motion begins, in the frame of the core.";
        LeastCorner "least_corner" "The corner of its bounding box with the least coordinates as a motion begins, in the frame of the core.";
        GreatestCorner "greatest_corner" "The corner of its bounding box with the greatest coordinates as a motion begins, in the frame of the core.";
        LowestPoint "lowest_point" "The height of its lowest point as a motion begins, from the centre of the core.";
        LeastBend "least_bend" "Of a part with a joint that bends or twists: the lower end of its range.";
        GreatestBend "greatest_bend" "Of a part with a joint that bends or twists: the upper end of its range.";
        LeastDistance "least_distance" "Of a part with a joint that slides: the lower end of its range.";
        GreatestDistance "greatest_distance" "Of a part with a joint that slides: the upper end of its range.";
        NeutralBend "neutral_bend" "Of a part with a joint that bends or twists: its rest position, `neutral`.";
        NeutralDistance "neutral_distance" "Of a part with a joint that slides: its rest position, `neutral`.";
        GreatestSpeed "greatest_speed" "Of an actuator that spins: how fast it can turn.";
        Work "work" "Of an actuator: the mechanical work that it did in the motion.";
    }
}

words! {
    /// Fields of kinds that can be read of their parts. What one is of depends on the joint.
    KindField {
        Friction "friction" "The friction coefficient of its surface.";
        Stiffness "stiffness" "Of a part with a joint that does not spin: the stiffness of each joint.";
        Damping "damping" "Of a part with a joint: the damping of each joint.";
        Torque "torque" "Of an actuator that bends: the greatest torque at each joint.";
        Effort "effort" "Of an actuator that twists, slides or spins: the greatest torque or force at each joint.";
    }
}

words! {
    /// Attributes of a place of a lattice.
    CellAttribute {
        X "x" "Its place along x, counted from 0.";
        Y "y" "Its place along y, counted from 0.";
        Z "z" "Its place along z, counted from 0.";
        Filled "filled" "Whether there is a cell.";
    }
}

words! {
    /// Attributes of a port.
    PortAttribute {
        Part "part" "The part whose port it is.";
        Index "index" "Its number among the ports of one name.";
        Free "free" "Whether nothing is attached to it.";
        Place "place" "Where it is in the body as it is attached, from the centre of the core.";
        Facing "facing" "The direction in which it points, in the frame of the core.";
        PlaceAtRest "place_at_rest" "Where it is as a motion begins, with all joints at `neutral`, from the centre of the core.";
        FacingAtRest "facing_at_rest" "The direction in which it points as a motion begins, in the frame of the core.";
    }
}

words! {
    /// Attributes of a joint.
    JointAttribute {
        Holder "holder" "The part that holds the other.";
        Held "held" "The part that is held.";
        Port "port" "The port that holds it.";
    }
}

words! {
    /// Attributes of a step of the derivation.
    StepAttribute {
        Rule "rule" "The name of the rule.";
        Number "number" "Its place in the derivation, from 1.";
    }
}

words! {
    /// What the recorded motion says of an element as a whole.
    ElementAttribute {
        Size "size" "Its greatest extent.";
        Path "path" "The distance that it moved along the ground while it touched the ground.";
        Slid "slid" "The distance that it slid.";
        Yaw "yaw" "The angle by which it turned about the vertical; to the left is positive.";
        Touching "touching" "For how long it touched the ground.";
        Sliding "sliding" "For how long it slid.";
        Part "part" "The part that it belongs to.";
        Cell "cell" "The cell that it is.";
    }
}

words! {
    /// What the recorded motion says of an element at each time.
    Track {
        Position "position" "Where its centre is.";
        Rotation "rotation" "How it is turned.";
        Lowest "lowest" "How high its lowest point is.";
        Velocity "velocity" "In a sensor: how fast its centre moves.";
        AngularVelocity "angular_velocity" "In a sensor: how fast it turns, as a vector along the axis of the turn.";
        Load "load" "In a sensor: the force with which the ground supports it; for a part, the sum over its elements.";
        Angle "angle" "In a sensor: the angle by which a row is bent or twisted from base to tip, or by which the joint of a part has turned.";
        AngleRate "angle_rate" "In a sensor: the rate of change of that angle.";
        Distance "distance" "In a sensor: the distance by which a row has slid from base to tip, or by which the joint of a part has slid.";
        DistanceRate "distance_rate" "In a sensor: the rate of change of that distance.";
        Speed "speed" "In a sensor: the angular speed of a joint that spins.";
    }
}

words! {
    /// Components of a vector.
    Axis {
        X "x" "Along x.";
        Y "y" "Along y, which is up.";
        Z "z" "Along z.";
    }
}

/// What follows a dot.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Attribute {
    /// Of a part.
    Part(PartAttribute),
    /// Of a place of a lattice.
    Cell(CellAttribute),
    /// Of a port.
    Port(PortAttribute),
    /// Of a joint.
    Joint(JointAttribute),
    /// Of a step.
    Step(StepAttribute),
    /// Of an element, over the whole motion.
    Element(ElementAttribute),
    /// Of an element, at a time.
    Track(Track),
    /// Of a vector.
    Axis(Axis),
    /// Of a world.
    World(Difference),
    /// A field of the kind of a part.
    Field(KindField),
    /// A parameter of an actuator or of a cell, by its name.
    Param(String),
}

impl Attribute {
    /// How a grammar writes it.
    #[must_use]
    pub fn text(&self) -> &str {
        match self {
            Self::Part(a) => a.text(),
            Self::Cell(a) => a.text(),
            Self::Port(a) => a.text(),
            Self::Joint(a) => a.text(),
            Self::Step(a) => a.text(),
            Self::Element(a) => a.text(),
            Self::Track(a) => a.text(),
            Self::Axis(a) => a.text(),
            Self::World(a) => a.text(),
            Self::Field(a) => a.text(),
            Self::Param(name) => name,
        }
    }

    /// Whether only a simulated motion has it.
    #[must_use]
    pub fn is_of_motion(&self) -> bool {
        matches!(self, Self::Element(_) | Self::Track(_) | Self::Part(PartAttribute::Work))
    }

    /// Whether only sensors read it.
    #[must_use]
    pub fn is_felt(&self) -> bool {
        matches!(self, Self::Track(track) if track.is_felt())
    }

    /// The built-in attributes of things of a type, with their types: first those of the design, then
    /// those of a motion.
    #[must_use]
    pub fn all_of(thing: &Ty) -> Vec<(Self, Ty)> {
        let part = |a: &PartAttribute| (Self::Part(*a), a.ty());
        let track = |t: &Track| (Self::Track(*t), t.ty());
        let moving = [Track::Position, Track::Rotation];
        let felt = || Track::ALL.iter().filter(|t| t.is_felt()).map(track);
        match thing {
            Ty::Part => {
                let all = PartAttribute::ALL.iter().filter(|a| !a.is_of_actuators());
                all.map(part).chain(moving.iter().map(track)).chain(felt()).collect()
            }
            Ty::Actuator => {
                let (of_motion, of_design): (Vec<_>, Vec<_>) =
                    PartAttribute::ALL.iter().map(part).partition(|(a, _)| a.is_of_motion());
                of_design.into_iter().chain(moving.iter().map(track)).chain(of_motion).chain(felt()).collect()
            }
            Ty::Cell => {
                let all = CellAttribute::ALL.iter().map(|a| (Self::Cell(*a), a.ty()));
                all.chain([track(&Track::Position)]).collect()
            }
            Ty::Port => PortAttribute::ALL.iter().map(|a| (Self::Port(*a), a.ty())).collect(),
            Ty::Joint => JointAttribute::ALL.iter().map(|a| (Self::Joint(*a), a.ty())).collect(),
            Ty::Step => StepAttribute::ALL.iter().map(|a| (Self::Step(*a), a.ty())).collect(),
            Ty::Element => {
                let all = ElementAttribute::ALL.iter().map(|a| (Self::Element(*a), a.ty()));
                Track::ALL.iter().filter(|t| !t.is_of_joints()).map(track).chain(all).collect()
            }
            Ty::Vector(dimension) => {
                Axis::ALL.iter().map(|a| (Self::Axis(*a), Ty::Quantity(*dimension))).collect()
            }
            Ty::World => Difference::ALL.iter().map(|a| (Self::World(*a), (*a).into())).collect(),
            _ => Vec::new(),
        }
    }

    /// A built-in attribute of things of a type, with its type.
    #[must_use]
    pub fn of(thing: &Ty, name: &str) -> Option<(Self, Ty)> {
        Self::all_of(thing).into_iter().find(|(attribute, _)| attribute.text() == name)
    }
}

impl PartAttribute {
    /// Whether some parts do not have it: the core hangs on no port, and only some joints have ends.
    #[must_use]
    pub fn is_of_some(self) -> bool {
        matches!(
            self,
            Self::Port
                | Self::LeastBend
                | Self::GreatestBend
                | Self::LeastDistance
                | Self::GreatestDistance
                | Self::NeutralBend
                | Self::NeutralDistance
                | Self::GreatestSpeed
        )
    }

    /// Whether only actuators have it.
    #[must_use]
    pub fn is_of_actuators(self) -> bool {
        matches!(self, Self::GreatestSpeed | Self::Work)
    }

    fn ty(self) -> Ty {
        match self {
            Self::Turn | Self::LeastBend | Self::GreatestBend | Self::NeutralBend => {
                Ty::Quantity(Dimension::ANGLE)
            }
            Self::OwnImage => Ty::Bool,
            Self::LeastDistance | Self::GreatestDistance | Self::NeutralDistance => {
                Ty::Quantity(Dimension::LENGTH)
            }
            Self::GreatestSpeed => Ty::Quantity(Dimension::ANGULAR_VELOCITY),
            Self::Image | Self::Depth => Ty::Count,
            Self::Mass => Ty::Quantity(Dimension::MASS),
            Self::Holder | Self::Twin => Ty::Part,
            Self::Port => Ty::Port,
            Self::Place
            | Self::Centre
            | Self::PlaceAtRest
            | Self::CentreAtRest
            | Self::LeastCorner
            | Self::GreatestCorner => Ty::Vector(Dimension::LENGTH),
            Self::Facing
            | Self::Upward
            | Self::Sideways
            | Self::FacingAtRest
            | Self::UpwardAtRest
            | Self::SidewaysAtRest => Ty::Vector(Dimension::NUMBER),
            Self::LowestPoint => Ty::Quantity(Dimension::LENGTH),
            Self::Work => Ty::Quantity(Dimension::ENERGY),
        }
    }
}

impl CellAttribute {
    fn ty(self) -> Ty {
        match self {
            Self::X | Self::Y | Self::Z => Ty::Count,
            Self::Filled => Ty::Bool,
        }
    }
}

impl PortAttribute {
    fn ty(self) -> Ty {
        match self {
            Self::Part => Ty::Part,
            Self::Index => Ty::Count,
            Self::Free => Ty::Bool,
            Self::Place | Self::PlaceAtRest => Ty::Vector(Dimension::LENGTH),
            Self::Facing | Self::FacingAtRest => Ty::Vector(Dimension::NUMBER),
        }
    }
}

impl JointAttribute {
    fn ty(self) -> Ty {
        match self {
            Self::Holder | Self::Held => Ty::Part,
            Self::Port => Ty::Port,
        }
    }
}

impl StepAttribute {
    fn ty(self) -> Ty {
        match self {
            Self::Rule => Ty::Text,
            Self::Number => Ty::Count,
        }
    }
}

impl ElementAttribute {
    fn ty(self) -> Ty {
        match self {
            Self::Size | Self::Path | Self::Slid => Ty::Quantity(Dimension::LENGTH),
            Self::Yaw => Ty::Quantity(Dimension::ANGLE),
            Self::Touching | Self::Sliding => Ty::Quantity(Dimension::TIME),
            Self::Part => Ty::Part,
            Self::Cell => Ty::Cell,
        }
    }
}

impl Track {
    /// Whether only a sensor knows it: no motion records it.
    #[must_use]
    pub fn is_felt(self) -> bool {
        !matches!(self, Self::Position | Self::Rotation | Self::Lowest)
    }

    /// Whether it is of joints: of an actuator, of a passive row, or of a part that hangs on a joint.
    #[must_use]
    pub fn is_of_joints(self) -> bool {
        matches!(self, Self::Angle | Self::AngleRate | Self::Distance | Self::DistanceRate | Self::Speed)
    }

    /// Whether a joint of this kind has it.
    #[must_use]
    pub fn is_of(self, joint: JointKind) -> bool {
        match self {
            Self::Angle | Self::AngleRate => matches!(joint, JointKind::Bend | JointKind::Twist),
            Self::Distance | Self::DistanceRate => joint == JointKind::Slide,
            Self::Speed => joint == JointKind::Spin,
            _ => true,
        }
    }

    fn ty(self) -> Ty {
        Ty::Track(Box::new(match self {
            Self::Position => Ty::Vector(Dimension::LENGTH),
            Self::Rotation => Ty::Rotation,
            Self::Lowest | Self::Distance => Ty::Quantity(Dimension::LENGTH),
            Self::Velocity => Ty::Vector(Dimension::VELOCITY),
            Self::AngularVelocity => Ty::Vector(Dimension::ANGULAR_VELOCITY),
            Self::Load => Ty::Quantity(Dimension::FORCE),
            Self::Angle => Ty::Quantity(Dimension::ANGLE),
            Self::AngleRate | Self::Speed => Ty::Quantity(Dimension::ANGULAR_VELOCITY),
            Self::DistanceRate => Ty::Quantity(Dimension::VELOCITY),
        }))
    }
}
