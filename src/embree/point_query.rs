use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::ptr;

use super::builder::check_sphere_set;
use super::device::Device;
use super::error::{EmbreeError, check};
use super::geometry::Geometry;
use super::scene_handle::SceneHandle;
use super::{SceneOptions, Sphere, sys};
use crate::math::Vec3;

/// Balls that Embree's own tree searches for those around a point.
///
/// They are user geometry: Embree walks its tree and calls back for every ball of a leaf that it reaches.
/// Immutable once built, and free to be asked from any number of threads.
#[derive(Debug)]
pub struct SphereQuery {
    scene: SceneHandle,
    spheres: Box<[Sphere]>,
}

// SAFETY: Embree counts references atomically, and nothing else refers to the scene.
unsafe impl Send for SphereQuery {}
// SAFETY: the committed scene and the spheres are only ever read.
unsafe impl Sync for SphereQuery {}

impl SphereQuery {
    /// Builds the tree with `threads` threads; 0 means as many as there are.
    ///
    /// # Errors
    /// If there are no spheres, if a radius is not positive, if a sphere is not finite or reaches beyond ±1.8e18, or
    /// if Embree refuses.
    pub fn build(spheres: &[Sphere], threads: usize) -> Result<SphereQuery, EmbreeError> {
        check_sphere_set(spheres)?;
        let scene = SceneHandle::new(&Device::with_threads(threads)?, SceneOptions::default())?;
        let query = SphereQuery { scene, spheres: spheres.into() };
        query.commit()?;
        Ok(query)
    }

    /// Calls `visit(index)` once for every sphere that contains `p`, in no particular order.
    ///
    /// Contained means |p - c|² ≤ r², the squares of the differences summed in f32 in the order x, y, z. A point that
    /// is not finite is nowhere.
    ///
    /// # Panics
    /// Where `visit` panics: it is not called again, and its panic goes on here, not through Embree.
    ///
    /// ```
    /// use caustica::{embree::{Sphere, SphereQuery}, math::Vec3};
    /// let spheres = [5.0, 0.0, 1.0].map(|x| Sphere { center: Vec3::X * x, radius: 1.0 });
    /// let mut found = Vec::new();
    /// SphereQuery::build(&spheres, 1)?.for_each_containing(Vec3::X, |index| found.push(index));
    /// found.sort();
    /// assert_eq!(found, [1, 2]);
    /// # Ok::<(), caustica::embree::EmbreeError>(())
    /// ```
    pub fn for_each_containing(&self, p: Vec3, visit: impl FnMut(usize)) {
        if p.is_finite() {
            let mut search = Search { spheres: &self.spheres, p, visit, panic: None };
            self.run(&mut search);
            if let Some(panic) = search.panic {
                resume_unwind(panic);
            }
        }
    }

    /// The memory that Embree's tree and the spheres hold, in bytes.
    pub fn memory_bytes(&self) -> usize {
        self.scene.device().memory_bytes() + size_of_val(&*self.spheres)
    }

    fn commit(&self) -> Result<(), EmbreeError> {
        let mut geometry = Geometry::new(self.scene.device(), sys::RTC_GEOMETRY_TYPE_USER)?;
        let raw = geometry.as_raw();
        let count = u32::try_from(self.spheres.len()).unwrap_or(u32::MAX);
        // SAFETY: the geometry is alive; its user data are the spheres, which `bounds` reads while the scene is
        // built, below, and which stay where they are as long as the scene.
        unsafe {
            sys::rtcSetGeometryUserPrimitiveCount(raw, count);
            sys::rtcSetGeometryUserData(raw, self.spheres.as_ptr().cast_mut().cast());
            sys::rtcSetGeometryBoundsFunction(raw, Some(bounds), ptr::null_mut());
        }
        geometry.commit()?;
        // SAFETY: both handles are alive and of the same device; no query can run before `build` returns.
        unsafe {
            sys::rtcAttachGeometry(self.scene.as_raw(), raw);
            sys::rtcCommitScene(self.scene.as_raw());
        }
        check("build the scene of spheres")
    }

    fn run<V: FnMut(usize)>(&self, search: &mut Search<'_, V>) {
        let p = search.p;
        let mut query = sys::RTCPointQuery { x: p.x, y: p.y, z: p.z, time: 0.0, radius: 0.0 };
        let mut context = NO_INSTANCES;
        // SAFETY: the scene is alive and committed; query and context are aligned, of the headers' size and this
        // thread's own; the user pointer is the `Search<V>` that `visit_leaf::<V>` expects, and outlives the call.
        unsafe {
            sys::rtcPointQuery(
                self.scene.as_raw(),
                &raw mut query,
                &raw mut context,
                Some(visit_leaf::<V>),
                (&raw mut *search).cast(),
            );
        }
    }
}

/// What one query carries through Embree.
struct Search<'a, V> {
    spheres: &'a [Sphere],
    p: Vec3,
    visit: V,
    panic: Option<Box<dyn Any + Send>>,
}

impl<V: FnMut(usize)> Search<'_, V> {
    /// Never unwinds: the caller is C.
    fn offer(&mut self, index: usize) {
        if self.panic.is_none() && self.spheres.get(index).is_some_and(|sphere| contains(sphere, self.p)) {
            self.panic = catch_unwind(AssertUnwindSafe(|| (self.visit)(index))).err();
        }
    }
}

fn contains(sphere: &Sphere, p: Vec3) -> bool {
    let d = sphere.center - p;
    d.x * d.x + d.y * d.y + d.z * d.z <= sphere.radius * sphere.radius
}

/// Embree's callback for a primitive of a leaf; the radius of the query stays as it is.
///
/// # Safety
/// The user pointer must be that of a `Search<V>` to which nothing else refers.
unsafe extern "C" fn visit_leaf<V: FnMut(usize)>(
    arguments: *mut sys::RTCPointQueryFunctionArguments,
) -> bool {
    // SAFETY: Embree passes the arguments of the query under way, on the thread that asked.
    let (index, user) = unsafe { ((*arguments).primID, (*arguments).userPtr) };
    // SAFETY: the caller vouches for its type and that it is ours alone.
    unsafe { &mut *user.cast::<Search<'_, V>>() }.offer(index as usize);
    false
}

/// Embree's callback for the box of a primitive: wide enough for every point that [`contains`] admits.
///
/// # Safety
/// The user pointer must be that of spheres, of which there are more than `primID`.
unsafe extern "C" fn bounds(arguments: *const sys::RTCBoundsFunctionArguments) {
    // SAFETY: Embree passes arguments that live as long as this call.
    let sys::RTCBoundsFunctionArguments { geometryUserPtr, primID, bounds_o, .. } = unsafe { *arguments };
    // SAFETY: the caller vouches for the spheres and their number.
    let sphere = unsafe { *geometryUserPtr.cast::<Sphere>().add(primID as usize) };
    let reach = sphere.radius * RELATIVE_ROUNDING + ABSOLUTE_ROUNDING;
    let (min, max) = (sphere.center - reach, sphere.center + reach);
    // SAFETY: Embree passes a box to write to.
    let b = unsafe { &mut *bounds_o };
    (b.lower_x, b.lower_y, b.lower_z) = min.into();
    (b.upper_x, b.upper_y, b.upper_z) = max.into();
}

/// Three roundings widen a ball by at most 2⁻²² of its radius.
const RELATIVE_ROUNDING: f32 = 1.0 + 1.0 / (1u32 << 21) as f32;
/// Differences below this square to zero.
const ABSOLUTE_ROUNDING: f32 = 1.0 / (1u128 << 74) as f32;

const NO_INSTANCES: sys::RTCPointQueryContext = sys::RTCPointQueryContext {
    world2inst: [[0.0; 16]],
    inst2world: [[0.0; 16]],
    instID: [u32::MAX],
    instPrimID: [u32::MAX],
    instStackSize: 0,
};

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn found(query: &SphereQuery, p: Vec3) -> Vec<usize> {
        let mut found = Vec::new();
        query.for_each_containing(p, |index| found.push(index));
        found.sort_unstable();
        found
    }

    fn point() -> impl Strategy<Value = Vec3> {
        (-2f32..2.0, -2f32..2.0, -2f32..2.0).prop_map(Vec3::from)
    }

    fn sphere() -> impl Strategy<Value = Sphere> {
        (point(), 1e-3f32..2.0).prop_map(|(center, radius)| Sphere { center, radius })
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]
        #[test]
        fn points_find_what_the_naive_search_finds(
            spheres in prop::collection::vec(sphere(), 1..200),
            mut points in prop::collection::vec(point(), 1..50),
        ) {
            points.extend(spheres.iter().map(|s| s.center + Vec3::X * s.radius));
            points.extend([Vec3::NAN, Vec3::INFINITY]);
            let query = SphereQuery::build(&spheres, 1).unwrap();
            for p in points {
                let naive: Vec<usize> = (0..spheres.len()).filter(|&k| contains(&spheres[k], p)).collect();
                prop_assert_eq!(found(&query, p), naive);
            }
        }
    }

    #[test]
    fn a_panic_of_the_visitor_reaches_the_caller() {
        let sphere = Sphere { center: Vec3::ZERO, radius: 1.0 };
        let query = SphereQuery::build(&[sphere; 20], 1).unwrap();
        let mut calls = 0;
        let visit = AssertUnwindSafe(|| {
            query.for_each_containing(Vec3::ZERO, |_| {
                calls += 1;
                std::panic::panic_any("stop");
            });
        });
        let panic = catch_unwind(visit).unwrap_err();
        assert_eq!((panic.downcast_ref(), calls), (Some(&"stop"), 1));
        assert_eq!(found(&query, Vec3::ZERO).len(), 20, "the scene is as before");
    }

    #[test]
    fn what_cannot_be_searched_is_refused() {
        let error = |spheres: &[Sphere]| SphereQuery::build(spheres, 1).unwrap_err().to_string();
        assert!(error(&[]).contains("at least one of its spheres"));
        assert!(error(&[Sphere { center: Vec3::ZERO, radius: -1.0 }]).starts_with("sphere 0 has"));
    }

    #[test]
    fn memory_is_counted_and_grows_with_the_spheres() {
        let bytes = |n: usize| {
            let spheres: Vec<Sphere> =
                (0..n).map(|k| Sphere { center: Vec3::X * k as f32, radius: 1.0 }).collect();
            SphereQuery::build(&spheres, 1).unwrap().memory_bytes()
        };
        let (few, many) = (bytes(1000), bytes(100_000));
        assert!(few > 1000 * size_of::<Sphere>() && many > 20 * few, "{few} and {many}");
    }
}
