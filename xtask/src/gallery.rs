//! The pictures of the articles, made anew by the commands that these give. Commands run in a folder of their own, where
//! what they need on the way lies; what begins with data/ or docs/ is the project's.

use anyhow::{Context as _, Result, ensure};

use crate::c_host::fresh;
use crate::shell::{cargo, program, read, root, run, say, target};

const ARTICLES: [&str; 2] = ["sketches.md", "creatures.md"];

pub(crate) fn gallery(articles: &[String]) -> Result<()> {
    run(cargo().args(["build", "--release", "--locked", "-p", "marey-cli"]))?;
    std::fs::create_dir_all(root().join("docs/pictures"))?;
    for article in ARTICLES.into_iter().filter(|a| articles.is_empty() || articles.iter().any(|b| b == a)) {
        make(article)?;
    }
    Ok(())
}

fn make(name: &str) -> Result<()> {
    let article = std::fs::read_to_string(root().join("docs").join(name))?;
    let marey = target().join("release/marey").display().to_string();
    let aside = fresh("gallery")?;
    let blocks = article.split("```sh\n").skip(1).filter_map(|b| b.split_once("```"));
    let mut made = 0;
    for line in blocks.flat_map(|(block, _)| block.lines()).filter(|l| !l.trim().is_empty()) {
        let (command, words) = line.split_once(' ').with_context(|| format!("{name}: no command: {line}"))?;
        ensure!(["cp", "marey"].contains(&command), "{name}: neither cp nor marey: {line}");
        let command = if command == "marey" { &marey } else { command };
        let place = |word: &str| {
            let ours = word.starts_with("data/") || word.starts_with("docs/");
            if ours { root().join(word).display().to_string() } else { word.to_owned() }
        };
        read(program(command).current_dir(&aside).args(words.split(' ').map(place)))?;
        made += 1;
    }
    ensure!(made > 0, "{name} has no commands");
    for picture in article.split("](").skip(1).filter_map(|p| p.split_once(')')).map(|p| p.0) {
        ensure!(root().join("docs").join(picture).exists(), "{name} shows {picture}, which no command made");
    }
    say(&format!("{name}: {made} commands"));
    Ok(())
}
