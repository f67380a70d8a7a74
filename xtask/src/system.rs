//! System programs and libraries that the tests use: found, installed where that can be done without asking, or named.

use anyhow::{Result, bail};

use crate::shell::{has, program, run, say};

/// A program and the Debian package that brings it.
struct Needed {
    program: &'static str,
    package: &'static str,
    why: &'static str,
}

const NEEDED: [Needed; 11] = [
    Needed { program: "cc", package: "gcc", why: "builds the C host" },
    Needed { program: "c++", package: "g++", why: "builds the H.264 decoder and C++ checks of the header" },
    Needed { program: "clang", package: "clang", why: "is the second compiler of the header's compile matrix" },
    Needed { program: "make", package: "make", why: "builds the article's host" },
    Needed { program: "cmake", package: "cmake", why: "builds the article's host" },
    Needed { program: "pkg-config", package: "pkg-config", why: "finds the installed library" },
    Needed { program: "valgrind", package: "valgrind", why: "watches the C programs run" },
    Needed { program: "abidiff", package: "abigail-tools", why: "compares the ABI with that of earlier releases" },
    Needed { program: "doxygen", package: "doxygen", why: "makes the C reference" },
    Needed { program: "nm", package: "binutils", why: "lists exported symbols" },
    Needed { program: "npm", package: "npm", why: "fetches the Khronos glTF validator, which runs on node" },
];

/// Drivers: they are no programs, and are found by the file that tells loaders of them.
const DRIVER: Needed =
    Needed { program: "a Vulkan driver", package: "mesa-vulkan-drivers", why: "draws as a GPU does, without one" };

/// What shows windows without a screen, and the hands that use them.
#[cfg(target_os = "linux")]
const DISPLAY: [Needed; 5] = [
    Needed { program: "Xvfb", package: "xvfb", why: "shows the studio's window without a screen" },
    Needed { program: "xdotool", package: "xdotool", why: "uses the studio by mouse and keyboard" },
    Needed { program: "libxkbcommon-x11.so.0", package: "libxkbcommon-x11-0", why: "reads the keyboard for windows" },
    Needed { program: "libXcursor.so.1", package: "libxcursor1", why: "shows the mouse in windows" },
    Needed { program: "libXi.so.6", package: "libxi6", why: "reads the mouse for windows" },
];
/// Other systems have one.
#[cfg(not(target_os = "linux"))]
const DISPLAY: [Needed; 0] = [];

impl Needed {
    fn is_there(&self) -> bool {
        if self.program.contains(".so.") {
            return library_is_there(self.program);
        }
        if self.program == "Xvfb" {
            // It has no --version.
            let path = std::env::var_os("PATH").unwrap_or_default();
            return std::env::split_paths(&path).any(|folder| folder.join(self.program).is_file());
        }
        if self.program != DRIVER.program {
            return has(self.program);
        }
        let folders = ["/usr/share/vulkan/icd.d", "/etc/vulkan/icd.d"];
        let holds = |folder: &&str| std::fs::read_dir(folder).is_ok_and(|mut files| files.next().is_some());
        // Elsewhere systems bring their own.
        !cfg!(target_os = "linux") || folders.iter().any(holds)
    }
}

/// Whether the loader would find a library.
fn library_is_there(name: &str) -> bool {
    ["/lib", "/usr/lib", "/lib64", "/usr/lib64", "/usr/local/lib"].iter().any(|folder| {
        // Debian keeps them a folder deeper, by the machine's kind.
        let deeper = std::fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
        deeper.chain([folder.into()]).any(|folder| folder.join(name).is_file())
    })
}

/// The browser that plays exports; large, so only who asks for players gets it.
pub(crate) const BROWSER: &str = "chromium";

/// Makes sure that every needed program is there: with apt-get as root, else by naming the packages.
pub(crate) fn ensure() -> Result<()> {
    ensure_all(&NEEDED)?;
    ensure_all(&[DRIVER])?;
    ensure_all(&DISPLAY)
}

/// The same for what plays exports.
pub(crate) fn ensure_browser() -> Result<()> {
    ensure_all(&[
        Needed { program: BROWSER, package: "chromium", why: "plays glTF and Lottie" },
        Needed { program: "npm", package: "npm", why: "fetches players, which run on node" },
    ])
}

fn ensure_all(needed: &[Needed]) -> Result<()> {
    let missing: Vec<&Needed> = needed.iter().filter(|n| !n.is_there()).collect();
    if missing.is_empty() {
        return Ok(());
    }
    for needed in &missing {
        say(&format!("missing: {} ({})", needed.program, needed.why));
    }
    let packages: Vec<&str> = missing.iter().map(|n| n.package).collect();
    let root = crate::shell::read(program("id").arg("-u")).is_ok_and(|id| id.trim() == "0");
    if !(root && has("apt-get")) {
        bail!("install these programs, on Debian or Ubuntu by: sudo apt-get install {}", packages.join(" "));
    }
    run(program("apt-get").arg("update").arg("-qq"))?;
    let mut install = program("apt-get");
    install.env("DEBIAN_FRONTEND", "noninteractive");
    run(install.args(["install", "-y", "-qq", "--no-install-recommends"]).args(&packages))?;
    match missing.iter().find(|n| !n.is_there()) {
        None => Ok(()),
        Some(still) => bail!("{} is still missing after installing {}", still.program, still.package),
    }
}
