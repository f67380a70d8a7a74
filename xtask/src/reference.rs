//! `cargo xtask docs`: the C library's reference and articles as pages in target/docs/html, by doxygen. Any warning is an
//! error: an undocumented parameter, a link that leads nowhere.

use anyhow::{Result, ensure};

use crate::shell::{program, root, say, target};

pub(crate) fn run() -> Result<()> {
    let out = target().join("docs");
    std::fs::create_dir_all(&out)?;
    let settings = std::fs::read_to_string(root().join("docs/c/Doxyfile"))?;
    let file = out.join("Doxyfile");
    let [major, minor, patch] = crate::header::version();
    std::fs::write(
        &file,
        format!("{settings}\nOUTPUT_DIRECTORY = {}\nPROJECT_NUMBER = {major}.{minor}.{patch}\n", out.display()),
    )?;
    let output = program("doxygen").arg(&file).output()?;
    let said = String::from_utf8_lossy(&output.stderr);
    ensure!(output.status.success() && said.trim().is_empty(), "doxygen:\n{said}");
    say(&format!("the C reference: {}", out.join("html/index.html").display()));
    Ok(())
}
