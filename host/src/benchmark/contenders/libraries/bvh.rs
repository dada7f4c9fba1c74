//! The crate `bvh`: a binary hierarchy by binned surface area, one triangle a leaf.
//!
//! Its own iterators know nothing of the closest hit so far and visit all boxes that the ray meets, so
//! its public nodes are walked here, near child first, with its own box test. The losers were
//! `nearest_child_traverse_iterator` (half as fast) and `traverse_iterator` with a query that shrinks
//! (0.6 to 0.8). Its triangle test sees front faces only: the usual one takes its place.

use std::time::Instant;

use arboleda::{Hit, Ray, Triangle, Vec3};
use bvh::aabb::{Aabb, Bounded};
use bvh::bounding_hierarchy::BHShape;
use bvh::bvh::{Bvh, BvhNode};
use bvh::ray::Ray as BvhRay;
use nalgebra::{Point3, Vector3};

use super::moller_trumbore::EdgeTriangle;
use crate::benchmark::contenders::PeerError;
use crate::benchmark::contenders::contender::Contender;
use crate::benchmark::contenders::peer::{BuiltPeer, Peer, Setting, found, refused};

/// It has no settings.
pub const PEER: Peer =
    Peer { name: "bvh", settings: &[Setting { name: "sah, ordered walk", build: Binary::build }] };

/// Box of a triangle, as its builder wants it.
struct TriangleShape {
    bounds: Aabb<f32, 3>,
    node: usize,
}

impl Bounded<f32, 3> for TriangleShape {
    fn aabb(&self) -> Aabb<f32, 3> {
        self.bounds
    }
}

impl BHShape<f32, 3> for TriangleShape {
    fn set_bh_node_index(&mut self, node: usize) {
        self.node = node;
    }

    fn bh_node_index(&self) -> usize {
        self.node
    }
}

struct Binary {
    bvh: Bvh<f32, 3>,
    triangles: Vec<EdgeTriangle>,
}

/// Its own iterators have a stack of 32, which deeper hierarchies overflow.
const STACK: usize = 128;

impl Binary {
    fn build(triangles: &[Triangle]) -> Result<BuiltPeer, PeerError> {
        let point = |v: Vec3| Point3::new(v.x, v.y, v.z);
        let start = Instant::now();
        let mut shapes: Vec<TriangleShape> = triangles
            .iter()
            .map(|triangle| {
                let bounds = triangle.bounds();
                TriangleShape {
                    bounds: Aabb::with_bounds(point(bounds.lo), point(bounds.hi)),
                    node: 0,
                }
            })
            .collect();
        let bvh = Bvh::build(&mut shapes);
        let triangles = triangles.iter().map(EdgeTriangle::new).collect();
        let build_seconds = start.elapsed().as_secs_f64();
        let depth = depth(&bvh);
        if depth >= STACK {
            return Err(refused("bvh", format_args!("its hierarchy is {depth} levels deep")));
        }
        Ok(BuiltPeer { contender: Box::new(Self { bvh, triangles }), build_seconds })
    }

    /// Walks towards the closest hit and returns it; `enough` may end the walk at any hit.
    #[inline]
    fn walk(&self, ray: &Ray, enough: impl Fn() -> bool) -> Hit {
        let (origin, direction) = (ray.origin(), ray.direction());
        let vector = Vector3::new(direction.x, direction.y, direction.z);
        // Not `Ray::new`, which scales the direction to unit length and with it all parameters.
        let theirs = BvhRay {
            origin: Point3::new(origin.x, origin.y, origin.z),
            direction: vector,
            inv_direction: vector.map(|x| 1.0 / x),
        };
        let mut best = Hit { t: ray.t_max(), ..Hit::NONE };
        let mut stack = [(0, 0.0); STACK];
        let mut height = 0;
        let mut at = 0;
        while let Some(node) = self.bvh.nodes.get(at) {
            match *node {
                BvhNode::Leaf { shape_index, .. } => {
                    if let Some(t) = self.triangles[shape_index].hit(origin, direction, best.t) {
                        best = found(shape_index as u32, t);
                        if enough() {
                            return best;
                        }
                    }
                }
                BvhNode::Node {
                    child_l_index,
                    ref child_l_aabb,
                    child_r_index,
                    ref child_r_aabb,
                    ..
                } => {
                    let entry = |bounds| {
                        theirs.intersection_slice_for_aabb(bounds).map_or(f32::INFINITY, |s| s.0)
                    };
                    let (left, right) = (entry(child_l_aabb), entry(child_r_aabb));
                    let mut near = (child_l_index, left);
                    let mut far = (child_r_index, right);
                    if right < left {
                        (near, far) = (far, near);
                    }
                    if far.1 < best.t {
                        stack[height] = far;
                        height += 1;
                    }
                    if near.1 < best.t {
                        at = near.0;
                        continue;
                    }
                }
            }
            // The closest one left over that can still matter.
            loop {
                if height == 0 {
                    return best;
                }
                height -= 1;
                if stack[height].1 < best.t {
                    at = stack[height].0;
                    break;
                }
            }
        }
        best
    }
}

/// Finds the deepest level; the root is level 0.
fn depth(bvh: &Bvh<f32, 3>) -> usize {
    let mut deepest = 0;
    let mut open = vec![(0, 0)];
    while let Some((at, level)) = open.pop() {
        deepest = deepest.max(level);
        if let Some(BvhNode::Node { child_l_index, child_r_index, .. }) = bvh.nodes.get(at) {
            open.extend([(*child_l_index, level + 1), (*child_r_index, level + 1)]);
        }
    }
    deepest
}

impl Contender for Binary {
    fn bytes(&self) -> Option<usize> {
        Some(size_of_val(self.bvh.nodes.as_slice()) + size_of_val(self.triangles.as_slice()))
    }

    fn closest_hits(&self, rays: &[Ray], hits: &mut [Hit]) {
        for (ray, answer) in rays.iter().zip(hits) {
            let best = self.walk(ray, || false);
            *answer = if best.is_none() { Hit::NONE } else { best };
        }
    }

    fn occluded(&self, rays: &[Ray], answers: &mut [bool]) {
        for (ray, answer) in rays.iter().zip(answers) {
            *answer = !self.walk(ray, || true).is_none();
        }
    }
}
