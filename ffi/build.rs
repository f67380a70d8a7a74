//! Names the shared library for its ABI, and keeps it mapped: its threads and the host keep pointers into it.

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    let linux = std::env::var("CARGO_CFG_TARGET_OS").is_ok_and(|os| os == "linux");
    let (major, minor) = (std::env::var("CARGO_PKG_VERSION_MAJOR"), std::env::var("CARGO_PKG_VERSION_MINOR"));
    if let (true, Ok(major), Ok(minor)) = (linux, major, minor) {
        println!("cargo:rustc-cdylib-link-arg=-Wl,-soname,libmarey.so.{major}.{minor}");
        println!("cargo:rustc-cdylib-link-arg=-Wl,-z,nodelete");
    }
}
