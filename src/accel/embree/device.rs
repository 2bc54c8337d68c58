//! The device: configuration, the error and the memory callback.
#![allow(unsafe_code)]

use crate::error::{Error, Result};
use crate::memory;
use embree_sys as sys;
use std::ffi::{CStr, CString, c_char, c_void};
use std::ptr::null_mut;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicIsize, Ordering};

/// What the callbacks of a device write to.
#[derive(Default)]
struct Watch {
    /// Bytes that Embree holds.
    bytes: AtomicIsize,
    /// The most that it held at once.
    peak: AtomicIsize,
    /// The most that it may hold.
    limit: isize,
    /// Whether it was refused more.
    refused: AtomicBool,
    /// What Embree said about its first error.
    message: Mutex<Option<String>>,
}

/// An Embree device.
pub(super) struct Device {
    handle: sys::RTCDevice,
    // Boxed for an address that stays; freed after `drop` has released the device.
    watch: Box<Watch>,
}

// SAFETY: the manual allows every device call from any thread; `Watch` synchronises itself.
unsafe impl Send for Device {}
// SAFETY: as above.
unsafe impl Sync for Device {}

impl Device {
    /// A device for `isa` that builds with at most `threads` threads (0: all) and holds at most `memory` bytes.
    pub(super) fn new(isa: &str, threads: usize, memory: Option<u64>) -> Result<Self> {
        check_room(threads)?;
        let config = config(isa, threads);
        let text = CString::new(config.as_str()).unwrap_or_default();
        // SAFETY: a NUL-terminated string that lives through the call.
        let handle = unsafe { sys::rtcNewDevice(text.as_ptr()) };
        if handle.is_null() {
            // SAFETY: a null device asks for this thread's error.
            let code = unsafe { sys::rtcGetDeviceError(null_mut()) };
            return Err(Error::new(format!("Embree cannot start ({}; {config})", code_name(code)))
                .advise("choose another instruction set, or the backend \"bvh\""));
        }
        let limit = memory.and_then(|bytes| isize::try_from(bytes).ok()).unwrap_or(isize::MAX);
        let device = Device { handle, watch: Box::new(Watch { limit, ..Watch::default() }) };
        let watch = &raw const *device.watch as *mut c_void;
        // SAFETY: `watch` outlives the device (`Drop` releases the device first) and is only read through `&`.
        unsafe {
            sys::rtcSetDeviceErrorFunction(handle, Some(on_error), watch);
            sys::rtcSetDeviceMemoryMonitorFunction(handle, Some(on_memory), watch);
        }
        device.check("start")?;
        Ok(device)
    }

    pub(super) fn handle(&self) -> sys::RTCDevice {
        self.handle
    }

    /// Bytes that the device's scenes hold, shared buffers not included.
    pub(super) fn bytes(&self) -> usize {
        self.watch.bytes.load(Ordering::Relaxed).max(0) as usize
    }

    /// The most bytes that they held at once.
    #[cfg(test)]
    pub(super) fn peak(&self) -> usize {
        self.watch.peak.load(Ordering::Relaxed).max(0) as usize
    }

    /// A property, as a flag.
    pub(super) fn has(&self, property: sys::RTCDeviceProperty) -> bool {
        // SAFETY: the device lives.
        unsafe { sys::rtcGetDeviceProperty(self.handle, property) != 0 }
    }

    /// The error since the last call, on this thread, while `doing` something.
    pub(super) fn check(&self, doing: &str) -> Result<()> {
        // SAFETY: the device lives.
        let code = unsafe { sys::rtcGetDeviceError(self.handle) };
        let said = self.watch.message.lock().ok().and_then(|mut m| m.take());
        match code {
            sys::RTC_ERROR_NONE => Ok(()),
            sys::RTC_ERROR_CANCELLED => Err(super::cancelled()),
            sys::RTC_ERROR_OUT_OF_MEMORY => {
                let refused = self.watch.refused.swap(false, Ordering::Relaxed);
                let free =
                    if refused { format!(": {} MB are free", self.watch.limit >> 20) } else { String::new() };
                Err(Error::new(format!("not enough memory for Embree to {doing}{free}"))
                    .advise("use a smaller mesh, or `render.compact = \"auto\"`"))
            }
            code => {
                let said =
                    said.map_or_else(|| code_name(code).to_string(), |s| format!("{}: {s}", code_name(code)));
                Err(Error::new(format!("Embree could not {doing} ({said})"))
                    .advise("try the backend \"bvh\""))
            }
        }
    }
}

impl Drop for Device {
    fn drop(&mut self) {
        // SAFETY: the handle is released once; scenes hold references of their own.
        unsafe { sys::rtcReleaseDevice(self.handle) }
    }
}

/// The device's configuration; nothing in it depends on the machine except the number of threads, which
/// does not change the tree (see the module documentation of [`super`]).
fn config(isa: &str, threads: usize) -> String {
    let machine = std::thread::available_parallelism().map_or(1, usize::from);
    // More threads than processors would make TBB complain on stderr.
    let threads = if threads == 0 || threads >= machine { 0 } else { threads };
    if cfg!(target_arch = "x86_64") {
        format!("threads={threads},isa={isa},frequency_level=simd256")
    } else {
        format!("threads={threads}")
    }
}

/// TBB ends the process (`std::terminate`) where it cannot start a thread, which limits of the address space bring
/// about; so where there is one, what its threads need is asked for, and given back, before there are any. Measured.
fn check_room(threads: usize) -> Result<()> {
    /// Two stacks of 4 MiB, and the 64 MiB of addresses that the C library keeps for each thread's allocations.
    const A_THREAD: usize = 72 << 20;
    /// The library's own pools and the first blocks of a tree.
    const ALL: usize = 96 << 20;
    if rustix::process::getrlimit(rustix::process::Resource::As).current.is_none() {
        return Ok(());
    }
    let machine = std::thread::available_parallelism().map_or(1, usize::from);
    let threads = if threads == 0 { machine } else { threads.min(machine) };
    memory::probe(ALL + threads * A_THREAD).map_err(|_| {
        Error::new("not enough memory for Embree to start")
            .advise("raise the limit (ulimit -v), or use the backend \"bvh\"")
    })
}

fn code_name(code: sys::RTCError) -> &'static str {
    match code {
        sys::RTC_ERROR_NONE => "no error",
        sys::RTC_ERROR_INVALID_ARGUMENT => "invalid argument",
        sys::RTC_ERROR_INVALID_OPERATION => "invalid operation",
        sys::RTC_ERROR_OUT_OF_MEMORY => "out of memory",
        sys::RTC_ERROR_UNSUPPORTED_CPU => "unsupported processor",
        sys::RTC_ERROR_CANCELLED => "cancelled",
        _ => "unknown error",
    }
}

/// Keeps the first message. Nothing here can panic: a panic would abort in `extern "C"`.
unsafe extern "C" fn on_error(watch: *mut c_void, _code: sys::RTCError, text: *const c_char) {
    if watch.is_null() || text.is_null() {
        return;
    }
    // SAFETY: `Device::new` passed a `Watch` that outlives the device, and Embree a NUL-terminated string.
    let (watch, text) = unsafe { (&*watch.cast::<Watch>(), CStr::from_ptr(text)) };
    if let Ok(mut message) = watch.message.lock() {
        message.get_or_insert_with(|| text.to_string_lossy().into_owned());
    }
}

/// Counts, and refuses what is beyond the limit: Embree then gives back what it has and ends with an error, where a
/// system that promises more memory than it has would end the process. `bytes` is negative where memory is given back;
/// `post` means that it is taken already.
unsafe extern "C" fn on_memory(watch: *mut c_void, bytes: isize, post: bool) -> bool {
    if watch.is_null() {
        return true;
    }
    // SAFETY: as in `on_error`.
    let watch = unsafe { &*watch.cast::<Watch>() };
    let held = watch.bytes.fetch_add(bytes, Ordering::Relaxed).saturating_add(bytes);
    if bytes > 0 && held > watch.limit {
        watch.refused.store(true, Ordering::Relaxed);
        if !post {
            watch.bytes.fetch_sub(bytes, Ordering::Relaxed);
        }
        return false;
    }
    watch.peak.fetch_max(held, Ordering::Relaxed);
    true
}
