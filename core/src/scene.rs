//! What an index is built from: triangles, and the options.

use crate::auto::CostModel;
use crate::{BuildError, Mesh, Ray, Triangle};

/// The triangles of a scene, which whole objects they belong to and which rays it will be asked about where that
/// is known, and whether an index of them has a copy.
///
/// # Examples
/// An index beside a mesh that is kept anyway reads the triangles where they lie, and is read back beside them.
/// ```
/// use arboleda::{Block, Index, LeanBvh, Mesh, Options, Ray, RayIndex, Scene, Vec3};
///
/// let (vertices, corners) = ([Vec3::ZERO, Vec3::X, Vec3::X + Vec3::Y, Vec3::Y], [[0, 1, 2], [0, 2, 3]]);
/// let mesh = Mesh::Indexed { vertices: &vertices, corners: &corners };
/// let scene = Scene::of(mesh).beside();
///
/// let (mut arena, mut scratch) = ([Block::ZERO; 16], [Block::ZERO; 16]);
/// let (arena, scratch) = (Block::bytes(&mut arena), Block::bytes(&mut scratch));
/// let built = Index::<LeanBvh>::build(&scene, &Options::default(), arena, scratch)?;
/// let ray = Ray::new(Vec3::new(0.25, 0.75, -1.0), Vec3::Z)?;
/// assert_eq!(built.closest_hit(&ray).map(|hit| (hit.triangle.0, hit.t)), Some((1, 1.0)));
///
/// let read = Index::<LeanBvh>::from_bytes_beside(built.as_bytes(), mesh)?;
/// assert!(read.occluded(&ray));
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Scene<'a> {
    pub(crate) triangles: Mesh<'a>,
    pub(crate) objects: Option<&'a [u32]>,
    /// Whether an index has no copy of the triangles.
    pub(crate) beside: bool,
    pub(crate) rays: &'a [Ray],
    /// The number of rays to come, if that is known.
    pub(crate) expected_rays: Option<u64>,
}

impl<'a> Scene<'a> {
    /// A scene whose primitives, for finding clusters, are its triangles.
    pub const fn new(triangles: &'a [Triangle]) -> Self {
        Self::of(Mesh::Triangles(triangles))
    }

    /// As [`Scene::new`], of a mesh.
    pub const fn of(mesh: Mesh<'a>) -> Self {
        Self { triangles: mesh, objects: None, beside: false, rays: &[], expected_rays: None }
    }

    /// A scene whose primitives are whole objects; see [`Scene::objects`].
    pub const fn with_objects(triangles: &'a [Triangle], objects: &'a [u32]) -> Self {
        Self::new(triangles).objects(objects)
    }

    /// The same triangles, with whole objects for primitives: triangle `i` belongs to object `objects[i]`, a
    /// number below the number of triangles. An object is never divided between clusters.
    #[must_use]
    pub const fn objects(self, objects: &'a [u32]) -> Self {
        Self { objects: Some(objects), ..self }
    }

    /// The same scene, of whose triangles an index has no copy: it lies beside them, and reads them where the
    /// caller keeps them. Its answers are the same.
    #[must_use]
    pub const fn beside(self) -> Self {
        Self { beside: true, ..self }
    }

    /// The same scene, and rays such as it will be asked about: some hundred are enough. The automatic resolution
    /// of grids and [`auto::select`](crate::auto::select) try their choices on them; without any, on a sample of the
    /// scene's own. No answer depends on them. As the triangles, they live as long as the index that a build returns.
    #[must_use]
    pub const fn rays(self, rays: &'a [Ray]) -> Self {
        Self { rays, ..self }
    }

    /// Tells the approximate number of rays to come. [`auto::select`](crate::auto::select) weighs the cost of a build
    /// against the cost of these rays, and tries more candidates the more rays there are; with `u64::MAX`, all
    /// candidates. No answer depends on the number.
    #[must_use]
    pub const fn expecting(self, rays: u64) -> Self {
        Self { expected_rays: Some(rays), ..self }
    }

    /// The triangles, by id.
    pub const fn triangles(&self) -> Mesh<'a> {
        self.triangles
    }

    /// The mesh that an index of the scene lies beside, if it does.
    pub(crate) fn kept(&self) -> Option<Mesh<'a>> {
        self.beside.then_some(self.triangles)
    }

    /// Refuses what no index can hold.
    pub(crate) fn check(&self) -> Result<(), BuildError> {
        self.triangles.check()?;
        let given = self.triangles.len();
        let Some(objects) = self.objects else {
            return Ok(());
        };
        if objects.len() != given {
            return Err(BuildError::ObjectsMismatch { triangles: given, objects: objects.len() });
        }
        match objects.iter().position(|&object| object as usize >= given) {
            Some(triangle) => Err(BuildError::ObjectOutOfRange { triangle: triangle as u32 }),
            None => Ok(()),
        }
    }
}

/// 2^30: twice as many cluster-tree nodes still have ids below the ones used as marks.
pub(crate) const MOST_TRIANGLES: usize = 1 << 30;

/// How an index is built. The defaults just work.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// A cell with at most this many triangles is not divided. The paper's rule is 12. Fewer means
    /// fewer triangle tests, more nodes and more bytes. 1 or more.
    pub leaf_capacity: u32,
    /// How often a cell may be divided.
    pub level: Level,
    /// Two primitives of a size class are in one cluster if the gap between their boxes is at most
    /// this multiple of the class's median box diagonal. Finite and not negative.
    pub proximity: f32,
    /// The most size classes, 1 to 4. With 1, small objects standing on a large floor are joined
    /// with it.
    pub size_classes: u32,
    /// The cells of uniform grids.
    pub resolution: Resolution,
    /// How bounding volume hierarchies are built.
    pub bvh_build: BvhBuild,
    /// What a step and a test cost, for the indices that estimate; `None` for what was measured of each,
    /// [`crate::IndexKind::cost_model`].
    pub cost: Option<CostModel>,
    /// The most steps that a build may take, each a look at one triangle; `None` for any number.
    /// [`crate::Capacity::steps`] counts them, the same on every machine.
    pub work_limit: Option<u64>,
    /// The processors for which [`auto::select`](crate::auto::select) weighs. The choice of an index depends on this,
    /// and nothing else does: each index has the same bytes and gives the same answers.
    pub float64: Float64,
}

impl Default for Options {
    fn default() -> Self {
        Self::DEFAULT
    }
}

impl Options {
    /// The defaults, where a constant is needed.
    pub const DEFAULT: Self = Self {
        leaf_capacity: 12,
        level: Level::Automatic,
        proximity: 0.5,
        size_classes: 4,
        resolution: Resolution::Automatic,
        bvh_build: BvhBuild::Binned,
        cost: None,
        work_limit: None,
        float64: Float64::Hardware,
    };

    /// The model to estimate with; [`crate::Index::build`] has filled in the index's own.
    pub(crate) fn cost_model(&self) -> CostModel {
        self.cost.unwrap_or_default()
    }

    pub(crate) fn check(&self) -> Result<(), BuildError> {
        let invalid = |option, allowed| Err(BuildError::InvalidOption { option, allowed });
        if self.leaf_capacity == 0 {
            return invalid("leaf_capacity", "at least 1");
        }
        if matches!(self.level, Level::AtMost(level) if level > MAX_LEVEL) {
            return invalid("level", "at most 20");
        }
        if !(self.proximity.is_finite() && self.proximity >= 0.0) {
            return invalid("proximity", "finite and not negative");
        }
        let most = MOST_CELLS_ON_AXIS;
        match self.resolution {
            Resolution::Cells(cells) if !cells.iter().all(|n| (1..=most).contains(n)) => {
                return invalid("resolution", "1 to 65536 cells on each axis");
            }
            Resolution::CellsPerTriangle(density) if !(density > 0.0 && density <= 1024.0) => {
                return invalid("resolution", "above 0 and at most 1024 cells per triangle");
            }
            _ => {}
        }
        let positive = |cost: f64| cost.is_finite() && cost > 0.0;
        let model = self.cost_model();
        if !(positive(model.traversal) && positive(model.intersection)) {
            return invalid("cost", "finite and above 0");
        }
        if !(1..=4).contains(&self.size_classes) {
            return invalid("size_classes", "1 to 4");
        }
        Ok(())
    }
}

/// The highest level of a hierarchy of cells; the root is level 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Level {
    /// Found: division goes on as long as the estimated cost falls, and a tree has at most 16 references a triangle.
    Automatic,
    /// Given; 0 to 20. Cells whose division would take the tree beyond 4,096 references a triangle are leaves.
    AtMost(u32),
}

/// How many cells a uniform grid has.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Resolution {
    /// Found by what it takes to answer some rays: the [scene's](Scene::rays), or a sample.
    Automatic,
    /// So many nearly cubic cells for each triangle of the group; above 0, at most 1024.
    CellsPerTriangle(f32),
    /// The number of cells in x, y and z; 1 to 65536 on each axis. All three are halved as long as filing would take
    /// more than 4,096 steps a triangle and 8 a cell, where a step is a cell that the box of a triangle reaches into.
    Cells([u32; 3]),
}

/// Arithmetic unit for `f64`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Float64 {
    /// Instructions of the processor.
    Hardware,
    /// Library functions, as on a Cortex-M4 and on processors without a floating-point unit.
    Software,
}

/// How a bounding volume hierarchy is built.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BvhBuild {
    /// From above, by binned surface area.
    Binned,
    /// By inserting one triangle after the other where the surfaces grow least.
    Insertion,
}

/// Cells of a uniform grid along an axis: their planes stay apart in `f64` whatever the `f32` box.
pub(crate) const MOST_CELLS_ON_AXIS: u32 = 1 << 16;

/// Cells of 2^-20 of the root: finer than `f32` tells coordinates of the root apart usefully.
pub(crate) const MAX_LEVEL: u32 = 20;
