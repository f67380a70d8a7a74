//! From an author's types to the library's doors.

use std::sync::OnceLock;

use crate::descriptors::Descriptors;
use crate::error::Result;
use crate::info::Info;
use crate::parameter::Parameter;
use crate::raw;
use crate::room::{self, Object};
use crate::traits::{Deformer, Plugin, Segmenter, Tracker};
use crate::values::Values;

/// One plugin of a library.
pub struct Registration {
    pub(crate) kind: i32,
    pub(crate) info: Info,
    pub(crate) parameters: &'static [Parameter],
    pub(crate) state_version: u32,
    pub(crate) create: fn(&Values<'_>) -> Result<Box<dyn Object>>,
}

const fn of<T: Plugin>(kind: i32, create: fn(&Values<'_>) -> Result<Box<dyn Object>>) -> Registration {
    Registration { kind, info: T::INFO, parameters: T::PARAMETERS, state_version: T::STATE_VERSION, create }
}

/// `tracker: T`
pub const fn tracker<T: Tracker>() -> Registration {
    of::<T>(raw::TRACKER, room::create_tracker::<T>)
}

/// `segmenter: T`
pub const fn segmenter<T: Segmenter>() -> Registration {
    of::<T>(raw::SEGMENTER, room::create_segmenter::<T>)
}

/// `deformer: T`
pub const fn deformer<T: Deformer>() -> Registration {
    of::<T>(raw::DEFORMER, room::create_deformer::<T>)
}

/// All plugins of a library, and what is made of them once.
pub struct State {
    pub(crate) registrations: &'static [Registration],
    pub(crate) descriptors: OnceLock<Descriptors>,
}

impl State {
    /// Of these plugins.
    pub const fn new(registrations: &'static [Registration]) -> Self {
        Self { registrations, descriptors: OnceLock::new() }
    }

    pub(crate) fn descriptors(&self) -> &Descriptors {
        self.descriptors.get_or_init(|| Descriptors::new(self.registrations))
    }
}

/// The library that the macro is used in.
pub trait Bundle {
    /// Its plugins.
    fn state() -> &'static State;
}

/// Makes a plugin library of a crate of type `cdylib`: exports its doors for the named types.
///
/// ```text
/// marey_plugin! { tracker: Nearest, segmenter: Threshold }
/// ```
///
/// Use it once in a library, and in no library that is linked into another program than a test of its own: the doors'
/// names are fixed.
#[macro_export]
macro_rules! marey_plugin {
    ($($kind:ident: $type:ty),+ $(,)?) => {
        const _: () = {
            assert!(
                cfg!(panic = "unwind"),
                "a Marey plugin must be built with panic = \"unwind\" (see [profile] in Cargo.toml): \
                 with \"abort\" a panic would end the host"
            );

            static REGISTRATIONS: &[$crate::__private::Registration] = &[$($crate::__private::$kind::<$type>()),+];
            static STATE: $crate::__private::State = $crate::__private::State::new(REGISTRATIONS);

            struct Library;

            impl $crate::__private::Bundle for Library {
                fn state() -> &'static $crate::__private::State {
                    &STATE
                }
            }

            #[unsafe(no_mangle)]
            #[allow(non_upper_case_globals)]
            pub static mry_plugin_entry_v1: $crate::raw::Entry = $crate::__private::entry::<Library>();

            $crate::__rust_door!(Library);
        };
    };
}

/// The second door, where it is built in.
#[cfg(feature = "rust-door")]
#[doc(hidden)]
#[macro_export]
macro_rules! __rust_door {
    ($library:ty) => {
        // The name under which abi_stable looks for it.
        #[unsafe(no_mangle)]
        #[allow(non_upper_case_globals)]
        pub static _1as_0lib_1header_0root_bmodule_bloader: $crate::__private::export::LibHeader = {
            extern "C" fn erased() -> $crate::__private::export::RootModuleResult {
                fn root() -> $crate::__private::Root1_Ref {
                    use $crate::__private::export::PrefixTypeTrait as _;
                    $crate::__private::root::<$library>().leak_into_prefix()
                }
                $crate::__private::export::__call_root_module_loader(root)
            }
            // SAFETY: the constructor gives this root.
            unsafe { $crate::__private::export::header(erased) }
        };
    };
}

/// The second door, where it is not built in.
#[cfg(not(feature = "rust-door"))]
#[doc(hidden)]
#[macro_export]
macro_rules! __rust_door {
    ($library:ty) => {};
}
