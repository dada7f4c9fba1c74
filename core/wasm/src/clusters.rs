//! The clusters of a scene, and the tree that joins them.

use core::ffi::c_void;

use arboleda::clusters::{find, scratch_capacity};
use arboleda_ffi::parts::{Arrays, Caller, Output, apart, borrowed, chosen, reported};
use arboleda_ffi::{arb_error, arb_index, arb_mesh, arb_options, arb_status};

use crate::records::{NONE, Records, bits_of};

/// Words of a node of the cluster tree: lower corner, upper corner, parent, left child, right child.
const NODE_WORDS: usize = 9;

/// Bytes of scratch that [`arb_clusters`] needs.
#[unsafe(no_mangle)]
pub extern "C" fn arb_clusters_scratch_bytes(triangle_count: usize) -> usize {
    scratch_capacity(triangle_count)
}

/// Finds the cluster of each triangle: those of every hierarchy that is built of the same mesh and options.
///
/// - `cluster_of`: receives the number of a cluster for each triangle of the mesh.
/// - `cluster_count`: receives the number of clusters.
/// - `scratch`: begins at a multiple of 64 bytes.
///
/// Errors: those of `arb_build` for mesh, options and scratch.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arb_clusters(
    mesh: *const arb_mesh,
    options: *const arb_options,
    scratch: *mut c_void,
    scratch_bytes: usize,
    cluster_of: *mut u32,
    cluster_count: *mut usize,
    error: *mut arb_error,
) -> arb_status {
    // SAFETY: the promise of the crate's page.
    let caller = unsafe { Caller::promises() };
    reported(caller, error, || {
        let chosen = chosen(caller, options)?;
        let arrays = Arrays::check(caller, mesh)?;
        let scene = arrays.scene(caller, chosen.beside);
        let scratch = Output::<u8>::check(scratch.cast(), scratch_bytes, "scratch")?;
        let to = Output::check(cluster_of, arrays.mesh(caller).len(), "cluster_of")?;
        let count = Output::one(cluster_count, "cluster_count")?;
        apart(&[scratch.region(), to.region(), count.region()], &arrays.regions())?;
        let clusters = find(&scene, &chosen.options, caller.borrow_mut(scratch))?;
        let cluster_of = caller.borrow_mut(to);
        for (number, triangles) in (0..).zip(clusters.iter()) {
            for &triangle in triangles {
                if let Some(slot) = cluster_of.get_mut(triangle as usize) {
                    *slot = number;
                }
            }
        }
        caller.write(count, clusters.count());
        Ok(())
    })
}

/// Writes the nodes of the cluster tree: the clusters first, a join after what it joins, the root last.
///
/// - `nodes`: room for `capacity` records of 9 words: the box, the lower corner first; the parent; the two nodes that
///   were joined. `0xffff_ffff` stands for the root's parent, and for the children of a cluster.
/// - `node_count`: receives the number of nodes, also if there are more than `capacity`.
///
/// Errors: `ARB_NULL_POINTER`, `ARB_MISALIGNED_POINTER`, `ARB_LENGTH_OVERFLOW`, `ARB_OVERLAP`, `ARB_NOT_OPEN`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn arb_cluster_tree(
    index: *const arb_index,
    nodes: *mut u32,
    capacity: usize,
    node_count: *mut usize,
    error: *mut arb_error,
) -> arb_status {
    // SAFETY: the promise of the crate's page.
    let caller = unsafe { Caller::promises() };
    reported(caller, error, || {
        let index = caller.index(index)?;
        let room = Output::check(nodes, capacity.saturating_mul(NODE_WORDS), "nodes")?;
        let count = Output::one(node_count, "node_count")?;
        apart(&[room.region(), count.region()], &borrowed(index))?;
        let mut records = Records::<NODE_WORDS>::new(caller.borrow_mut(room));
        for node in index.cluster_tree().iter() {
            let [a, b, c, d, e, f] = bits_of(node.bounds.lo, node.bounds.hi);
            let [left, right] = node.children.map_or([NONE; 2], |ids| ids.map(|id| id.0));
            let parent = node.parent.map_or(NONE, |id| id.0);
            records.push([a, b, c, d, e, f, parent, left, right]);
        }
        caller.write(count, records.count());
        Ok(())
    })
}
