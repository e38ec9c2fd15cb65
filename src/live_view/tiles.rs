use super::packet::Rectangle;
use crate::film::Image;

/// Side of a tile, in pixels; at the right and the lower edge they may be smaller.
const TILE: usize = 64;

/// The tiles in which `picture` differs by any bit from `shown`, which is as large; all of them without that.
pub fn changed<'a>(
    picture: &'a Image,
    shown: Option<&'a Image>,
) -> impl Iterator<Item = Rectangle> + use<'a> {
    let (width, height) = (picture.width(), picture.height());
    let tile = move |(x, y)| Rectangle { x, y, width: TILE.min(width - x), height: TILE.min(height - y) };
    let corners = (0..height).step_by(TILE).flat_map(move |y| (0..width).step_by(TILE).map(move |x| (x, y)));
    corners.map(tile).filter(move |&tile| shown.is_none_or(|shown| differ(picture, shown, tile)))
}

fn differ(picture: &Image, shown: &Image, tile: Rectangle) -> bool {
    let bits = |image| samples(image, tile).map(f32::to_bits);
    !bits(picture).eq(bits(shown))
}

/// The samples of a tile, channel by channel and row by row.
pub fn samples(image: &Image, tile: Rectangle) -> impl Iterator<Item = f32> {
    let Rectangle { x, y, width, height } = tile;
    let rows = move |channel: usize| {
        (y..y + height).flat_map(move |y| (x..x + width).map(move |x| image.get(x, y)[channel]))
    };
    (0..3).flat_map(rows)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Rgb;

    #[test]
    fn tiles_cover_a_picture_and_only_changed_ones_come_again() {
        let mut picture = Image::new(130, 65);
        let sizes: Vec<_> = changed(&picture, None).map(|tile| (tile.width, tile.height)).collect();
        assert_eq!(sizes, [(64, 64), (64, 64), (2, 64), (64, 1), (64, 1), (2, 1)]);
        let shown = picture.clone();
        assert_eq!(changed(&picture, Some(&shown)).count(), 0);
        picture.pixels_mut()[64 * 130 + 128] = Rgb::new(0.0, 0.0, -0.0);
        let tiles: Vec<_> = changed(&picture, Some(&shown)).collect();
        assert_eq!(tiles, [Rectangle { x: 128, y: 64, width: 2, height: 1 }]);
        let nan = Image::from_pixels(1, 1, vec![Rgb::NAN]).unwrap();
        assert_eq!(changed(&nan, Some(&nan)).count(), 0, "equal by bits");
    }

    #[test]
    fn samples_go_channel_by_channel_and_row_by_row() {
        let numbered = (0..9).map(|k| Rgb::new(k as f32, k as f32 + 10.0, k as f32 + 20.0)).collect();
        let image = Image::from_pixels(3, 3, numbered).unwrap();
        let found: Vec<f32> = samples(&image, Rectangle { x: 1, y: 1, width: 2, height: 2 }).collect();
        assert_eq!(found, [4.0, 5.0, 7.0, 8.0, 14.0, 15.0, 17.0, 18.0, 24.0, 25.0, 27.0, 28.0]);
    }
}
