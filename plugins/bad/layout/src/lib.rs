//! The root of a plugin library as somebody might have it who changed a frozen interface: a function takes another type.
#![allow(non_camel_case_types, non_local_definitions, reason = "abi_stable 0.11 expands to such")]
#![allow(missing_docs, unreachable_pub, unused_qualifications, reason = "what abi_stable expands to is not ours")]

use std::ffi::c_void;

use abi_stable::export_root_module;
use abi_stable::library::RootModule;
use abi_stable::package_version_strings;
use abi_stable::prefix_type::PrefixTypeTrait as _;
use abi_stable::sabi_types::VersionStrings;
use abi_stable::std_types::RStr;
use abi_stable::{StableAbi, declare_root_module_statics};

#[repr(C)]
#[derive(StableAbi)]
#[sabi(kind(Prefix(prefix_ref = Root1_Ref)))]
#[sabi(missing_field(panic))]
pub struct Root1 {
    pub init: extern "C" fn(u64),
    pub plugins: extern "C" fn() -> u64,
    pub create: extern "C" fn(u32, u32) -> u64,
    #[sabi(last_prefix_field)]
    pub get_extension: extern "C" fn(RStr<'_>) -> *const c_void,
}

impl RootModule for Root1_Ref {
    declare_root_module_statics! {Root1_Ref}
    const BASE_NAME: &'static str = "marey_plugin";
    const NAME: &'static str = "marey plugin";
    const VERSION_STRINGS: VersionStrings = package_version_strings!();
}

extern "C" fn init(_: u64) {}

extern "C" fn plugins() -> u64 {
    0
}

extern "C" fn create(_: u32, _: u32) -> u64 {
    0
}

extern "C" fn get_extension(_: RStr<'_>) -> *const c_void {
    std::ptr::null()
}

#[export_root_module]
pub fn root() -> Root1_Ref {
    Root1 { init, plugins, create, get_extension }.leak_into_prefix()
}
