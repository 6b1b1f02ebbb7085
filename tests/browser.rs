//! A Chromium without a window: what a page does, and what is to be seen of it.

use std::collections::BTreeSet;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// What draws in 3D where there is no graphics card.
const SOFT: [&str; 3] = ["--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"];
const SIZE: (usize, usize) = (1280, 800);

/// A Chromium on this machine: `CHROMIUM` or one of the usual names. Without one, says that the test is skipped.
pub(crate) fn chromium() -> Option<PathBuf> {
    let asked = std::env::var_os("CHROMIUM").map(PathBuf::from);
    let names = ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable"];
    let path = std::env::var_os("PATH").unwrap_or_default();
    let found =
        names.iter().flat_map(|name| std::env::split_paths(&path).map(move |folder| folder.join(name)));
    let found = asked.into_iter().chain(found).find(|program| program.is_file());
    if found.is_none() {
        eprintln!("skipped: no Chromium found; set CHROMIUM to its path");
    }
    found
}

/// Opens a page as a double click would and waits until some seconds of its time are over; gives
/// what the browser wrote, and the page's console.
fn open(browser: &Path, page: &Path, fragment: &str, flags: &[&str]) -> (String, String) {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name);
    let output = |name: &str| Stdio::from(File::create(file(name)).unwrap());
    let mut child = Command::new(browser)
        .args(["--headless", "--no-sandbox", "--disable-background-networking", "--disable-component-update"])
        .args(["--disable-dev-shm-usage", "--no-first-run", "--enable-logging=stderr"])
        .args(["--virtual-time-budget=4000", "--hide-scrollbars"])
        .arg(format!("--window-size={},{}", SIZE.0, SIZE.1))
        .args(flags)
        .arg(format!("--user-data-dir={}", folder.path().display()))
        .arg(format!("file://{}{fragment}", page.display()))
        .stdout(output("out"))
        .stderr(output("log"))
        .spawn()
        .unwrap();
    let start = Instant::now();
    while child.try_wait().unwrap().is_none() {
        if start.elapsed() > Duration::from_secs(150) {
            child.kill().unwrap();
            child.wait().unwrap();
            panic!("the browser did not end");
        }
        std::thread::sleep(Duration::from_millis(50));
    }
    let read = |name: &str| String::from_utf8_lossy(&std::fs::read(file(name)).unwrap()).into_owned();
    let log = read("log");
    let console: Vec<&str> = log.lines().filter(|line| line.contains("CONSOLE")).collect();
    (read("out"), console.join("\n"))
}

/// The elements of a page after some seconds; it must have written nothing to the console.
pub(crate) fn elements(browser: &Path, page: &Path, fragment: &str, in_3d: bool) -> String {
    let flags: &[&str] = if in_3d { &SOFT } else { &["--disable-3d-apis"] };
    let (dom, console) = open(browser, page, fragment, &[flags, &["--dump-dom"]].concat());
    if in_3d {
        assert_eq!(console, "");
    }
    dom
}

/// A data attribute of the root element.
pub(crate) fn told<'a>(dom: &'a str, name: &str) -> &'a str {
    let tag = dom.split_once("<html").and_then(|(_, rest)| rest.split_once('>')).map_or("", |(tag, _)| tag);
    let value = tag.split_once(&format!("data-{name}=\"")).and_then(|(_, rest)| rest.split_once('"'));
    value.map_or("", |(value, _)| value)
}

/// A picture of a page.
pub(crate) struct Picture {
    width: usize,
    /// Three bytes a pixel.
    pixels: Vec<[u8; 3]>,
}

/// What is to be seen of a page; it must have written nothing to the console.
pub(crate) fn picture(browser: &Path, page: &Path, fragment: &str) -> Picture {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("page.png");
    let screenshot = format!("--screenshot={}", file.display());
    let (_, console) = open(browser, page, fragment, &[&SOFT[..], &[&screenshot]].concat());
    assert_eq!(console, "");
    Picture::read(&std::fs::read(file).unwrap())
}

impl Picture {
    /// Reads what Chromium writes: a PNG of 8 bits a channel, not interlaced.
    fn read(png: &[u8]) -> Self {
        let number = |at: usize| u32::from_be_bytes(png[at..at + 4].try_into().unwrap()) as usize;
        let (width, height) = (number(16), number(20));
        assert_eq!((png[24], png[28]), (8, 0), "bits a channel, interlacing");
        let channels = match png[25] {
            2 => 3,
            6 => 4,
            other => panic!("colour type {other}"),
        };
        let (mut packed, mut at) = (Vec::new(), 8);
        while at < png.len() {
            let length = number(at);
            if &png[at + 4..at + 8] == b"IDAT" {
                packed.extend_from_slice(&png[at + 8..at + 8 + length]);
            }
            at += length + 12;
        }
        let mut bytes = Vec::new();
        flate2::read::ZlibDecoder::new(packed.as_slice()).read_to_end(&mut bytes).unwrap();
        let mut above = vec![0_u8; width * channels];
        let mut pixels = Vec::with_capacity(width * height);
        for line in bytes.chunks_exact(1 + width * channels) {
            let mut row = line[1..].to_vec();
            for i in 0..row.len() {
                let left = if i < channels { 0 } else { row[i - channels] };
                let corner = if i < channels { 0 } else { above[i - channels] };
                let guess = match line[0] {
                    0 => 0,
                    1 => left,
                    2 => above[i],
                    3 => left.midpoint(above[i]),
                    _ => nearest(left, above[i], corner),
                };
                row[i] = row[i].wrapping_add(guess);
            }
            pixels.extend(row.chunks_exact(channels).map(|pixel| [pixel[0], pixel[1], pixel[2]]));
            above = row;
        }
        assert_eq!(pixels.len(), width * height);
        Self { width, pixels }
    }

    /// The middle of the 3D view: no texts, no buttons.
    fn middle(&self) -> impl Iterator<Item = [u8; 3]> {
        (100..500).flat_map(move |y| (150..800).map(move |x| self.pixels[y * self.width + x]))
    }

    /// How many colours there are in the middle of the 3D view.
    pub(crate) fn colours(&self) -> usize {
        self.middle().collect::<BTreeSet<_>>().len()
    }

    /// The share of the middle of the 3D view in which it is clearly unlike another picture.
    pub(crate) fn unlike(&self, other: &Self) -> f64 {
        let apart = |(a, b): ([u8; 3], [u8; 3])| a.iter().zip(&b).any(|(a, b)| a.abs_diff(*b) > 24);
        let unlike = self.middle().zip(other.middle()).filter(|pair| apart(*pair)).count();
        unlike as f64 / self.middle().count() as f64
    }
}

/// The predictor of PNG's last filter: of three neighbours, the one nearest to their plane.
fn nearest(left: u8, above: u8, corner: u8) -> u8 {
    let plane = i32::from(left) + i32::from(above) - i32::from(corner);
    let apart = |x: u8| (plane - i32::from(x)).abs();
    if apart(left) <= apart(above) && apart(left) <= apart(corner) {
        left
    } else if apart(above) <= apart(corner) {
        above
    } else {
        corner
    }
}
