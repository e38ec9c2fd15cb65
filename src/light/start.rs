use super::choice::choice;

/// The numbers that an emission is drawn by, in the order in which they are drawn: two choose the light, the first coarsely and the
/// last finely; four place and direct it.
pub type Numbers = [f32; 6];

/// How many dimensions a start has: the choice of the light, and four numbers.
pub const DIMENSIONS: usize = 5;

/// The start of a photon as what it is drawn by: a point of the unit cube.
pub type Start = [f64; DIMENSIONS];

/// The point of the cube that numbers stand for.
pub fn start([coarse, a, b, c, d, fine]: Numbers) -> Start {
    [choice(coarse, fine), a.into(), b.into(), c.into(), d.into()]
}
