//! Chromium with one page, driven by the DevTools protocol over a pipe. Pictures are drawn by
//! software, so that no graphics card is needed.

use crate::tools;
use crate::variable;
use base64::{Engine, prelude::BASE64_STANDARD};
use serde_json::{Value, json};
use std::fmt::Display;
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// Interval between two looks at the page.
const LOOK_EVERY: Duration = Duration::from_millis(100);

fn limit() -> Duration {
    Duration::from_secs(variable("CRUMPLE_TEST_LIMIT", 240))
}

/// A browser with one page.
pub struct Browser {
    child: Child,
    to: ChildStdin,
    from: Receiver<Value>,
    sent: u64,
    session: String,
    problems: Vec<String>,
    _profile: TempDir,
}

impl Browser {
    /// Starts the browser; else see [`tools::or_skip`].
    ///
    /// # Panics
    /// When it does not start.
    pub fn start() -> Option<Self> {
        let browser = tools::chromium()?;
        let profile = tempfile::tempdir().expect("a temporary folder");
        // The protocol is spoken on the file descriptors 3 and 4.
        let mut command = Command::new("sh");
        command.args(["-c", "exec \"$0\" \"$@\" 3<&0 4>&1 >/dev/null"]).arg(browser).args([
            "--headless=new",
            "--no-sandbox",
            "--use-gl=angle",
            "--use-angle=swiftshader",
            "--enable-unsafe-swiftshader",
            "--disable-dev-shm-usage",
            "--remote-debugging-pipe",
        ]);
        command.arg(format!("--user-data-dir={}", profile.path().display()));
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::null());
        let mut child = command.spawn().expect("sh starts");
        let (to, out) = (child.stdin.take().unwrap(), child.stdout.take().unwrap());
        let (sender, from) = channel();
        std::thread::spawn(move || {
            let messages = BufReader::new(out).split(0).map_while(Result::ok);
            for message in messages.filter_map(|m| serde_json::from_slice::<Value>(&m).ok()) {
                if sender.send(message).is_err() {
                    return;
                }
            }
        });
        let (session, problems) = (String::new(), Vec::new());
        let mut page = Self { child, to, from, sent: 0, session, problems, _profile: profile };
        let target = page.call("Target.createTarget", json!({"url": "about:blank"}));
        let attach = json!({"targetId": target["targetId"], "flatten": true});
        let attached = page.call("Target.attachToTarget", attach);
        page.session = attached["sessionId"].as_str().expect("a session").into();
        for domain in ["Runtime", "Page", "Log", "DOM"] {
            page.call(&format!("{domain}.enable"), json!({}));
        }
        page.resize(1400, 900);
        Some(page)
    }

    /// Calls a method of the protocol and returns its result.
    fn call(&mut self, method: &str, params: Value) -> Value {
        self.sent += 1;
        let mut message = json!({"id": self.sent, "method": method, "params": params});
        if !self.session.is_empty() {
            message["sessionId"] = json!(self.session);
        }
        self.to.write_all(message.to_string().as_bytes()).expect("the browser reads");
        self.to.write_all(&[0]).expect("the browser reads");
        let began = Instant::now();
        loop {
            let left = limit().saturating_sub(began.elapsed());
            let answer = match self.from.recv_timeout(left) {
                Ok(answer) => answer,
                Err(RecvTimeoutError::Timeout) => panic!("{method}: no answer"),
                Err(RecvTimeoutError::Disconnected) => panic!("{method}: the browser has ended"),
            };
            if answer["id"] == json!(self.sent) {
                assert!(answer["error"].is_null(), "{method}: {}", answer["error"]);
                return answer["result"].clone();
            }
            self.problems.extend(problem(&answer));
        }
    }

    /// Returns errors of scripts, of the console and of the network so far.
    pub fn problems(&mut self) -> Vec<String> {
        self.evaluate("0"); // what came before it has been read
        self.problems.clone()
    }

    /// Opens an address.
    pub fn open(&mut self, url: &str) {
        self.call("Page.navigate", json!({"url": url}));
    }

    /// Sets the size of the page [pixels].
    pub fn resize(&mut self, width: u32, height: u32) {
        let mobile = width < 600;
        let size =
            json!({"width": width, "height": height, "deviceScaleFactor": 1, "mobile": mobile});
        self.call("Emulation.setDeviceMetricsOverride", size);
    }

    /// Lets the page be dark or light.
    pub fn darken(&mut self, dark: bool) {
        let value = if dark { "dark" } else { "light" };
        let feature = json!({"name": "prefers-color-scheme", "value": value});
        self.call("Emulation.setEmulatedMedia", json!({"features": [feature]}));
    }

    /// Lets the page be as on paper, or as on a screen.
    pub fn print_media(&mut self, print: bool) {
        let media = if print { "print" } else { "screen" };
        self.call("Emulation.setEmulatedMedia", json!({"media": media}));
    }

    /// Saves files of the page into a folder.
    pub fn keep_downloads(&mut self, folder: &Path) {
        let params = json!({"behavior": "allow", "downloadPath": folder});
        self.call("Page.setDownloadBehavior", params);
    }

    /// Returns the page as PDF, on A4.
    pub fn printed(&mut self) -> Vec<u8> {
        let paper = json!({"paperWidth": 8.27, "paperHeight": 11.69});
        let printed = self.call("Page.printToPDF", paper);
        let bytes = BASE64_STANDARD.decode(printed["data"].as_str().unwrap_or_default());
        bytes.expect("base64")
    }

    /// Returns the value of an expression.
    ///
    /// # Panics
    /// When it throws.
    pub fn evaluate(&mut self, script: &str) -> Value {
        self.value_of(script).unwrap_or_else(|thrown| panic!("{script}: {thrown}"))
    }

    fn value_of(&mut self, script: &str) -> Result<Value, Value> {
        let params = json!({"expression": script, "returnByValue": true, "awaitPromise": true});
        let result = self.call("Runtime.evaluate", params);
        let thrown = &result["exceptionDetails"];
        if thrown.is_null() { Ok(result["result"]["value"].clone()) } else { Err(thrown.clone()) }
    }

    /// Waits until an expression is neither false nor null nor throws, as on a page that is being
    /// loaded, and returns its value.
    ///
    /// # Panics
    /// When the deadline has passed.
    pub fn wait(&mut self, what: impl Display, script: &str) -> Value {
        let began = Instant::now();
        loop {
            let value = self.value_of(script).unwrap_or_default();
            if !value.is_null() && value != json!(false) {
                return value;
            }
            if began.elapsed() > limit() {
                let text = self.evaluate("document.body.innerText");
                panic!("still waiting until {what}: {text}, {:?}", self.problems);
            }
            std::thread::sleep(LOOK_EVERY);
        }
    }

    /// Presses and releases the mouse in the middle of an element, when it has stopped moving: the
    /// page may still be growing.
    ///
    /// # Panics
    /// When there is none, or it is hidden.
    pub fn click(&mut self, selector: &str) {
        let script = format!(
            "(async () => {{ const e = document.querySelector({selector:?}); const place = () => \
             {{ e.scrollIntoView({{block: 'center'}}); const b = e.getBoundingClientRect(); return \
             b.width ? [b.x + b.width / 2, b.y + b.height / 2] : null; }}; let before; let now = \
             place(); for (let i = 0; i < 50 && `${{now}}` !== `${{before}}`; i++) {{ before = \
             now; await new Promise((done) => setTimeout(done, 100)); now = place(); }} return \
             now; }})()"
        );
        let at = self.evaluate(&script);
        assert!(at.is_array(), "{selector} is hidden");
        for kind in ["mousePressed", "mouseReleased"] {
            let event =
                json!({"type": kind, "x": at[0], "y": at[1], "button": "left", "clickCount": 1});
            self.call("Input.dispatchMouseEvent", event);
        }
    }

    /// Presses and releases a key by its name, such as `Home` or `Shift+ArrowLeft`.
    pub fn press(&mut self, key: &str) {
        let (key, modifiers) = match key.strip_prefix("Shift+") {
            Some(key) => (key, 8),
            None => (key, 0),
        };
        let code = match key {
            "Enter" => 13,
            "Home" => 36,
            "ArrowLeft" => 37,
            "ArrowUp" => 38,
            "ArrowRight" => 39,
            "ArrowDown" => 40,
            "Tab" => 9,
            "Escape" => 27,
            _ => 0,
        };
        let text = if key == "Enter" { "\r" } else { "" };
        for kind in ["keyDown", "keyUp"] {
            let event = json!({"type": kind, "key": key, "windowsVirtualKeyCode": code,
                               "text": text, "modifiers": modifiers});
            self.call("Input.dispatchKeyEvent", event);
        }
    }

    /// Chooses files in an input.
    pub fn choose(&mut self, selector: &str, files: &[PathBuf]) {
        let root = self.call("DOM.getDocument", json!({}))["root"]["nodeId"].clone();
        let query = json!({"nodeId": root, "selector": selector});
        let node = self.call("DOM.querySelector", query)["nodeId"].clone();
        self.call("DOM.setFileInputFiles", json!({"nodeId": node, "files": files}));
    }

    /// Returns the page as PNG. With a folder in `CRUMPLE_SCREENSHOTS` it is also written there.
    ///
    /// # Panics
    /// When the file cannot be written.
    pub fn picture(&mut self, name: &str) -> Vec<u8> {
        let taken = self.call("Page.captureScreenshot", json!({"captureBeyondViewport": true}));
        let bytes = BASE64_STANDARD.decode(taken["data"].as_str().unwrap_or_default());
        let bytes = bytes.expect("base64");
        if let Some(folder) = std::env::var_os("CRUMPLE_SCREENSHOTS") {
            std::fs::write(Path::new(&folder).join(format!("{name}.png")), &bytes).unwrap();
        }
        bytes
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Returns what an event of the protocol says is wrong.
fn problem(event: &Value) -> Option<String> {
    let params = &event["params"];
    match event["method"].as_str()? {
        "Runtime.exceptionThrown" => {
            let details = &params["exceptionDetails"];
            Some(format!("{} {}", details["text"], details["exception"]["description"]))
        }
        "Runtime.consoleAPICalled" if params["type"] == "error" => Some(params["args"].to_string()),
        "Log.entryAdded" if params["entry"]["level"] == "error" => {
            Some(params["entry"].to_string())
        }
        _ => None,
    }
}
