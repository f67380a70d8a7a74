//! What every kind of clip gives the [`super::Clip`]: streams that decode forward from the places where decoding can
//! begin.
//!
//! Video is stored as differences, so a picture can only be had by decoding from a place that stands alone. A
//! [`Source`] knows those places; a [`Stream`] runs forward from one of them. Which stream serves which request is the
//! business of [`super::pool`].

use std::sync::Arc;

use super::Picture;
use super::yuv::Planes;
use crate::error::Result;

/// A clip's pictures, numbered from 0 in the order in which they are shown.
pub(super) trait Source: Send + Sync {
    /// Where a new stream that is to reach `picture` would begin.
    fn restart(&self, picture: usize) -> usize;

    /// A new stream whose first picture is `restart(picture)`.
    fn stream(&self, picture: usize) -> Result<Box<dyn Stream>>;

    /// How many streams may be alive at once; each holds a decoder with its buffers.
    fn max_streams(&self) -> usize;
}

/// A decoder under way.
pub(super) trait Stream: Send {
    /// The next picture and its number; numbers only rise. [`None`] after the last one.
    fn next(&mut self) -> Result<Option<(usize, Decoded)>>;
}

/// What a decoder hands over.
#[derive(Debug)]
pub(super) enum Decoded {
    /// Colours.
    Picture(Arc<Picture>),
    /// Planes whose conversion to colours is left to whoever asks for the picture, on their own thread.
    Planes(Planes),
    /// The data of this picture is damaged.
    Damaged(Damage),
}

/// Why a picture cannot be had.
#[derive(Debug)]
pub(super) struct Damage {
    /// What is wrong with its data, or with the data that it builds on.
    pub(super) why: String,
    /// The first picture that the same damage spoils; those before it, from where decoding began, are good.
    pub(super) first: usize,
}
