//! The pictures of docs/sketches.md, made anew by the commands that it gives. Motions that they need on the way lie in a
//! folder of their own.

use std::path::Path;

use anyhow::{Context as _, Result, ensure};

use crate::c_host::fresh;
use crate::shell::{cargo, program, read, root, run, say, target};

pub(crate) fn gallery() -> Result<()> {
    let article = std::fs::read_to_string(root().join("docs/sketches.md"))?;
    run(cargo().args(["build", "--release", "--locked", "-p", "marey-cli"]))?;
    let marey = target().join("release/marey").display().to_string();
    let aside = fresh("gallery")?;
    std::fs::create_dir_all(root().join("docs/pictures"))?;
    let blocks = article.split("```sh\n").skip(1).filter_map(|b| b.split_once("```"));
    let mut made = 0;
    for line in blocks.flat_map(|(block, _)| block.lines()).filter(|l| !l.trim().is_empty()) {
        let words = line.strip_prefix("marey ").with_context(|| format!("sketches.md: no command of marey: {line}"))?;
        // Motions are written and read aside; everything else is named from the root.
        let place = |word: &str| if is_aside(word) { aside.join(word).display().to_string() } else { word.to_owned() };
        read(program(&marey).args(words.split(' ').map(place)))?;
        made += 1;
    }
    ensure!(made > 0, "sketches.md has no commands");
    for picture in article.split("](").skip(1).filter_map(|p| p.split_once(')')).map(|p| p.0) {
        ensure!(root().join("docs").join(picture).exists(), "sketches.md shows {picture}, which no command made");
    }
    say(&format!("sketches.md: {made} commands"));
    Ok(())
}

fn is_aside(word: &str) -> bool {
    word.ends_with(".json") && Path::new(word).parent().is_some_and(|p| p.as_os_str().is_empty())
}
