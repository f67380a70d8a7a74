//! Results out: files that other programs open.
