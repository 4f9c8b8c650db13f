"""Pictures of the documentation, made anew by a build.

    python3 tools/pictures.py PROGRAM

Figures are the files of --svg; pictures of pages are taken by Chromium, which is driven over its pipe. Look at every picture before it is
committed.
"""

import base64
import json
import os
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
PICTURES = ROOT / "docs/pictures"

# Picture, command, end of the name of its SVG file.
FIGURES = [
    ("bevel_te", "gear models/gears/bevel_12_36.toml", "-te"),
    ("noise_mesh", "gear models/gears/stage_28_56_relieved.toml --torques 50:500:10", "-mesh"),
    ("noise_harris", "gear models/gears/stage_28_56_relieved.toml --torques 50:500:10", "-harris"),
    ("noise_run_up_plain", "response examples/tip_relief_plain.toml --run-up 200:6000:120 --output pair.force", ""),
    ("noise_run_up_relieved", "response examples/tip_relief_relieved.toml --run-up 200:6000:120 --output pair.force", ""),
]

# Picture, command, first and last element shown, height at most.
PAGES = [
    ("report", "identify data/spindle_impact.csv --input force --output ax,ay", "header", "section", 1040),
    ("modes", "modes models/lin_parker_n3.toml", ".view", ".drawing", 840),
    ("gears", "gear models/gears/bevel_12_36.toml --vh", ".pair", ".pair", 700),
    ("cut", "gear cut models/gears/bevel_12_36.toml", ".view", ".view", 520),
]


class Browser:
    """Chromium over two pipes: messages are JSON, each ended by a zero byte."""

    def __init__(self, folder):
        read, self.to = os.pipe()
        self.answers, write = os.pipe()
        command = (
            "exec chromium --headless --no-sandbox --enable-unsafe-swiftshader --no-first-run --hide-scrollbars "
            f"--user-data-dir={folder} --remote-debugging-pipe about:blank 3<&{read} 4>&{write} 2>/dev/null"
        )
        self.process = subprocess.Popen(["bash", "-c", command], pass_fds=(read, write))
        self.rest, self.count, self.session = b"", 0, None
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        self.session = self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        self.call("Page.enable")
        self.call("Emulation.setDeviceMetricsOverride", width=1000, height=900, deviceScaleFactor=1, mobile=False)
        still = {"name": "prefers-reduced-motion", "value": "reduce"}
        self.call("Emulation.setEmulatedMedia", features=[still, {"name": "prefers-color-scheme", "value": "light"}])

    def call(self, method, **params):
        self.count += 1
        session = {"sessionId": self.session} if self.session else {}
        message = json.dumps({"id": self.count, "method": method, "params": params, **session})
        os.write(self.to, message.encode() + b"\0")
        while True:
            while b"\0" not in self.rest:
                self.rest += os.read(self.answers, 1 << 20)
            answer, self.rest = self.rest.split(b"\0", 1)
            answer = json.loads(answer)
            if answer.get("id") == self.count:
                return answer["result"]

    def value(self, expression):
        found = self.call("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
        return found["result"].get("value")

    def picture(self, page, first, last, most):
        """The page from the first element to the last one, at most so high, as PNG."""
        self.call("Page.navigate", url=page.as_uri())
        self.value("new Promise((d) => { const l = () => document.documentElement?.dataset.ready ? d() : setTimeout(l, 20); l(); })")
        top, foot = (
            self.value(f"document.querySelector('{which}').getBoundingClientRect().{edge}")
            for which, edge in ((first, "top"), (last, "bottom"))
        )
        clip = {"x": 15, "y": max(top - 8, 0), "width": 970, "height": min(foot - top + 16, most), "scale": 1}
        shot = self.call("Page.captureScreenshot", format="png", captureBeyondViewport=True, clip=clip)
        return base64.b64decode(shot["data"])


def run(program, arguments, option, path):
    line = [program, *arguments.split(), option, path, "--quiet"]
    subprocess.run(line, cwd=ROOT, stdout=subprocess.DEVNULL, check=True)


def main():
    program = str(pathlib.Path(sys.argv[1]).resolve())
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        folder = pathlib.Path(folder)
        for name, arguments, end in FIGURES:
            run(program, arguments, "--svg", str(folder / f"{name}.svg"))
            (PICTURES / f"{name}.svg").write_bytes((folder / f"{name}{end}.svg").read_bytes())
        browser = Browser(folder / "profile")
        for name, arguments, first, last, most in PAGES:
            page = folder / f"{name}.html"
            run(program, arguments, "--html", str(page))
            # The head of the page names the command without the folder of this run.
            page.write_text(page.read_text().replace(f"{folder}/", "").replace(" --quiet", ""))
            (PICTURES / f"{name}.png").write_bytes(browser.picture(page, first, last, most))
        browser.process.terminate()
        browser.process.wait()


if __name__ == "__main__":
    main()
