//! Oracle of clusters: compares all pairs.
//!
//! Size classes are cut from the sorted sizes by the rule of the core's module `cluster::size_class`. In a class, all
//! primitives that are connected by gaps of at most delta form one cluster.

use arboleda::{Aabb, Options, Triangle};

/// Finds the triangles of each cluster, ascending; clusters are sorted by their lowest triangle.
///
/// `objects` has the object of each triangle, as for [`arboleda::Scene::with_objects`].
pub fn clusters(
    triangles: &[Triangle],
    objects: Option<&[u32]>,
    options: &Options,
) -> Vec<Vec<u32>> {
    // 1. Primitives: the triangles of each, and their bounding box.
    let mut primitives: Vec<(Vec<u32>, Aabb)> = Vec::new();
    let mut index_of = std::collections::BTreeMap::new();
    for (id, triangle) in triangles.iter().enumerate() {
        let name = objects.map_or(id as u32, |objects| objects[id]);
        let index = *index_of.entry(name).or_insert_with(|| {
            primitives.push((Vec::new(), Aabb::EMPTY));
            primitives.len() - 1
        });
        primitives[index].0.push(id as u32);
        primitives[index].1 = primitives[index].1.union(triangle.bounds());
    }

    // 2. Clusters of each class, by all pairs.
    let mut clusters = Vec::new();
    let sizes: Vec<f64> = primitives.iter().map(|p| p.1.diagonal_squared()).collect();
    for (members, typical) in classes(&sizes, options.size_classes as usize) {
        let proximity = f64::from(options.proximity);
        let delta_squared = proximity * proximity * typical;
        let mut waiting = members;
        while let Some(first) = waiting.pop() {
            let mut cluster = vec![first];
            let mut asked = 0;
            while let Some(&asker) = cluster.get(asked) {
                asked += 1;
                let near = |&mut other: &mut usize| {
                    gap_squared(&primitives[asker].1, &primitives[other].1) <= delta_squared
                };
                cluster.extend(waiting.extract_if(.., near));
            }
            let mut ids: Vec<u32> = cluster.iter().flat_map(|&p| primitives[p].0.clone()).collect();
            ids.sort_unstable();
            clusters.push(ids);
        }
    }
    clusters.sort_unstable();
    clusters
}

/// Divides primitives into size classes. Returns the members of each class and the square of its median size.
fn classes(sizes: &[f64], most: usize) -> Vec<(Vec<usize>, f64)> {
    let mut sorted: Vec<usize> = (0..sizes.len()).collect();
    sorted.sort_by(|&a, &b| sizes[a].total_cmp(&sizes[b]));
    // Candidate cuts: gaps of a factor of two in the diagonal, with at least a hundredth of the primitives below.
    let mut gaps: Vec<(f64, usize)> = (1..sorted.len())
        .map(|place| (sizes[sorted[place - 1]], sizes[sorted[place]], place))
        .filter(|&(below, above, place)| {
            below > 0.0 && above >= 4.0 * below && place * 100 >= sorted.len()
        })
        .map(|(below, above, place)| (above / below, place))
        .collect();
    gaps.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    let mut cuts: Vec<usize> = gaps.iter().take(most - 1).map(|gap| gap.1).collect();
    cuts.sort_unstable();
    cuts.insert(0, 0);
    cuts.push(sorted.len());
    cuts.windows(2)
        .filter(|cut| cut[0] < cut[1])
        .map(|cut| {
            let members = sorted[cut[0]..cut[1]].to_vec();
            let median = sizes[sorted[usize::midpoint(cut[0], cut[1])]];
            (members, median)
        })
        .collect()
}

/// Computes the square of the gap between two boxes, axis by axis.
pub fn gap_squared(p: &Aabb, q: &Aabb) -> f64 {
    let (plo, phi, qlo, qhi) = (p.lo.to_array(), p.hi.to_array(), q.lo.to_array(), q.hi.to_array());
    let mut sum = 0.0;
    for axis in 0..3 {
        let low = if plo[axis] > qlo[axis] { plo[axis] } else { qlo[axis] };
        let high = if phi[axis] < qhi[axis] { phi[axis] } else { qhi[axis] };
        let gap = f64::from(low) - f64::from(high);
        if gap > 0.0 {
            sum += gap * gap;
        }
    }
    sum
}
