//! Firefox by marionette: messages `LENGTH:JSON` over a socket.

use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use serde_json::{Value, json};

/// A browser with a session.
pub struct Firefox {
    child: Child,
    socket: TcpStream,
    count: u64,
}

impl Drop for Firefox {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl Firefox {
    /// A browser without a window; its profile lies in the folder.
    pub fn start(folder: &Path) -> Firefox {
        let profile = folder.join("firefox");
        std::fs::create_dir(&profile).unwrap();
        // A port that is free now, below those of clients: a client that tries one of these may connect to itself.
        let first = 20_000 + (std::process::id() % 10_000) as u16;
        let is_free = |port: &u16| TcpListener::bind(("127.0.0.1", *port)).is_ok();
        let port = (first..32_000).find(is_free).unwrap();
        let settings = format!("user_pref(\"marionette.port\", {port});\n");
        std::fs::write(profile.join("user.js"), settings).unwrap();
        let mut child = Command::new("firefox")
            .args(["--headless", "--marionette", "--no-remote", "--profile"])
            .arg(&profile)
            .env("HOME", folder)
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let socket = loop {
            if let Ok(socket) = TcpStream::connect(("127.0.0.1", port)) {
                break socket;
            }
            assert!(child.try_wait().unwrap().is_none(), "the browser ended");
            std::thread::sleep(Duration::from_millis(50));
        };
        let mut firefox = Firefox {
            child,
            socket,
            count: 0,
        };
        firefox.read(); // its greeting
        firefox.call("WebDriver:NewSession", json!({}));
        firefox
    }

    fn read(&mut self) -> Value {
        let mut length = 0;
        loop {
            let mut byte = [0];
            self.socket.read_exact(&mut byte).unwrap();
            match byte[0] {
                b':' => break,
                digit => length = 10 * length + usize::from(digit - b'0'),
            }
        }
        let mut text = vec![0; length];
        self.socket.read_exact(&mut text).unwrap();
        serde_json::from_slice(&text).unwrap()
    }

    fn call(&mut self, method: &str, params: Value) -> Value {
        self.count += 1;
        let message = json!([0, self.count, method, params]).to_string();
        write!(self.socket, "{}:{message}", message.len()).unwrap();
        let answer = self.read();
        assert!(answer[2].is_null(), "{method}: {answer}");
        answer[3].clone()
    }

    /// The value of an expression in the page.
    pub fn value(&mut self, expression: &str) -> Value {
        let script = json!({ "script": format!("return ({expression});"), "args": [] });
        self.call("WebDriver:ExecuteScript", script)["value"].clone()
    }

    /// Opens a page and waits until all is drawn.
    pub fn open(&mut self, address: &str) {
        self.call("WebDriver:Navigate", json!({ "url": "about:blank" }));
        self.call("WebDriver:Navigate", json!({ "url": address }));
        while self
            .value("document.documentElement.dataset.ready")
            .is_null()
        {
            std::thread::sleep(Duration::from_millis(20));
        }
    }
}
