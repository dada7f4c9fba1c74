//! The bytes of an index: layout in the arena, and validation of untrusted bytes.
//!
//! ```text
//! | header 64 B | triangles 36 B each | cluster tree 36 B a node | words 4 B each |
//! ```
//! - Each section starts at a multiple of 64 bytes; bytes between sections are zero.
//! - The first `cluster_count` nodes of the cluster tree are its leaves, in the order of the clusters. An inner node
//!   comes after its children. The root is last.
//! - The words hold one local index for each cluster, one after the other; or one index over all clusters, whose words
//!   then belong to the first.
//! - There is no section of triangles if the words hold them (bit 17 of the kind), or if the index lies beside a mesh
//!   that the caller keeps (bit 18). The header then has a fingerprint of that mesh.
//! - Values have the byte order of the machine that wrote them. A machine of the other order refuses the bytes.
//!
//! # What validation guarantees
//! 1. The lengths fit.
//! 2. A mesh given has as many triangles, with the same coordinates, as the mesh that the index was built beside.
//! 3. Every link of the cluster tree goes to an earlier node whose parent link comes back, so the nodes form one tree.
//! 4. Each local index passes the check of its own kind.
//!
//! So every traversal ends and stays in bounds, for any bytes. It is not checked that boxes hold their triangles:
//! forged bytes that pass can give wrong answers, but cannot panic, loop, or read out of bounds.

use bytemuck::{Pod, Zeroable};

use crate::cluster::{ClusterNode, ClusterTree, NodeId};
use crate::error::OpenError;
use crate::geometry::Triangle;
use crate::input::{MOST_TRIANGLES, Mesh};
use crate::memory::{ALIGNMENT, padded};

const MAGIC: u32 = u32::from_le_bytes(*b"ARBL");
const BYTE_ORDER: u32 = 0x0102_0304;
const VERSION: u32 = 1;
/// Bit of a kind: the words hold the triangles, and there is no section of them.
pub(crate) const WORDS_HOLD_TRIANGLES: u32 = 1 << 17;
/// Bit of a kind: the triangles are those of a mesh beside the index.
pub(crate) const MESH_BESIDE: u32 = 1 << 18;

/// Header: the first 64 bytes of an index.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct Header {
    magic: u32,
    byte_order: u32,
    version: u32,
    kind: u32,
    triangle_count: u32,
    cluster_count: u32,
    word_count: u32,
    /// The fingerprint of the mesh beside the index, the lower half first; 0 without a mesh.
    fingerprint: [u32; 2],
    zero: [u32; 7],
}

/// The bytes of a header.
pub(crate) const HEADER_BYTES: usize = size_of::<Header>();

impl Header {
    /// Reads the header, and checks length, alignment, magic number, byte order and version.
    fn read(bytes: &[u8]) -> Result<Self, OpenError> {
        // The length comes first: no bytes lie anywhere.
        let header: Self = bytes
            .get(..size_of::<Self>())
            .and_then(|bytes| bytemuck::try_pod_read_unaligned(bytes).ok())
            .ok_or(OpenError::Truncated)?;
        if !bytes.as_ptr().addr().is_multiple_of(ALIGNMENT) {
            return Err(OpenError::Misaligned);
        }
        match (header.magic, header.byte_order) {
            (MAGIC, BYTE_ORDER) => {}
            (magic, order) if magic.swap_bytes() == MAGIC && order.swap_bytes() == BYTE_ORDER => {
                return Err(OpenError::OtherByteOrder);
            }
            _ => return Err(OpenError::NotAnIndex),
        }
        if header.version != VERSION {
            return Err(OpenError::OtherVersion { found: header.version });
        }
        Ok(header)
    }
}

/// Reads the kind from the header of an index.
pub(crate) fn format_of(bytes: &[u8]) -> Result<u32, OpenError> {
    Header::read(bytes).map(|header| header.kind)
}

/// Offsets of the sections, in bytes.
#[derive(Clone, Copy)]
pub(crate) struct Layout {
    pub triangles: usize,
    pub nodes: usize,
    pub words: usize,
    triangle_count: usize,
    node_count: usize,
}

impl Layout {
    pub const fn new(kind: u32, triangle_count: usize, cluster_count: usize) -> Self {
        let elsewhere = kind & (WORDS_HOLD_TRIANGLES | MESH_BESIDE) != 0;
        let triangle_count = if elsewhere { 0 } else { triangle_count };
        let triangles = size_of::<Header>();
        let node_count = (2 * cluster_count).saturating_sub(1);
        let nodes =
            padded(triangles.saturating_add(triangle_count.saturating_mul(size_of::<Triangle>())));
        let words =
            padded(nodes.saturating_add(node_count.saturating_mul(size_of::<ClusterNode>())));
        Self { triangles, nodes, words, triangle_count, node_count }
    }

    /// Divides the first `self.words` bytes into header, triangles and nodes; zeroes the rest.
    pub fn split<'b>(
        &self,
        bytes: &'b mut [u8],
    ) -> (&'b mut [u8], &'b mut [Triangle], &'b mut [ClusterNode]) {
        bytes.fill(0);
        let node_bytes = self.node_count.saturating_mul(size_of::<ClusterNode>());
        let triangle_bytes = self.triangle_count.saturating_mul(size_of::<Triangle>());
        let (front, nodes) = bytes.split_at_mut_checked(self.nodes).unwrap_or_default();
        let (header, triangles) = front.split_at_mut_checked(self.triangles).unwrap_or_default();
        let triangles = triangles.get_mut(..triangle_bytes).unwrap_or_default();
        let nodes = nodes.get_mut(..node_bytes).unwrap_or_default();
        let triangles = bytemuck::try_cast_slice_mut(triangles).unwrap_or_default();
        (header, triangles, bytemuck::try_cast_slice_mut(nodes).unwrap_or_default())
    }

    /// The length in bytes of an index with `word_count` words.
    pub const fn total(&self, word_count: usize) -> usize {
        self.words.saturating_add(word_count.saturating_mul(size_of::<u32>()))
    }
}

/// Writes the header into the first bytes of an index.
pub(crate) fn encode_header(
    bytes: &mut [u8],
    kind: u32,
    triangles: u32,
    clusters: u32,
    words: u32,
    fingerprint: u64,
) {
    let header = Header {
        magic: MAGIC,
        byte_order: BYTE_ORDER,
        version: VERSION,
        kind,
        triangle_count: triangles,
        cluster_count: clusters,
        word_count: words,
        fingerprint: halves(fingerprint),
        zero: [0; 7],
    };
    for (to, from) in bytes.iter_mut().zip(bytemuck::bytes_of(&header)) {
        *to = *from;
    }
}

/// Splits a fingerprint into two words, the lower first on every machine.
const fn halves(fingerprint: u64) -> [u32; 2] {
    [fingerprint as u32, (fingerprint >> 32) as u32]
}

/// Sections of a finished index, borrowed from its bytes.
#[derive(Clone, Copy, Debug)]
pub struct Sections<'a> {
    bytes: &'a [u8],
    kind: u32,
    triangle_count: u32,
    cluster_count: u32,
    /// The triangles of the section, or of the mesh beside the index.
    triangles: Mesh<'a>,
    fingerprint: [u32; 2],
    nodes: &'a [ClusterNode],
    words: &'a [u32],
}

impl<'a> Sections<'a> {
    /// The sections of an index without triangles, nodes and words.
    pub(crate) const EMPTY: Self = Self {
        bytes: &[],
        kind: 0,
        triangle_count: 0,
        cluster_count: 0,
        triangles: Mesh::EMPTY,
        fingerprint: [0; 2],
        nodes: &[],
        words: &[],
    };

    /// Reads the sections, and checks the triangles and the cluster tree. The caller checks the local indices. Bytes
    /// after the index are ignored.
    pub(crate) fn parse(bytes: &'a [u8], mesh: Option<Mesh<'a>>) -> Result<Self, OpenError> {
        let sections = Self::view(bytes, mesh)?;
        sections.check_triangles()?;
        sections.check_tree()?;
        Ok(sections)
    }

    /// Finds the sections by the header, without checking their contents; enough for bytes that were just built.
    pub(crate) fn view(bytes: &'a [u8], mesh: Option<Mesh<'a>>) -> Result<Self, OpenError> {
        let header = Header::read(bytes)?;
        let (triangles, clusters) = (header.triangle_count as usize, header.cluster_count as usize);
        let is_beside = header.kind & MESH_BESIDE != 0;
        let is_sound = triangles <= MOST_TRIANGLES
            && clusters <= triangles
            && (clusters == 0) == (triangles == 0)
            && (is_beside || header.fingerprint == [0; 2])
            && !(is_beside && header.kind & WORDS_HOLD_TRIANGLES != 0)
            && header.zero == [0; 7];
        if !is_sound {
            return Err(OpenError::Malformed { part: "header", at: 0 });
        }
        match mesh {
            None if is_beside => return Err(OpenError::MeshMissing),
            Some(_) if !is_beside => return Err(OpenError::HasTriangles),
            Some(mesh) if mesh.len() != triangles => {
                let (expected, found) = (header.triangle_count, mesh.len());
                return Err(OpenError::OtherMeshLength { expected, found });
            }
            _ => {}
        }
        let layout = Layout::new(header.kind, triangles, clusters);
        let total = layout.total(header.word_count as usize);
        let section_of_triangles = section(bytes, layout.triangles, layout.triangle_count)?;
        Ok(Self {
            bytes: bytes.get(..total).ok_or(OpenError::Truncated)?,
            kind: header.kind,
            triangle_count: header.triangle_count,
            cluster_count: header.cluster_count,
            triangles: mesh.unwrap_or(Mesh::Triangles(section_of_triangles)),
            fingerprint: header.fingerprint,
            nodes: section(bytes, layout.nodes, layout.node_count)?,
            words: section(bytes, layout.words, header.word_count as usize)?,
        })
    }

    /// Checks that the triangles are finite or, beside a mesh, those of the build.
    fn check_triangles(&self) -> Result<(), OpenError> {
        if self.kind & MESH_BESIDE != 0 {
            self.triangles.check().map_err(OpenError::Mesh)?;
            let same = halves(self.triangles.fingerprint()) == self.fingerprint;
            return if same { Ok(()) } else { Err(OpenError::OtherMesh) };
        }
        match self.triangles.iter().position(|triangle| !triangle.is_finite()) {
            Some(at) => Err(OpenError::Malformed { part: "triangle", at: at as u32 }),
            None => Ok(()),
        }
    }

    /// Checks the cluster tree: boxes, links and parents, and that the words of the leaves follow each other.
    fn check_tree(&self) -> Result<(), OpenError> {
        let mut next_word = 0;
        for (at, node) in self.nodes.iter().enumerate() {
            let malformed = Err(OpenError::Malformed { part: "cluster node", at: at as u32 });
            let is_root = at + 1 == self.nodes.len();
            let [left, right] = node.links;
            let numbers = node.bounds.lo.is_finite() && node.bounds.hi.is_finite();
            if !numbers || node.bounds.is_empty() || is_root != (node.parent == NodeId::NONE) {
                return malformed;
            }
            if at < self.cluster_count as usize {
                // The local indices follow each other, and fill the words.
                if left != next_word || left.checked_add(right).is_none() {
                    return malformed;
                }
                next_word = left + right;
            } else {
                let answered = |child: u32| {
                    (child as usize) < at
                        && self.node(NodeId(child)).is_some_and(|c| c.parent == NodeId(at as u32))
                };
                if left == right || !answered(left) || !answered(right) {
                    return malformed;
                }
            }
        }
        if next_word as usize == self.words.len() {
            self.check_depth()
        } else {
            Err(OpenError::Malformed { part: "words", at: next_word })
        }
    }

    /// Checks that no node lies deeper than the traversal's stack. Going up from each leaf takes at most
    /// `MAX_TREE_DEPTH` steps.
    fn check_depth(&self) -> Result<(), OpenError> {
        for at in 0..self.cluster_count {
            let mut node = NodeId(at);
            let mut depth = 0;
            while let Some(found) = self.node(node) {
                if depth > crate::cluster::MAX_TREE_DEPTH {
                    return Err(OpenError::Malformed { part: "cluster node", at });
                }
                depth += 1;
                node = found.parent;
            }
        }
        Ok(())
    }

    /// All bytes of the index: what to write to a file.
    pub fn bytes(&self) -> &'a [u8] {
        self.bytes
    }

    /// The representation's [format](crate::kinds::Representation::FORMAT). Bit 18 is set if the index lies beside a
    /// mesh.
    pub fn kind(&self) -> u32 {
        self.kind
    }

    /// The number of triangles.
    pub fn triangle_count(&self) -> u32 {
        self.triangle_count
    }

    /// The words of all local indices.
    pub fn words(&self) -> &'a [u32] {
        self.words
    }

    /// The triangles: the section, or the mesh beside the index. Empty if the words hold the triangles.
    #[inline]
    pub fn triangles(&self) -> Mesh<'a> {
        self.triangles
    }

    /// The triangles by reference, for traversals that must not copy a [`Mesh`]; see [`Self::triangles`].
    #[inline]
    pub(crate) fn mesh(&self) -> &Mesh<'a> {
        &self.triangles
    }

    /// The cluster tree: leaves, then inner nodes, the root last.
    pub fn nodes(&self) -> &'a [ClusterNode] {
        self.nodes
    }

    /// The cluster tree, as a view.
    pub(crate) fn cluster_tree(&self) -> ClusterTree<'a> {
        ClusterTree::new(self.nodes, self.cluster_count)
    }

    /// The number of leaves of the cluster tree.
    pub fn cluster_count(&self) -> u32 {
        self.cluster_count
    }

    /// The node `id` of the cluster tree; `None` if there is none.
    #[inline]
    pub fn node(&self, id: NodeId) -> Option<&'a ClusterNode> {
        self.nodes.get(id.0 as usize)
    }

    /// The words of a cluster's local index; empty if the leaf's links lead past the end.
    #[inline]
    pub fn local_words(&self, leaf: &ClusterNode) -> &'a [u32] {
        let [first, count] = leaf.links;
        self.words.get(first as usize..first.saturating_add(count) as usize).unwrap_or(&[])
    }
}

/// Casts the section of `count` elements that begins at the byte `start`.
fn section<T: Pod>(bytes: &[u8], start: usize, count: usize) -> Result<&[T], OpenError> {
    if count == 0 {
        return Ok(&[]);
    }
    let end = start.saturating_add(count.saturating_mul(size_of::<T>()));
    bytes
        .get(start..end)
        .and_then(|bytes| bytemuck::try_cast_slice(bytes).ok())
        .ok_or(OpenError::Truncated)
}
