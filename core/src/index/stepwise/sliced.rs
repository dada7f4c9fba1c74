//! Build of a wide BVH in slices.

use core::mem::{self, MaybeUninit};

use super::{Index, whole_words};
use crate::cluster::{ClusterNode, NodeId};
use crate::error::BuildError;
use crate::indices::WideBvh;
use crate::indices::wide::{SliceError, SlicedWords, Unsorted};
use crate::input::{Options, Scene};
use crate::memory::Arena;
use crate::structure::sections::{Layout, Sections, encode_header};
use crate::structure::{Described, Representation};

/// The format of the index.
const FORMAT: u32 = <WideBvh as Representation>::FORMAT;

/// Build of a [wide BVH](crate::kinds::WideBvh) that pauses, for those who must not wait for a whole build: a game
/// between two frames, firmware with a watchdog.
///
/// The bytes are those of [`Index::build`], wherever the build pauses. It is dropped to give it up.
///
/// A value takes some 13 KB, most of it a stack for the largest depth. It borrows the scene, the arena and the scratch, so
/// they outlive it: a game keeps all four where its level lives, and firmware in `main`, above its loop. Only the wide BVH
/// can be built in slices: its hierarchy, and all other kinds, are built at once.
///
/// # Examples
/// ```
/// use arboleda::kinds::WideBvh;
/// use arboleda::{Block, Index, Options, Scene, SlicedBuild, Triangle, Vec3};
///
/// let triangles: Vec<_> = (0..1_000)
///     .map(|i| Vec3::new((i % 32) as f32, (i / 32) as f32, 0.0))
///     .map(|a| Triangle::new(a, a + Vec3::X, a + Vec3::Y))
///     .collect();
/// let (scene, options) = (Scene::new(&triangles), Options::DEFAULT);
/// let mut arena = vec![Block::ZERO; Block::count(60 * 1_000)];
/// let mut scratch = vec![Block::ZERO; Block::count(SlicedBuild::scratch_capacity(1_000))];
///
/// let (arena, scratch) = (Block::bytes(&mut arena), Block::bytes(&mut scratch));
/// let mut build = SlicedBuild::new(&scene, &options, arena, scratch)?;
/// let mut frames = 0;
/// while !build.step(500)? {
///     frames += 1; // Draw a frame.
/// }
/// assert!(frames > 2);
/// let index: Index<WideBvh> = build.finish()?;
/// assert_eq!(index.cluster_count(), 1);
/// # Ok::<(), arboleda::BuildError>(())
/// ```
pub struct SlicedBuild<'a, 's> {
    scene: Scene<'a>,
    arena: &'a mut [u8],
    layout: Layout,
    /// The number of triangles that are checked.
    checked: usize,
    words: SlicedWords<'s>,
    /// The error of the step that ended the build.
    error: Option<BuildError>,
}

/// Checked parts of a build that is not begun: small, unlike the build.
struct Prepared<'a, 's> {
    scene: Scene<'a>,
    arena: &'a mut [u8],
    unsorted: Unsorted<'s>,
}

impl<'a, 's> SlicedBuild<'a, 's> {
    /// The scratch bytes that a build for `triangle_count` triangles needs.
    pub const fn scratch_capacity(triangle_count: usize) -> usize {
        SlicedWords::scratch_bytes(triangle_count)
    }

    /// Begins a build in the first bytes of `arena`, and does none of its work. Both slices begin at a multiple of
    /// [`ALIGNMENT`](crate::custom::ALIGNMENT) bytes.
    ///
    /// The length of the index is known only once the triangles are sorted. It is mostly 50 to 60 bytes a triangle.
    /// [`Index::capacity`] says it exactly, and takes nearly as long as a build.
    ///
    /// # Errors
    /// [`BuildError::ScratchFull`] below [`scratch_capacity`](Self::scratch_capacity) bytes, [`BuildError::Misaligned`],
    /// [`BuildError::InvalidOption`], [`BuildError::HoldsTriangles`] if the scene lies beside a mesh,
    /// [`BuildError::TooLarge`], and [`BuildError::Mesh`] for too many triangles.
    pub fn new(
        scene: &Scene<'a>,
        options: &Options,
        arena: &'a mut [u8],
        scratch: &'s mut [u8],
    ) -> Result<Self, BuildError> {
        Self::prepare(scene, options, arena, scratch).map(Self::of)
    }

    /// Begins a build as [`new`](Self::new) does, in a room where it stays: a static for example, or the memory of a C
    /// program. A build is large; one that is returned is copied on the stack, up to twice.
    ///
    /// # Errors
    /// The errors of [`new`](Self::new). The room is then as it was.
    pub fn begin_in<'r>(
        room: &'r mut MaybeUninit<Self>,
        scene: &Scene<'a>,
        options: &Options,
        arena: &'a mut [u8],
        scratch: &'s mut [u8],
    ) -> Result<&'r mut Self, BuildError> {
        let prepared = Self::prepare(scene, options, arena, scratch)?;
        Ok(room.write(Self::of(prepared)))
    }

    fn prepare(
        scene: &Scene<'a>,
        options: &Options,
        arena: &'a mut [u8],
        scratch: &'s mut [u8],
    ) -> Result<Prepared<'a, 's>, BuildError> {
        if scene.beside {
            return Err(BuildError::HoldsTriangles { kind: <WideBvh as Described>::NAME });
        }
        options.check()?;
        scene.triangles.check_count()?;
        let count = scene.triangles.len();
        let full =
            BuildError::ScratchFull { needed: Self::scratch_capacity(count), given: scratch.len() };
        if scratch.len() < Self::scratch_capacity(count) {
            return Err(full);
        }
        if Arena::new(arena).is_none() {
            return Err(BuildError::Misaligned);
        }
        let scratch = Arena::new(scratch).ok_or(BuildError::Misaligned)?;
        let work_limit = options.work_limit.unwrap_or(u64::MAX);
        let unsorted = SlicedWords::prepare(count, scratch, work_limit)?.ok_or(full)?;
        Ok(Prepared { scene: *scene, arena, unsorted })
    }

    #[inline]
    fn of(prepared: Prepared<'a, 's>) -> Self {
        let Prepared { scene, arena, unsorted } = prepared;
        let count = scene.triangles.len();
        let layout = Layout::new(FORMAT, count, count.min(1));
        Self { scene, arena, layout, checked: 0, words: SlicedWords::of(unsorted), error: None }
    }

    /// Goes on with the build for about `looks` looks at a triangle, at least one, and tells whether it is done. To write a
    /// row of the index, 32 bytes, counts as a look.
    ///
    /// Cost: at most `looks` looks, and what is not divided: the sort of up to 512 triangles, mostly 4,000 looks and at
    /// most 20,000, or writing up to eight parts of the index of 4 KiB each. A whole build takes about twice as many
    /// looks as [`Index::build`] counts [steps](crate::Capacity::steps), and takes as long as it.
    ///
    /// # Measured
    /// - AMD EPYC, Zen 5: 4 to 10 ns a look; the longest step of 1,000 looks took 40 µs in scenes of 30,000 to 125,000
    ///   triangles, and 0.24 ms in a city of a million, which does not fit into the caches.
    ///
    /// # Errors
    /// [`BuildError::ArenaFull`], which says how many bytes are enough, [`BuildError::TooMuchWork`],
    /// [`BuildError::Mesh`] and the errors of the objects. After an error the contents of the arena are undefined, and
    /// each further step returns the same error.
    pub fn step(&mut self, looks: usize) -> Result<bool, BuildError> {
        if let Some(error) = self.error {
            return Err(error);
        }
        let stepped = self.go_on(looks.max(1));
        self.error = stepped.err();
        stepped
    }

    fn go_on(&mut self, mut looks: usize) -> Result<bool, BuildError> {
        // 1. Check the triangles.
        let count = self.scene.triangles.len();
        if self.checked < count || count == 0 {
            let end = self.checked.saturating_add(looks).min(count);
            self.scene.triangles.check_some(self.checked..end)?;
            self.scene.check_objects(self.checked..end)?;
            looks -= end - self.checked;
            self.checked = end;
        }
        // 2. Build the words.
        let given = self.arena.len();
        let slots = whole_words(self.arena.get_mut(self.layout.words..).unwrap_or_default());
        self.words.go_on(self.scene.triangles, slots, &mut looks).map_err(|error| match error {
            SliceError::Words(words) => {
                BuildError::ArenaFull { needed: self.layout.total(words), given }
            }
            SliceError::Build(error) => error,
        })?;
        Ok(self.words.word_count().is_some())
    }

    /// Does what is left of the build, and returns the index.
    ///
    /// # Errors
    /// The errors of [`step`](Self::step).
    pub fn finish(mut self) -> Result<Index<'a, WideBvh>, BuildError> {
        self.finish_in_place()
    }

    /// Does what is left of the build, and returns the index, as [`finish`](Self::finish) does of a build that is not
    /// moved. The build is over: it has no arena any more.
    ///
    /// # Errors
    /// The errors of [`step`](Self::step); [`BuildError::ArenaFull`], with none given, if the index was returned before.
    pub fn finish_in_place(&mut self) -> Result<Index<'a, WideBvh>, BuildError> {
        while !self.step(usize::MAX)? {}
        let arena = mem::take(&mut self.arena);
        let Self { scene, layout, words, .. } = self;
        let word_count = words.word_count().unwrap_or(0);
        let (needed, given) = (layout.total(word_count), arena.len());
        let full = BuildError::ArenaFull { needed, given };
        if word_count > u32::MAX as usize {
            return Err(BuildError::TooLarge);
        }
        // The only cluster owns all words.
        let fixed = arena.get_mut(..layout.words).ok_or(full)?;
        let (header, _, nodes) = layout.split(fixed);
        if let Some(node) = nodes.first_mut() {
            let (bounds, links) = (words.bounds(), [0, word_count as u32]);
            *node = ClusterNode { bounds, links, parent: NodeId::NONE };
        }
        let (triangles, clusters) = (scene.triangles.len() as u32, nodes.len() as u32);
        encode_header(header, FORMAT, triangles, clusters, word_count as u32, 0);
        Ok(Index::of_checked(Sections::view(arena, None).map_err(|_| full)?))
    }
}

impl core::fmt::Debug for SlicedBuild<'_, '_> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let is_done = self.words.word_count().is_some();
        f.debug_struct("SlicedBuild").field("is_done", &is_done).finish_non_exhaustive()
    }
}
