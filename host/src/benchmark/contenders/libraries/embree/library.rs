//! The shared library, and one scene in it behind safe methods. All `unsafe` of the host is here, but for the
//! map of a file in `index/index_file.rs`.
//!
//! The library is opened once and never closed: its threads' storage does not survive that.
//! Invariants of an [`EmbreeScene`]: it is committed and never changed again; scene and device are released
//! once, in this order, and the counter of bytes lives longer than both.

use std::ffi::{CStr, c_char, c_void};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicIsize, Ordering};
use std::{env, ptr};

use libloading::Library;

use super::layout::{Packet, PacketRayHits, RayHit, SingleRay};
use crate::benchmark::contenders::PeerError;
use crate::benchmark::contenders::mesh::WeldedMesh;
use crate::benchmark::contenders::peer::refused;

/// Names of the file to look for if `EMBREE4_LIBRARY` does not say.
const USUAL_NAMES: [&str; 4] =
    ["libembree4.so.4", "libembree4.so", "libembree4.4.dylib", "embree4.dll"];

/// Configuration that [`EmbreeScene::build`] hands to `rtcNewDevice`.
#[derive(Clone, Copy)]
pub(super) struct Config(pub(super) &'static CStr);

/// `RTCBuildQuality`.
#[derive(Clone, Copy)]
pub(super) enum Quality {
    /// Binned surface area.
    Medium = 1,
    /// Spatial splits.
    High = 2,
}

/// `RTCSceneFlags`.
#[derive(Clone, Copy)]
pub(super) enum Robustness {
    /// None.
    Fast = 0,
    /// `RTC_SCENE_FLAG_ROBUST`.
    Robust = 1 << 2,
    /// And in as little memory as it can.
    RobustCompact = 1 << 2 | 1 << 1,
}

// Values of enumerations in the headers.
const GEOMETRY_TYPE_TRIANGLE: i32 = 0;
const BUFFER_TYPE_INDEX: i32 = 0;
const BUFFER_TYPE_VERTEX: i32 = 1;
const FORMAT_UINT3: i32 = 0x5003;
const FORMAT_FLOAT3: i32 = 0x9003;

type Handle = *mut c_void;
type MemoryMonitor = unsafe extern "C" fn(*mut c_void, isize, bool) -> bool;

/// Declares the functions of the interface and how to find them.
macro_rules! functions {
    ($($name:ident: $symbol:literal ($($argument:ty),*) $(-> $result:ty)?;)*) => {
        struct Functions {
            $($name: unsafe extern "C" fn($($argument),*) $(-> $result)?,)*
        }

        impl Functions {
            fn find(library: &Library) -> Result<Self, libloading::Error> {
                // SAFETY: the types are those of the headers of version 4, and the names are of
                // functions that only version 4 has together. The pointers stay valid because the
                // library is never closed.
                unsafe { Ok(Self { $($name: *library.get($symbol)?,)* }) }
            }
        }
    };
}

functions! {
    new_device: b"rtcNewDevice\0" (*const c_char) -> Handle;
    release_device: b"rtcReleaseDevice\0" (Handle);
    device_error: b"rtcGetDeviceError\0" (Handle) -> i32;
    set_memory_monitor: b"rtcSetDeviceMemoryMonitorFunction\0" (Handle, MemoryMonitor, *mut c_void);
    new_scene: b"rtcNewScene\0" (Handle) -> Handle;
    release_scene: b"rtcReleaseScene\0" (Handle);
    set_scene_quality: b"rtcSetSceneBuildQuality\0" (Handle, i32);
    set_scene_flags: b"rtcSetSceneFlags\0" (Handle, i32);
    commit_scene: b"rtcCommitScene\0" (Handle);
    new_geometry: b"rtcNewGeometry\0" (Handle, i32) -> Handle;
    release_geometry: b"rtcReleaseGeometry\0" (Handle);
    new_buffer: b"rtcSetNewGeometryBuffer\0" (Handle, i32, u32, i32, usize, usize) -> *mut c_void;
    commit_geometry: b"rtcCommitGeometry\0" (Handle);
    attach_geometry: b"rtcAttachGeometry\0" (Handle, Handle) -> u32;
    intersect1: b"rtcIntersect1\0" (Handle, *mut RayHit, *mut c_void);
    intersect8: b"rtcIntersect8\0" (*const i32, Handle, *mut PacketRayHits, *mut c_void);
    occluded1: b"rtcOccluded1\0" (Handle, *mut SingleRay, *mut c_void);
}

/// Opens the library when first asked for it.
fn functions() -> Result<&'static Functions, PeerError> {
    static FUNCTIONS: OnceLock<Result<Functions, String>> = OnceLock::new();
    let opened = FUNCTIONS.get_or_init(|| {
        let named = env::var("EMBREE4_LIBRARY").ok();
        let names: Vec<&str> = match &named {
            Some(name) => vec![name],
            None => USUAL_NAMES.to_vec(),
        };
        let mut reasons = Vec::new();
        for name in names {
            // SAFETY: opening runs the initialisation of whatever is called so; the person who runs
            // this vouches for the file, as with any shared library.
            let library = match unsafe { Library::new(name) } {
                Ok(library) => library,
                Err(error) => {
                    reasons.push(error.to_string());
                    continue;
                }
            };
            let found = Functions::find(&library).map_err(|error| error.to_string());
            // Never closed, as promised above.
            std::mem::forget(library);
            return found;
        }
        Err(reasons.join("; "))
    });
    opened.as_ref().map_err(|reason| PeerError::EmbreeMissing { reason: reason.clone() })
}

/// Device with one scene of one mesh.
pub(super) struct EmbreeScene {
    functions: &'static Functions,
    device: Handle,
    handle: Handle,
    /// Bytes that the device holds, by its own count.
    held_bytes: Box<AtomicIsize>,
}

unsafe extern "C" fn count_bytes(counter: *mut c_void, bytes: isize, _after: bool) -> bool {
    // SAFETY: the pointer is the one given with this function in `EmbreeScene::build`: to the counter in a
    // box that `EmbreeScene` drops after the device.
    let counter = unsafe { &*counter.cast::<AtomicIsize>() };
    counter.fetch_add(bytes, Ordering::Relaxed);
    true
}

impl EmbreeScene {
    /// Copies the mesh and builds.
    pub(super) fn build(
        mesh: &WeldedMesh,
        config: Config,
        quality: Quality,
        robustness: Robustness,
    ) -> Result<Self, PeerError> {
        let functions = functions()?;
        let held_bytes = Box::new(AtomicIsize::new(0));
        // SAFETY: a string that ends in 0.
        let device = unsafe { (functions.new_device)(config.0.as_ptr()) };
        if device.is_null() {
            return Err(refused("Embree", format_args!("no device for {:?}", config.0)));
        }
        let counter = ptr::from_ref(held_bytes.as_ref()).cast_mut().cast();
        // SAFETY: the device was just made. The counter stays where it is (in a box), is only shared
        // (atomic), and outlives the device by the order in `drop`.
        let handle = unsafe {
            (functions.set_memory_monitor)(device, count_bytes, counter);
            (functions.new_scene)(device)
        };
        // From here on `drop` releases both.
        let scene = Self { functions, device, handle, held_bytes };
        // SAFETY: all handles are of this device and valid. The geometry is released once, after the
        // scene has taken its own share in it.
        unsafe {
            (functions.set_scene_quality)(scene.handle, quality as i32);
            (functions.set_scene_flags)(scene.handle, robustness as i32);
            let geometry = (functions.new_geometry)(device, GEOMETRY_TYPE_TRIANGLE);
            let filled =
                scene.fill(geometry, BUFFER_TYPE_VERTEX, FORMAT_FLOAT3, &mesh.corners).and_then(
                    |()| scene.fill(geometry, BUFFER_TYPE_INDEX, FORMAT_UINT3, &mesh.triangles),
                );
            if filled.is_ok() {
                (functions.commit_geometry)(geometry);
                (functions.attach_geometry)(scene.handle, geometry);
            }
            (functions.release_geometry)(geometry);
            filled?;
            (functions.commit_scene)(scene.handle);
        }
        scene.check()?;
        Ok(scene)
    }

    /// Makes a buffer of the geometry and copies `items` into it.
    ///
    /// # Safety
    /// The geometry is of this device, and `format` is that of `T`.
    unsafe fn fill<T: Copy>(
        &self,
        geometry: Handle,
        buffer_type: i32,
        format: i32,
        items: &[T],
    ) -> Result<(), PeerError> {
        // SAFETY: by the caller. A buffer that is returned has room for `items.len()` of `T`, is
        // aligned to 16, and is nobody else's before the commit.
        unsafe {
            let make = self.functions.new_buffer;
            let to = make(geometry, buffer_type, 0, format, size_of::<T>(), items.len());
            if to.is_null() {
                self.check()?;
                return Err(refused("Embree", "no memory for a buffer"));
            }
            ptr::copy_nonoverlapping(items.as_ptr(), to.cast::<T>(), items.len());
        }
        Ok(())
    }

    fn check(&self) -> Result<(), PeerError> {
        // SAFETY: the device is valid until `drop`.
        let error = unsafe { (self.functions.device_error)(self.device) };
        if error == 0 {
            return Ok(());
        }
        Err(refused("Embree", format_args!("error {error} of its enumeration RTCError")))
    }

    /// Returns the bytes that the device holds: the hierarchy and its copy of the mesh.
    pub(super) fn bytes(&self) -> usize {
        self.held_bytes.load(Ordering::Relaxed).max(0) as usize
    }

    /// Finds the closest hit of one ray.
    #[inline]
    pub(super) fn intersect(&self, query: &mut RayHit) {
        // SAFETY: the scene is committed; `RayHit` has the layout and the alignment of `RTCRayHit`;
        // no arguments means the defaults, for incoherent rays.
        unsafe { (self.functions.intersect1)(self.handle, query, ptr::null_mut()) }
    }

    /// Finds the closest hits of eight rays.
    #[inline]
    pub(super) fn intersect_packet(&self, query: &mut Packet) {
        let Packet { lanes, query } = query;
        // SAFETY: as above, for `RTCRayHit8`; the mask has eight lanes and is aligned to 32.
        unsafe {
            (self.functions.intersect8)(lanes.as_ptr(), self.handle, query, ptr::null_mut());
        }
    }

    /// Asks whether anything is hit; see [`SingleRay::is_occluded`].
    #[inline]
    pub(super) fn occluded(&self, query: &mut SingleRay) {
        // SAFETY: as for `intersect`, with the layout of `RTCRay`.
        unsafe { (self.functions.occluded1)(self.handle, query, ptr::null_mut()) }
    }
}

impl Drop for EmbreeScene {
    fn drop(&mut self) {
        // SAFETY: both are valid and released nowhere else; the counter is dropped after this.
        unsafe {
            (self.functions.release_scene)(self.handle);
            (self.functions.release_device)(self.device);
        }
    }
}
