/// The degrees that readers turn into these radians, where there are such.
pub(super) fn degrees(radians: f32) -> f32 {
    let nearest = radians.to_degrees();
    let around = [nearest, nearest.next_up(), nearest.next_down(), nearest.next_up().next_up()];
    around.into_iter().find(|degrees| degrees.to_radians() == radians).unwrap_or(nearest)
}
