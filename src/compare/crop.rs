use std::fmt;
use std::str::FromStr;

/// A rectangle of pixels, written `X,Y,WIDTH,HEIGHT` with `X,Y` its upper left pixel.
///
/// ```
/// use caustica::compare::Crop;
/// let crop: Crop = "8,0,32,16".parse()?;
/// assert_eq!(crop, Crop { x: 8, y: 0, width: 32, height: 16 });
/// # Ok::<(), caustica::compare::CropError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Crop {
    /// Its first column.
    pub x: usize,
    /// Its first row.
    pub y: usize,
    /// Number of columns.
    pub width: usize,
    /// Number of rows.
    pub height: usize,
}

/// A text is no rectangle of at least one pixel.
#[derive(Debug, PartialEq, thiserror::Error)]
#[error(
    "\"{text}\" is no crop; write X,Y,WIDTH,HEIGHT in whole pixels with sides from 1 on, such as 0,0,64,64"
)]
pub struct CropError {
    text: String,
}

impl FromStr for Crop {
    type Err = CropError;

    fn from_str(text: &str) -> Result<Crop, CropError> {
        let numbers: Option<Vec<usize>> = text.split(',').map(|part| part.trim().parse().ok()).collect();
        match numbers.as_deref() {
            Some(&[x, y, width, height]) if width > 0 && height > 0 => Ok(Crop { x, y, width, height }),
            _ => Err(CropError { text: text.into() }),
        }
    }
}

impl fmt::Display for Crop {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{},{},{},{}", self.x, self.y, self.width, self.height)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn crops_are_read_as_written() {
        let crop = Crop { x: 1, y: 2, width: 3, height: 4 };
        assert_eq!((crop.to_string().parse(), " 1, 2,3 ,4".parse()), (Ok(crop), Ok(crop)));
        for wrong in ["", "1,2,3", "1,2,3,4,5", "-1,0,2,2", "0,0,0,4", "0,0,4,0", "a,0,1,1"] {
            let error = wrong.parse::<Crop>().unwrap_err().to_string();
            assert!(error.starts_with(&format!("\"{wrong}\" is no crop; write X,Y,WIDTH,HEIGHT")), "{error}");
        }
    }
}
