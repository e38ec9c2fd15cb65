//! The page of a study in a real browser: no error, plots, a slider that moves, and no line that runs off the window.
#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

use std::fs;
use std::path::Path;
use std::time::Duration;

mod study_scene;

use study_scene::Studio;

/// Ahead of the page's own script.
const LISTEN: &str = "<script>
window.faults = [];
addEventListener('error', event => faults.push(event.message || 'a resource does not load'), true);
</script></head>";

/// After it: moves the slider and chooses another picture as a user does, and leaves what happened in the title.
const TRY: &str = "<script>
addEventListener('load', () => {
  const [slider, over, edge] = ['slider', 'over', 'edge'].map(id => document.getElementById(id));
  const see = () => [getComputedStyle(over).clipPath, edge.style.left];
  const before = see();
  slider.value = 25;
  slider.dispatchEvent(new Event('input'));
  const left = document.getElementById('left'), shown = over.src;
  left.value = 'picture-0';
  left.dispatchEvent(new Event('change'));
  const pictures = Array.from(document.images);
  document.title = 'tried ' + JSON.stringify({
    before, after: see(), faults,
    chosen: over.src !== shown && over.src === document.getElementById('picture-0').src,
    plots: document.querySelectorAll('svg').length,
    curves: document.querySelectorAll('svg circle').length,
    broken: pictures.filter(image => !image.complete || image.naturalWidth === 0).length,
    overflow: document.documentElement.scrollWidth - document.documentElement.clientWidth,
  });
});
</script></body>";

/// What the browser makes of the page in a window of this width, and what it has to complain of; `None`, with a
/// notice, where there is no browser.
fn browse(page: &Path, width: u32) -> Option<(String, String)> {
    let profile = tempfile::tempdir().unwrap();
    let output = assert_cmd::Command::new("chromium")
        .args(["--headless", "--no-sandbox", "--disable-gpu", "--enable-logging=stderr", "--dump-dom"])
        .args([format!("--window-size={width},900"), format!("--user-data-dir={}", profile.path().display())])
        .arg(format!("file://{}", page.display()))
        .timeout(Duration::from_secs(300))
        .output();
    match output {
        Ok(output) => {
            let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
            Some((text(&output.stdout), text(&output.stderr)))
        }
        Err(error) => {
            eprintln!("skipped: chromium cannot be run ({error}); Debian: chromium");
            None
        }
    }
}

#[test]
fn a_browser_shows_the_page_without_fault() {
    let studio = Studio::new();
    studio.study_to_the_end(&["--axes", "alpha,method", "--repetitions", "2", "--budget", "3"]);
    let html = fs::read_to_string(studio.path("study/study.html")).unwrap();
    let tried = html.replace("</head>", LISTEN).replace("</body>", TRY);
    assert_eq!(tried.matches("<script>").count(), 3);
    let page = studio.path("tried.html");
    fs::write(&page, tried).unwrap();
    for width in [1400, 420] {
        let Some((dom, log)) = browse(&page, width) else { return };
        assert!(!log.contains("CONSOLE"), "{log}");
        let title = dom.split("<title>tried ").nth(1).unwrap_or_else(|| panic!("nothing was tried:\n{log}"));
        let found: serde_json::Value = serde_json::from_str(title.split("</title>").next().unwrap()).unwrap();
        assert_eq!(found["before"], serde_json::json!(["inset(0px 50% 0px 0px)", "50%"]));
        assert_eq!(found["after"], serde_json::json!(["inset(0px 75% 0px 0px)", "25%"]), "the curtain moves");
        assert_eq!((&found["faults"], &found["chosen"]), (&serde_json::json!([]), &true.into()));
        assert_eq!((&found["plots"], &found["broken"]), (&html.matches("<svg").count().into(), &0.into()));
        assert!(found["plots"].as_u64().unwrap() >= 4, "the front, two axes and the variance");
        assert!(found["curves"].as_u64().unwrap() > 50, "points are drawn");
        assert_eq!(found["overflow"], 0, "nothing runs off a window of {width} pixels");
    }
}
