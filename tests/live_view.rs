//! Pictures under way, as a viewer receives them that knows nothing but the description of its packets.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a panic is how a test fails")]

use std::io::Read;
use std::net::{TcpListener, TcpStream};
use std::process::Command;
use std::sync::mpsc;
use std::thread::{self, JoinHandle};

use assert_cmd::cargo::CommandCargoExt;
use caustica::film::Image;
use caustica::live_view::{Address, LiveView};
use caustica::math::Rgb;
use caustica::output::read_exr;

mod common;

/// What a viewer holds of one picture.
#[derive(Default)]
struct Seen {
    name: String,
    created: u32,
    updates: u32,
    width: usize,
    pixels: Vec<Rgb>,
}

/// The fields of a packet, in their order.
struct Fields<'a>(&'a [u8]);

impl Fields<'_> {
    fn bytes<const N: usize>(&mut self) -> [u8; N] {
        let (first, rest) = self.0.split_first_chunk().expect("a longer packet");
        self.0 = rest;
        *first
    }

    fn number(&mut self) -> usize {
        usize::try_from(i32::from_le_bytes(self.bytes())).unwrap()
    }

    fn sample(&mut self) -> f32 {
        f32::from_le_bytes(self.bytes())
    }

    fn text(&mut self) -> String {
        let end = self.0.iter().position(|&byte| byte == 0).expect("an end of the text");
        let text = String::from_utf8(self.0[..end].to_vec()).unwrap();
        self.0 = &self.0[end + 1..];
        text
    }

    fn channels(&mut self) {
        let names: Vec<String> = (0..self.number()).map(|_| self.text()).collect();
        assert_eq!(names, ["R", "G", "B"]);
    }
}

impl Seen {
    /// All packets until the sender ends.
    fn read(mut stream: TcpStream) -> Seen {
        let mut seen = Seen::default();
        let mut length = [0; 4];
        while stream.read_exact(&mut length).is_ok() {
            let mut packet = vec![0; u32::from_le_bytes(length) as usize - 4];
            stream.read_exact(&mut packet).unwrap();
            seen.take(&packet);
        }
        seen
    }

    fn take(&mut self, packet: &[u8]) {
        let mut fields = Fields(packet);
        let [kind, focus] = fields.bytes();
        assert_eq!(focus, 0);
        let name = fields.text();
        match kind {
            4 => {
                (self.name, self.width) = (name, fields.number());
                self.pixels = vec![Rgb::ZERO; self.width * fields.number()];
                fields.channels();
                self.created += 1;
            }
            5 => {
                assert_eq!(name, self.name);
                fields.channels();
                self.update(&mut fields);
                self.updates += 1;
            }
            other => panic!("a packet of type {other}"),
        }
        assert!(fields.0.is_empty(), "{} bytes too many", fields.0.len());
    }

    fn update(&mut self, fields: &mut Fields) {
        let [x, y, width, height] = [(); 4].map(|()| fields.number());
        for channel in 0..3 {
            for row in y..y + height {
                for column in x..x + width {
                    self.pixels[row * self.width + column][channel] = fields.sample();
                }
            }
        }
    }

    fn image(self) -> Image {
        let height = self.pixels.len() / self.width;
        Image::from_pixels(self.width, height, self.pixels).unwrap()
    }
}

/// Takes one connection once it is told to, and reads all of it.
fn viewer() -> (Address, mpsc::Sender<()>, JoinHandle<Seen>) {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap().into();
    let (start, started) = mpsc::channel();
    let seen = thread::spawn(move || {
        let (stream, _) = listener.accept().unwrap();
        started.recv().unwrap();
        Seen::read(stream)
    });
    (address, start, seen)
}

fn picture(width: usize, height: usize, value: f32) -> Image {
    let pixel = |k: usize| Rgb::new(k as f32, value, f32::INFINITY);
    Image::from_pixels(width, height, (0..width * height).map(pixel).collect()).unwrap()
}

#[test]
fn a_viewer_puts_the_last_picture_together() {
    let (address, start, seen) = viewer();
    start.send(()).unwrap();
    let mut view = LiveView::start(address, "a name".into(), |error| panic!("{error}"));
    assert!(view.is_due());
    view.show(picture(130, 70, 0.0));
    view.show(picture(130, 70, 1.0));
    let mut last = picture(130, 70, 1.0);
    last.pixels_mut()[0] = Rgb::splat(7.0);
    view.show(last.clone());
    view.finish().unwrap();
    let seen = seen.join().unwrap();
    assert_eq!((seen.name.as_str(), seen.created), ("a name", 1));
    assert_eq!(seen.image(), last);
}

/// More than the buffers of a connection hold, to a viewer that reads nothing until all is handed over: if that waited for the
/// viewer, it would wait forever.
#[test]
fn a_viewer_that_does_not_read_holds_nobody_up() {
    let (address, start, seen) = viewer();
    let mut view = LiveView::start(address, "slow".into(), |error| panic!("{error}"));
    (0..5).for_each(|k| view.show(picture(2000, 1000, k as f32)));
    start.send(()).unwrap();
    // Where the machine is busy this gives up, and the viewer goes on.
    drop(view.finish());
    assert_eq!(seen.join().unwrap().image(), picture(2000, 1000, 4.0));
}

#[test]
fn an_absent_viewer_is_one_warning() {
    let address = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
    let (warned, warning) = mpsc::channel();
    let mut view = LiveView::start(address.into(), "nobody".into(), move |error| warned.send(error).unwrap());
    let told = warning.recv().unwrap().to_string();
    assert!(told.contains(&format!("no viewer answers at {address}: ")), "{told}");
    view.show(picture(3, 3, 0.0));
    assert!(!view.is_due());
    view.finish().unwrap();
    assert!(warning.recv().is_err(), "nothing more");
}

#[test]
fn a_viewer_that_vanishes_is_one_warning() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let (warned, warning) = mpsc::channel();
    let address = listener.local_addr().unwrap();
    let mut view = LiveView::start(address.into(), "a".into(), move |error| warned.send(error).unwrap());
    drop(listener.accept().unwrap());
    drop(listener);
    let told = loop {
        view.show(picture(500, 500, 0.0));
        view.show(picture(500, 500, 1.0));
        if let Ok(told) = warning.try_recv() {
            break told.to_string();
        }
    };
    assert!(told.contains(&format!("the viewer at {address} takes no more pictures: ")), "{told}");
    view.finish().unwrap();
}

#[test]
fn renders_are_shown_as_they_are_written() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("scene.toml");
    std::fs::write(&scene, common::GLASS_AND_LAMPS).unwrap();
    for (command, budget) in [("render", ["--passes", "2"]), ("reference", ["--spp", "2"])] {
        let (address, start, seen) = viewer();
        start.send(()).unwrap();
        let output = folder.path().join(command).with_extension("exr");
        #[rustfmt::skip]
        let done = Command::cargo_bin("caustica").unwrap()
            .arg(command).arg(&scene).arg("-o").arg(&output).args(budget)
            .args(["--display-server", &address.to_string()])
            .output().unwrap();
        assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
        let seen = seen.join().unwrap();
        assert_eq!(seen.name, "caustica scene");
        assert_eq!(seen.image(), read_exr(&output).unwrap(), "{command}");
    }
}

#[test]
fn a_render_goes_on_without_its_viewer() {
    let folder = tempfile::tempdir().unwrap();
    let (scene, output) = (folder.path().join("scene.toml"), folder.path().join("a.exr"));
    std::fs::write(&scene, common::GLASS_AND_LAMPS).unwrap();
    let port = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
    #[rustfmt::skip]
    let done = Command::cargo_bin("caustica").unwrap()
        .arg("render").arg(&scene).arg("-o").arg(&output)
        .args(["--passes", "2", "--display-server", &port.to_string()])
        .output().unwrap();
    let told = String::from_utf8(done.stderr).unwrap();
    assert!(done.status.success() && output.exists(), "{told}");
    assert_eq!(told.matches("no viewer answers at 127.0.0.1:").count(), 1, "{told}");
}
