//! What the balls must get right.
