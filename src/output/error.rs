use std::io;
use std::path::PathBuf;

/// Why a file could not be written or read; every text names the path, what is wrong and what would be right.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum OutputError {
    /// The path of an output file names a folder.
    #[error("{path}: this is a folder, not a file; name a file in it, such as {}", .path.join("picture.exr").display())]
    IsFolder {
        /// The path as given.
        path: PathBuf,
    },
    /// The path of an output file is empty or ends in `..`.
    #[error("\"{path}\": this path has no file name at its end; give one, such as picture.exr")]
    NoFileName {
        /// The path as given.
        path: PathBuf,
    },
    /// The path of an output file names a device, a pipe or a socket.
    #[error("{path}: this is neither a file nor free to become one (a device or a pipe?); name another file")]
    NotAFile {
        /// The path as given.
        path: PathBuf,
    },
    /// The folder of an output file cannot be made.
    #[error(
        "{path}: cannot make its folder {folder}: {source}; name a file in a folder that you may write to"
    )]
    MakeFolder {
        /// The path of the file as given.
        path: PathBuf,
        /// The folder that could not be made.
        folder: PathBuf,
        /// What the operating system says.
        source: io::Error,
    },
    /// No file can be made in the folder of an output file.
    #[error(
        "{path}: cannot make a file in the folder {folder}: {source}; name a file in a folder that you may write to"
    )]
    FolderNotWritable {
        /// The path of the file as given.
        path: PathBuf,
        /// The folder that takes no file.
        folder: PathBuf,
        /// What the operating system says.
        source: io::Error,
    },
    /// A layer does not cover the picture that it goes with.
    #[error(
        "{path}: layer {layer} has {}x{} pixels, the picture {}x{}; both must be of one size",
        .size.0, .size.1, .picture.0, .picture.1
    )]
    LayerSize {
        /// The path as given.
        path: PathBuf,
        /// The name of the layer.
        layer: String,
        /// Its width and height.
        size: (usize, usize),
        /// Those of the picture.
        picture: (usize, usize),
    },
    /// Writing began and could not be finished.
    #[error(
        "{path}: writing failed: {source}; whatever the file held before is untouched; \
         see that the disk has room and that the folder may be written to, then try again"
    )]
    Write {
        /// The path as given.
        path: PathBuf,
        /// What the operating system says.
        source: io::Error,
    },
    /// The file is in its place, but the disk does not confirm that it would survive a loss of power.
    #[error(
        "{path}: written, but the folder {folder} cannot be flushed to the disk: {source}; write it once more"
    )]
    Flush {
        /// The path as given.
        path: PathBuf,
        /// The folder that could not be flushed.
        folder: PathBuf,
        /// What the operating system says.
        source: io::Error,
    },
    /// A picture cannot be put into the format.
    #[error(
        "{path}: a picture of {width}x{height} pixels cannot be written; both sides must be from 1 to {limit}"
    )]
    Size {
        /// The path as given.
        path: PathBuf,
        /// Pixels in a row.
        width: usize,
        /// Number of rows.
        height: usize,
        /// The largest side that the format holds.
        limit: usize,
    },
    /// The encoder refuses the picture or its attributes.
    #[error("{path}: the EXR encoder refuses the picture: {reason}")]
    Encode {
        /// The path as given.
        path: PathBuf,
        /// What the encoder says.
        reason: String,
    },
    /// An attribute has a name that the format does not allow or needs for itself.
    #[error(
        "{path}: \"{name}\" cannot name an attribute: {reason}; a name like \"caustica:passes\" would do"
    )]
    AttributeName {
        /// The path as given.
        path: PathBuf,
        /// The name that is refused.
        name: String,
        /// What is wrong with it.
        reason: &'static str,
    },
    /// The exposure or the gamma of the display curve is unusable.
    #[error("{path}: the display curve has {what}; {right}")]
    Display {
        /// The path as given.
        path: PathBuf,
        /// The setting and its value.
        what: String,
        /// What would be right.
        right: &'static str,
    },
    /// A file to be read cannot be opened.
    #[error("{path}: cannot be read: {source}; name a file that exists and that you may read")]
    Open {
        /// The path as given.
        path: PathBuf,
        /// What the operating system says.
        source: io::Error,
    },
    /// A file to be read is not an EXR file, or a damaged or unsupported one.
    #[error("{path}: not a readable EXR picture ({reason}); a whole, flat (not deep) OpenEXR file is needed")]
    NotExr {
        /// The path as given.
        path: PathBuf,
        /// What the decoder says.
        reason: String,
    },
    /// No layer of an EXR file has colour.
    #[error("{path}: no layer has the channels R, G and B, or Y; the channels are: {channels}")]
    NoColour {
        /// The path as given.
        path: PathBuf,
        /// The channels that exist; a semicolon parts the layers.
        channels: String,
    },
    /// An EXR file has no layer of this name that has colour.
    #[error("{path}: there is no layer \"{layer}\"; {layers}")]
    NoLayer {
        /// The path as given.
        path: PathBuf,
        /// The layer as given.
        layer: String,
        /// The layers that exist.
        layers: String,
    },
    /// A file to be read is not a PNG file, or a damaged one.
    #[error("{path}: not a readable PNG picture ({reason}); a whole PNG file is needed")]
    NotPng {
        /// The path as given.
        path: PathBuf,
        /// What the decoder says.
        reason: String,
    },
    /// An EXR file stores a channel at less than full resolution.
    #[error("{path}: channel {channel} is subsampled; save the picture with all channels at full resolution")]
    Subsampled {
        /// The path as given.
        path: PathBuf,
        /// The first such channel.
        channel: String,
    },
    /// A picture file is larger than this program reads.
    #[error("{path}: {width}x{height} pixels are too many; at most {limit} pixels are read")]
    Oversize {
        /// The path as given.
        path: PathBuf,
        /// Pixels in a row.
        width: usize,
        /// Number of rows.
        height: usize,
        /// The largest number of pixels.
        limit: usize,
    },
}
