//! The report as a reader meets it: opened in a browser, by mouse, by keyboard, printed, and without JavaScript.
#![allow(clippy::unwrap_used, reason = "a test that cannot be set up has failed")]
#![allow(clippy::print_stdout, reason = "a test tells its figures")]

mod browser;
mod common;

use std::path::PathBuf;

use browser::{Browser, address_of};
use common::{Folder, example, paper};
use serde_json::{Value, json};

/// A page about a measurement file, by the name of an example.
fn report(folder: &Folder, measurement: &str, arguments: &[&str]) -> PathBuf {
    std::fs::write(folder.0.path().join("m.toml"), measurement).unwrap();
    let result = folder.run(&[&["locate", "m.toml", "--format", "json"], arguments].concat(), b"");
    assert!(result.status.success(), "{result:?}");
    let page = folder.run(&["report", "-", "-o", "report.html"], &result.stdout);
    assert!(page.status.success(), "{page:?}");
    folder.0.path().join("report.html")
}

/// How many elements that a selector finds have any height.
fn seen(browser: &mut Browser, selector: &str) -> u64 {
    let seen = format!(
        "[...document.querySelectorAll({})].filter((one) => one.getBoundingClientRect().height > 0).length",
        json!(selector)
    );
    browser.evaluate(&seen).as_u64().unwrap()
}

/// How many pixels of the view are drawn, and of how many colours they are.
const DRAWN: &str = "(() => { const view = document.getElementById('view'); \
    const { data } = view.getContext('2d').getImageData(0, 0, view.width, view.height); \
    const colours = new Set(); let drawn = 0; \
    for (let k = 0; k < data.length; k += 4) if (data[k + 3]) { drawn += 1; colours.add(data[k] << 16 | data[k + 1] << 8 | data[k + 2]); } \
    return [drawn * 4 / data.length, colours.size] })()";

/// The view, as text that is another one whenever a pixel is.
const VIEW: &str = "document.getElementById('view').toDataURL()";

/// What is said of the touch that is chosen.
const TOLD: &str = "document.getElementById('told').textContent";

/// Where in the window the chosen touch is drawn: the middle of what has the colour of the focus.
const CHOSEN: &str = "(() => { const view = document.getElementById('view'); const box = view.getBoundingClientRect(); \
    const probe = document.createElement('i'); probe.className = 'colour-chosen'; document.body.append(probe); \
    const [r, g, b] = getComputedStyle(probe).color.match(/\\d+/g).map(Number); probe.remove(); \
    const { data, width } = view.getContext('2d').getImageData(0, 0, view.width, view.height); \
    let [x, y, count] = [0, 0, 0]; \
    for (let k = 0; k < data.length; k += 4) if (data[k] === r && data[k + 1] === g && data[k + 2] === b) \
    { count += 1; x += k / 4 % width; y += Math.floor(k / 4 / width); } \
    const dense = width / box.width; return [box.x + x / count / dense, box.y + y / count / dense, count] })()";

#[test]
fn the_page_opens_by_itself_and_at_once() {
    /// Milliseconds, on a machine that does something else, too: a tenth of it when idle.
    const SOON: f64 = 1000.0;
    let (folder, mut browser) = (Folder::new(), Browser::start());
    for (name, arguments) in
        [("nederbragt-ravani.toml", &[][..]), ("three-sphere.toml", &[]), ("bore-and-faces.toml", &[])]
    {
        let page = report(&folder, &example(name), arguments);
        browser.open(&page);
        let loaded = browser.number("performance.getEntriesByType('navigation')[0].loadEventEnd");
        let drawn = browser.evaluate(DRAWN);
        let [drawn, colours] = [0, 1].map(|k| drawn[k].as_f64().unwrap());
        println!("{name}: {loaded:.0} ms, {:.0} % drawn, {colours} colours", 100.0 * drawn);
        assert!(loaded < SOON, "{name}: {loaded} ms");
        assert!(drawn > 0.05 && colours > 20.0, "{name}: {drawn} of the view drawn, {colours} colours");
        assert_eq!(browser.requests(), [address_of(&page)]);
        assert!(browser.complaints().is_empty(), "{name}: {:?}", browser.complaints());
    }
}

/// What the other tests rely on: a page that does wrong is seen to.
#[test]
fn a_page_that_does_wrong_is_noticed() {
    let folder = Folder::new().with(
        "bad.html",
        "<meta http-equiv='Content-Security-Policy' content=\"default-src 'none'; img-src *\">\
         <img src='http://127.0.0.1:9/x.png'><script>document.title = 'ran'</script>",
    );
    let mut browser = Browser::start();
    let page = folder.0.path().join("bad.html");
    browser.open(&page);
    assert_eq!(browser.requests(), [address_of(&page).as_str(), "http://127.0.0.1:9/x.png"]);
    assert_ne!(browser.text("document.title"), "ran");
    assert!(browser.complaints().iter().any(|event| event.to_string().contains("Content Security Policy")));
    browser.evaluate("void console.error('seen')");
    assert!(browser.complaints().iter().any(|event| event.to_string().contains("seen")));
}

#[test]
fn the_view_answers_keys_and_mouse() {
    let (folder, mut browser) = (Folder::new(), Browser::start());
    browser.open(&report(&folder, &paper(), &[]));
    // Without a mouse: by the tabulator to the view.
    let focused = "document.activeElement.id";
    for _ in 0..40 {
        if browser.text(focused) == "view" {
            break;
        }
        browser.press("Tab");
    }
    assert_eq!(browser.text(focused), "view");
    let first = browser.text(VIEW);
    for key in ["ArrowLeft", "ArrowUp", "+", "-"] {
        let before = browser.text(VIEW);
        browser.press(key);
        assert_ne!(browser.text(VIEW), before, "{key}");
    }
    browser.press("Home");
    assert_eq!(browser.text(VIEW), first);

    for (key, touch) in [("]", 0), ("n", 1), ("]", 2), ("[", 1), ("p", 0), ("p", 6)] {
        browser.press(key);
        let told = browser.text(TOLD);
        assert!(told.starts_with(&format!("touch {touch} `x{}` on ", touch + 1)), "{key}: {told}");
    }
    assert_eq!(browser.text("document.getElementById('told').getAttribute('aria-live')"), "polite");

    // By mouse: what lies where a touch is drawn is that touch.
    browser.press("0");
    browser.press("n");
    let (told, at) = (browser.text(TOLD), browser.evaluate(CHOSEN));
    let at = [0, 1, 2].map(|k| at[k].as_f64().unwrap_or_else(|| panic!("{at}")));
    assert!(at[2] > 20.0, "the chosen touch is drawn: {at:?}");
    browser.press("Escape");
    assert_eq!(browser.text(TOLD), "");
    browser.point_at(at[0] + 2.0, at[1] - 2.0);
    assert_eq!(browser.text(TOLD), told);
    assert!(browser.complaints().is_empty(), "{:?}", browser.complaints());
}

#[test]
fn copy_buttons_copy() {
    let (folder, mut browser) = (Folder::new(), Browser::start());
    browser.open(&report(&folder, &paper(), &[]));
    let permissions = json!(["clipboardReadWrite", "clipboardSanitizedWrite"]);
    browser.call("Browser.grantPermissions", json!({ "permissions": permissions }));
    browser.call("Emulation.setFocusEmulationEnabled", json!({ "enabled": true }));
    browser.click("[aria-label='copy the frame for kuka']");
    let copied = browser.text("navigator.clipboard.readText()");
    assert!(copied.starts_with("{X 2.9000,Y 3.8000,Z 4.2249,A "), "{copied}");
    let said = "document.querySelector(\"[aria-label='copy the frame for kuka']\").textContent";
    assert_eq!(browser.text(said), "copied");

    // The browser's own hash of what it copied is the one on the page.
    browser.click("#raw button");
    let hash = browser.text(
        "navigator.clipboard.readText().then((text) => crypto.subtle.digest('SHA-256', new TextEncoder().encode(text)))\
         .then((hash) => [...new Uint8Array(hash)].map((byte) => byte.toString(16).padStart(2, '0')).join(''))",
    );
    assert_eq!(browser.text("document.getElementById('hash').textContent"), hash);
}

#[test]
fn light_dark_and_paper() {
    let (folder, mut browser) = (Folder::new(), Browser::start());
    browser.open(&report(&folder, &paper(), &[]));
    let scheme = |browser: &mut Browser, scheme: &str| {
        let features = json!([{ "name": "prefers-color-scheme", "value": scheme }]);
        browser.call("Emulation.setEmulatedMedia", json!({ "media": "screen", "features": features }));
        let paper = browser.text("getComputedStyle(document.body).backgroundColor");
        (paper, browser.text(VIEW))
    };
    let (light, dark) = (scheme(&mut browser, "light"), scheme(&mut browser, "dark"));
    assert_eq!((light.0.as_str(), dark.0.as_str()), ("rgb(255, 255, 255)", "rgb(20, 24, 29)"));
    assert_ne!(light.1, dark.1, "the view has the colours of the page");
    browser.click("#scheme");
    assert_eq!((browser.text("getComputedStyle(document.body).backgroundColor"), browser.text(VIEW)), light);

    // On paper it is light whatever the screen was, and the drawing takes the place of the view.
    browser.click("#scheme");
    browser.call("Emulation.setEmulatedMedia", json!({ "media": "print" }));
    assert_eq!(browser.text("getComputedStyle(document.body).backgroundColor"), light.0);
    assert_eq!(seen(&mut browser, "canvas, button"), 0);
    assert_eq!(seen(&mut browser, "svg.scene"), 1);
    let pdf = browser.call("Page.printToPDF", json!({ "preferCSSPageSize": true }));
    assert!(pdf["data"].as_str().unwrap().len() > 50_000);
}

#[test]
fn without_javascript_all_is_there() {
    let (folder, mut browser) = (Folder::new(), Browser::start());
    let page = report(&folder, &paper(), &[]);
    browser.call("Emulation.setScriptExecutionDisabled", json!({ "value": true }));
    browser.open(&page);
    assert_eq!(browser.evaluate("document.documentElement.classList.contains('live')"), Value::Bool(false));
    assert_eq!(seen(&mut browser, ".headline"), 1);
    assert_eq!(seen(&mut browser, "svg.scene"), 1);
    assert!(seen(&mut browser, "svg.scene path") > 50);
    assert!(seen(&mut browser, "table") >= 9);
    assert!(seen(&mut browser, "pre") > 20);
    assert_eq!(seen(&mut browser, "button, canvas"), 0, "what would do nothing is not shown");
}
