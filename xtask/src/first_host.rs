//! The articles docs/c/first-host.md, characters.md and sketches.md, taken at their word: their programs are built from an installed
//! prefix and nothing else, by make with pkg-config, the first also by CMake and static, and run.

use std::path::Path;

use anyhow::{Context as _, Result, ensure};

use crate::c_host::{fresh, host, is_glb};
use crate::sample::Sample;
use crate::shell::{program, read, root, say};

/// More lines than this are no first host.
const LINES: usize = 60;

const MAKEFILE: &str = "\
all: shared_c shared_cpp static_c static_cpp
LIBDIR = $(shell pkg-config --variable=libdir marey)
SHARED = $(shell pkg-config --libs marey) -Wl,-rpath,$(LIBDIR)
STATIC = $(LIBDIR)/libmarey.a $(filter-out -lmarey,$(shell pkg-config --static --libs-only-l marey))
CFLAGS = -std=c11 -Wall -Wextra -Werror $(shell pkg-config --cflags marey)
CXXFLAGS = -std=c++17 -Wall -Wextra -Werror $(shell pkg-config --cflags marey)
shared_c: first.c ; $(CC) $(CFLAGS) $< $(SHARED) -o $@
static_c: first.c ; $(CC) $(CFLAGS) $< $(STATIC) -o $@
shared_cpp: first.cpp ; $(CXX) $(CXXFLAGS) $< $(SHARED) -o $@
static_cpp: first.cpp ; $(CXX) $(CXXFLAGS) $< $(STATIC) -o $@
";

pub(crate) fn run(prefix: &Path, sample: &Sample) -> Result<()> {
    let article = std::fs::read_to_string(root().join("docs/c/first-host.md"))?;
    let folder = fresh("first-host")?;
    for (language, file) in [("c", "first.c"), ("cpp", "first.cpp"), ("cmake", "CMakeLists.txt")] {
        let code = block(&article, language)?;
        ensure!(code.lines().count() <= LINES, "first-host.md: {file} has {} lines", code.lines().count());
        std::fs::write(folder.join(file), code)?;
    }
    std::fs::write(folder.join("Makefile"), MAKEFILE)?;
    let pkgconfig = prefix.join("lib/pkgconfig");
    read(program("make").current_dir(&folder).env("PKG_CONFIG_PATH", &pkgconfig))?;
    let mut programs: Vec<_> =
        ["shared_c", "shared_cpp", "static_c", "static_cpp"].iter().map(|p| folder.join(p)).collect();
    for (build, fixed) in [("shared", "OFF"), ("static", "ON")] {
        let build = folder.join("cmake-").with_file_name(format!("cmake-{build}"));
        let mut configure = program("cmake");
        configure.arg("-S").arg(&folder).arg("-B").arg(&build).arg(format!("-DMAREY_STATIC={fixed}"));
        read(configure.arg(format!("-DCMAKE_PREFIX_PATH={}", prefix.display())))?;
        read(program("cmake").arg("--build").arg(&build))?;
        programs.extend([build.join("first_c"), build.join("first_cpp")]);
    }
    let mut first = None;
    for path in &programs {
        let glb = path.with_extension("glb");
        read(host(path).args([&sample.clip, &sample.strokes, &glb]))?;
        let glb = is_glb(&glb)?;
        ensure!(*first.get_or_insert_with(|| glb.clone()) == glb, "{}: another creature", path.display());
    }
    let refused = host(&programs[0]).args(["/no/such/clip.mp4", "x", "y"]).output()?;
    let said = String::from_utf8_lossy(&refused.stderr);
    ensure!(!refused.status.success() && said.contains("/no/such/clip.mp4"), "the first host's error: {said}");
    say("first-host.md: its programs build by make and CMake, shared and static, and make the same creature");
    characters(&pkgconfig)?;
    sketches(&pkgconfig)
}

/// The program of characters.md makes a GIF of the bundled drawing.
fn characters(pkgconfig: &Path) -> Result<()> {
    let article = std::fs::read_to_string(root().join("docs/c/characters.md"))?;
    let folder = fresh("characters")?;
    std::fs::write(folder.join("first.c"), block(&article, "c")?)?;
    std::fs::write(folder.join("Makefile"), MAKEFILE)?;
    read(program("make").arg("shared_c").current_dir(&folder).env("PKG_CONFIG_PATH", pkgconfig))?;
    let (made, drawing) = (folder.join("child.gif"), root().join("data/characters/child/drawing.png"));
    read(host(&folder.join("shared_c")).args([&drawing, &made]))?;
    ensure!(std::fs::read(&made)?.starts_with(b"GIF89a"), "characters.md: no GIF");
    let refused = host(&folder.join("shared_c")).args(["/no/such/drawing.png", "x.gif"]).output()?;
    let said = String::from_utf8_lossy(&refused.stderr);
    ensure!(!refused.status.success() && said.contains("/no/such/drawing.png"), "characters.md's error: {said}");
    say("characters.md: its program makes a GIF of a drawing");
    Ok(())
}

/// The program of sketches.md lets a bundled drawing gallop, as Lottie.
fn sketches(pkgconfig: &Path) -> Result<()> {
    let article = std::fs::read_to_string(root().join("docs/c/sketches.md"))?;
    let folder = fresh("sketches")?;
    std::fs::write(folder.join("first.c"), block(&article, "c")?)?;
    std::fs::write(folder.join("Makefile"), MAKEFILE)?;
    read(program("make").arg("shared_c").current_dir(&folder).env("PKG_CONFIG_PATH", pkgconfig))?;
    let data = |name: &str| root().join("data").join(name);
    let (clip, points) = (data("animals/horse-gallop.webp"), data("animals/horse-gallop.points.json"));
    let (drawing, made) = (data("drawings/horse.svg"), folder.join("horse.json"));
    read(host(&folder.join("shared_c")).args([&clip, &points, &drawing, &made]))?;
    let lottie = std::fs::read_to_string(&made)?;
    ensure!(lottie.starts_with('{') && lottie.contains("\"layers\""), "sketches.md: no Lottie");
    let missing = Path::new("/no/such/drawing.svg");
    let refused = host(&folder.join("shared_c")).args([clip.as_path(), &points, missing, &made]).output()?;
    let said = String::from_utf8_lossy(&refused.stderr);
    ensure!(!refused.status.success() && said.contains("/no/such/drawing.svg"), "sketches.md's error: {said}");
    say("sketches.md: its program lets a drawing gallop");
    Ok(())
}

/// The article's code of one language.
fn block<'a>(article: &'a str, language: &str) -> Result<&'a str> {
    let start = format!("```{language}\n");
    let code = article.split_once(&start).and_then(|(_, rest)| rest.split_once("```")).map(|(code, _)| code);
    code.with_context(|| format!("the article has no {language}"))
}
