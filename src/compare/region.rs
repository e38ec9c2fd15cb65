use super::error::check_sizes;
use super::{CompareError, Crop};
use crate::film::Image;

/// The pixels of a picture that count in a comparison: those inside a crop that a mask leaves.
#[derive(Clone, Debug, PartialEq)]
pub struct Region {
    width: usize,
    height: usize,
    crop: Crop,
    /// Which pixels of the whole picture count; `None` for all.
    mask: Option<Vec<bool>>,
}

impl Region {
    /// All pixels of a picture.
    pub fn of(image: &Image) -> Region {
        let (width, height) = (image.width(), image.height());
        Region { width, height, crop: Crop { x: 0, y: 0, width, height }, mask: None }
    }

    /// Leaves out what is outside a rectangle.
    ///
    /// # Errors
    /// When the rectangle is empty or reaches beyond the picture, or when no pixel is left.
    pub fn with_crop(self, crop: Crop) -> Result<Region, CompareError> {
        let ends_inside = |start: usize, length: usize, side: usize| {
            length > 0 && start.checked_add(length).is_some_and(|end| end <= side)
        };
        if !(ends_inside(crop.x, crop.width, self.width) && ends_inside(crop.y, crop.height, self.height)) {
            return Err(CompareError::CropOutside { crop, width: self.width, height: self.height });
        }
        Region { crop, ..self }.not_empty()
    }

    /// Leaves out the pixels at which all channels of `mask` are 0.
    ///
    /// # Errors
    /// When the mask differs in size from the picture, or when no pixel is left.
    pub fn with_mask(self, mask: &Image) -> Result<Region, CompareError> {
        let (image, reference) = ((mask.width(), mask.height()), (self.width, self.height));
        if image != reference {
            return Err(CompareError::MaskSize { mask: image, picture: reference });
        }
        let mask = mask.pixels().iter().map(|pixel| pixel.to_array().iter().any(|&value| value != 0.0));
        Region { mask: Some(mask.collect()), ..self }.not_empty()
    }

    fn not_empty(self) -> Result<Region, CompareError> {
        if self.is_empty() { Err(CompareError::NothingLeft) } else { Ok(self) }
    }

    /// How many pixels count.
    pub fn len(&self) -> usize {
        self.pixels().count()
    }

    /// Whether no pixel counts, as of a picture without any.
    pub fn is_empty(&self) -> bool {
        self.pixels().next().is_none()
    }

    /// The rectangle; without a crop the whole picture.
    pub fn crop(&self) -> Crop {
        self.crop
    }

    /// Indices of the pixels that count, row by row.
    pub fn pixels(&self) -> impl Iterator<Item = usize> {
        self.crop_pixels().filter(|&pixel| self.counts(pixel))
    }

    /// The part of a picture inside the crop, masked pixels included.
    ///
    /// # Panics
    /// When the picture is smaller than that of the region.
    pub fn cut(&self, image: &Image) -> Image {
        let mut part = Image::new(self.crop.width, self.crop.height);
        part.pixels_mut()
            .iter_mut()
            .zip(self.crop_pixels())
            .for_each(|(to, from)| *to = image.pixels()[from]);
        part
    }

    /// Which pixels of [`Region::cut`] count.
    pub(super) fn cut_mask(&self) -> Vec<bool> {
        self.crop_pixels().map(|pixel| self.counts(pixel)).collect()
    }

    /// Column and row of a pixel in the whole picture.
    pub(super) fn place(&self, pixel: usize) -> (usize, usize) {
        (pixel % self.width, pixel / self.width)
    }

    pub(super) fn check(&self, image: &Image) -> Result<(), CompareError> {
        check_sizes((image.width(), image.height()), (self.width, self.height))
    }

    fn crop_pixels(&self) -> impl Iterator<Item = usize> {
        let (Crop { x, y, width, height }, stride) = (self.crop, self.width);
        (y..y + height).flat_map(move |row| row * stride + x..row * stride + x + width)
    }

    fn counts(&self, pixel: usize) -> bool {
        self.mask.as_ref().is_none_or(|mask| mask[pixel])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Rgb;

    fn mask(values: [f32; 12]) -> Image {
        Image::from_pixels(4, 3, values.map(|value| Rgb::new(0.0, value, 0.0)).to_vec()).unwrap()
    }

    #[test]
    fn crop_and_mask_leave_what_both_leave() {
        let region = Region::of(&Image::new(4, 3));
        assert_eq!((region.len(), region.pixels().last()), (12, Some(11)));
        let cropped = region.clone().with_crop(Crop { x: 1, y: 1, width: 2, height: 2 }).unwrap();
        assert_eq!(cropped.pixels().collect::<Vec<_>>(), [5, 6, 9, 10]);
        let dots = mask([1.0, 0.0, 0.0, 0.0, 0.0, 0.0, -0.1, 1.0, 0.0, f32::NAN, 0.0, 0.0]);
        let both = cropped.with_mask(&dots).unwrap();
        assert_eq!(both.pixels().collect::<Vec<_>>(), [6, 9]);
        assert_eq!(both.cut_mask(), [false, true, true, false]);
        assert_eq!((both.place(6), both.len()), ((2, 1), 2));
        assert_eq!(both.cut(&dots).pixels()[1].y, -0.1);
    }

    #[test]
    fn a_region_without_pixels_is_refused() {
        let region = Region::of(&Image::new(4, 3));
        assert_eq!(region.clone().with_mask(&mask([0.0; 12])), Err(CompareError::NothingLeft));
        let mut corner = [0.0; 12];
        corner[0] = 1.0;
        let masked = region.with_mask(&mask(corner)).unwrap();
        assert_eq!(
            masked.with_crop(Crop { x: 1, y: 0, width: 3, height: 3 }),
            Err(CompareError::NothingLeft)
        );
        assert!(Region::of(&Image::new(0, 3)).is_empty());
    }

    #[test]
    fn crops_and_masks_that_do_not_fit_are_named() {
        let region = || Region::of(&Image::new(4, 3));
        for (x, y, width, height) in [(1, 0, 4, 1), (0, 3, 1, 1), (usize::MAX, 0, 2, 1), (0, 0, 0, 1)] {
            let error = region().with_crop(Crop { x, y, width, height }).unwrap_err().to_string();
            assert!(
                error.ends_with("beyond the pictures of 4x3 pixels; name a rectangle inside them"),
                "{error}"
            );
        }
        let error = region().with_mask(&Image::new(3, 4)).unwrap_err().to_string();
        assert_eq!(error, "the mask has 3x4 pixels, the pictures have 4x3; give a mask of their size");
    }
}
