//! Pictures of scenes: clusters with their bounding boxes and tree, and irradiance.

use arboleda::clusters::{ClusterTree, TreeNode};
use arboleda::{Aabb, RayIndex, Triangle, Vec3};
use rayon::prelude::*;

use super::camera::corners;
use super::canvas::TEXT_HEIGHT;
use super::colour::{cluster_colour, heat};
use super::legend::{ColourScale, draw_legend};
use super::number::short_number;
use super::{Camera, Canvas, Colour};

/// Pixels between the border and text.
const MARGIN: i64 = 10;
/// Most clusters with numbers in the picture. More numbers would hide the clusters.
const MOST_NUMBERS: usize = 48;
/// Background of pictures of irradiance.
pub(crate) const NIGHT: Colour = Colour(0.10, 0.10, 0.12);
/// Rays through a pixel along each axis.
const SAMPLES: u32 = 2;

/// Paints the scene as a camera sees it. `colour_of` returns the colour of a triangle, by its id, its corners and the
/// ray's direction.
///
/// Returns the distance along the line of sight at each pixel, infinite without a hit.
fn paint(
    canvas: &mut Canvas,
    camera: &Camera,
    index: &(dyn RayIndex + Sync),
    triangles: &[Triangle],
    colour_of: impl Fn(u32, &Triangle, Vec3) -> Colour + Sync,
) -> Vec<f32> {
    let width = canvas.width() as usize;
    let mut depths = vec![f32::INFINITY; width * canvas.height() as usize];
    let rows: Vec<_> = canvas.rows_mut().zip(depths.chunks_mut(width)).enumerate().collect();
    rows.into_par_iter().for_each(|(y, (pixels, depths))| {
        for (x, (pixel, depth)) in pixels.iter_mut().zip(depths).enumerate() {
            let mut sum = Colour(0.0, 0.0, 0.0);
            for sample in 0..SAMPLES * SAMPLES {
                let offset = |at: u32| (at as f32 + 0.5) / SAMPLES as f32;
                let (dx, dy) = (offset(sample % SAMPLES), offset(sample / SAMPLES));
                let ray = camera.ray(x as f32 + dx, y as f32 + dy);
                let hit = ray.as_ref().and_then(|ray| index.closest_hit(ray));
                let colour = match (&ray, hit) {
                    (Some(ray), Some(hit)) => {
                        // The direction's component along the line of sight is 1, so t is the distance along it.
                        *depth = depth.min(hit.t);
                        let triangle = &triangles[hit.triangle.0 as usize];
                        colour_of(hit.triangle.0, triangle, ray.direction())
                    }
                    _ => *pixel,
                };
                let share = 1.0 / (SAMPLES * SAMPLES) as f32;
                sum = Colour(
                    sum.0 + colour.0 * share,
                    sum.1 + colour.1 * share,
                    sum.2 + colour.2 * share,
                );
            }
            *pixel = sum;
        }
    });
    depths
}

/// Computes the shade of a triangle lit from the camera and from above, so that edges are visible.
fn shade(triangle: &Triangle, direction: Vec3) -> f32 {
    let normal = triangle.normal().normalize_or_zero();
    let facing = normal.dot(direction.normalize_or_zero()).abs();
    let key = normal.dot(Vec3::new(0.35, 0.50, 0.79)).abs();
    0.35 + 0.35 * facing + 0.35 * key
}

/// Paints the clusters in colours, with their numbers and the bounding boxes of the cluster tree. The title and the
/// size of the scene are above the scene, the tree is below.
pub fn paint_clusters(
    canvas: &mut Canvas,
    index: &(dyn RayIndex + Sync),
    triangles: &[Triangle],
    tree: ClusterTree<'_>,
    cluster_of: &[u32],
    up: Vec3,
    title: &str,
) {
    let nodes: Vec<TreeNode> = tree.iter().collect();
    let Some(root) = nodes.last() else {
        return;
    };
    let strip = if tree.cluster_count() > 1 { canvas.height() / 5 } else { 0 };
    let mut view = Canvas::new(canvas.width(), canvas.height() - strip);
    let camera = Camera::looking_at(&root.bounds, up, view.width(), view.height());
    let depths = paint(&mut view, &camera, index, triangles, |triangle, corners, direction| {
        cluster_colour(cluster_of[triangle as usize]).times(shade(corners, direction))
    });
    // Up to 64 clusters all boxes are drawn, up to 400 those of clusters; more boxes would hide the clusters.
    let clusters = tree.cluster_count() as usize;
    let boxes = match clusters {
        0..=64 => nodes.len(),
        65..=400 => clusters,
        _ => 0,
    };
    for (at, node) in nodes.iter().enumerate().take(boxes) {
        let leaf = node.children.is_none();
        let colour = if leaf { cluster_colour(at as u32).times(0.55) } else { Colour::INK };
        outline(&mut view, &camera, &depths, &node.bounds, colour, if leaf { 0.9 } else { 0.35 });
    }
    let spelled = has_room_for_text(canvas);
    if spelled && (2..=MOST_NUMBERS).contains(&clusters) {
        for (number, node) in nodes.iter().enumerate().take(clusters) {
            let Some((x, y, _)) = camera.project(node.bounds.centre()) else {
                continue;
            };
            write_centred(&mut view, (x, y), &number.to_string());
        }
    }
    let [x, y, z] = root.bounds.extent().map(short_number);
    if spelled {
        for (line, text) in (0..).zip([title, &format!("size: {x} x {y} x {z}")]) {
            let corner = (MARGIN, MARGIN + line * (TEXT_HEIGHT + 2));
            view.text(corner, text, Colour::INK, Colour::PAPER);
        }
    }
    canvas.paste(&view, 0, 0);
    if strip > 0 {
        draw_tree(canvas, &nodes, clusters, canvas.height() - strip);
    }
}

/// Paints each triangle by its irradiance, with a title and the scale of colours. `irradiance` is in W/m2, by triangle
/// id. The brightest colour is at the 98th percentile of the lit triangles.
pub fn paint_irradiance(
    canvas: &mut Canvas,
    index: &(dyn RayIndex + Sync),
    triangles: &[Triangle],
    bounds: &Aabb,
    irradiance: &[f64],
    up: Vec3,
    title: &str,
) {
    let mut lit: Vec<f64> =
        irradiance.iter().copied().filter(|&e| e > 0.0 && e.is_finite()).collect();
    lit.sort_by(f64::total_cmp);
    let brightest = lit.get(lit.len() * 98 / 100).copied().unwrap_or(1.0);
    let camera = Camera::looking_at(bounds, up, canvas.width(), canvas.height());
    canvas.pixels_mut().fill(NIGHT);
    paint(canvas, &camera, index, triangles, |triangle, corners, direction| {
        let share = (irradiance[triangle as usize] / brightest) as f32;
        // Perceived brightness is about the square root of irradiance.
        heat(share.sqrt()).times(0.6 + 0.4 * shade(corners, direction))
    });
    if has_room_for_text(canvas) {
        canvas.text((MARGIN, MARGIN), title, Colour::PAPER, NIGHT);
        draw_legend(canvas, &ColourScale::Root(brightest), "W/m2", Colour::PAPER, NIGHT);
    }
}

/// Tells whether a picture is large enough for text.
pub(crate) fn has_room_for_text(canvas: &Canvas) -> bool {
    canvas.width() >= 480 && canvas.height() >= 360
}

/// Writes a text centred at a point.
fn write_centred(canvas: &mut Canvas, (x, y): (f32, f32), text: &str) {
    let left = x.round() as i64 - Canvas::text_width(text) / 2;
    canvas.text((left, y.round() as i64 - TEXT_HEIGHT / 2), text, Colour::INK, Colour::PAPER);
}

/// Draws the twelve edges of a box, faint where a triangle hides them.
fn outline(
    canvas: &mut Canvas,
    camera: &Camera,
    depths: &[f32],
    bounds: &Aabb,
    colour: Colour,
    strength: f32,
) {
    let width = i64::from(canvas.width());
    let corners = corners(bounds);
    for from in 0..8_usize {
        for to in (0..3).map(|axis| from | 1 << axis).filter(|&to| to != from) {
            let ends = (camera.project(corners[from]), camera.project(corners[to]));
            let (Some((x0, y0, d0)), Some((x1, y1, d1))) = ends else {
                continue;
            };
            canvas.line((x0, y0), (x1, y1), colour, |share, x, y| {
                // The reciprocal of the distance is linear along the projected line.
                let distance = 1.0 / ((1.0 - share) / d0 + share / d1);
                let pixel = usize::try_from(y * width + x).unwrap_or(usize::MAX);
                let hidden = depths.get(pixel).is_some_and(|&depth| depth < distance * 0.998);
                if hidden { strength * 0.25 } else { strength }
            });
        }
    }
}

/// Draws the cluster tree below the scene, with the root on top and a dot for each cluster.
fn draw_tree(canvas: &mut Canvas, nodes: &[TreeNode], clusters: usize, top: u32) {
    // 1. Positions: leaves from left to right in depth-first order, inner nodes above the middle of their children.
    let mut across = vec![0.0_f32; nodes.len()];
    let mut level = vec![0_u32; nodes.len()];
    let mut next_leaf = 0.0;
    let mut stack = vec![nodes.len() - 1];
    while let Some(at) = stack.pop() {
        if let Some(children) = nodes[at].children {
            stack.extend(children.iter().rev().map(|child| child.0 as usize));
        } else {
            across[at] = (next_leaf + 0.5) / clusters as f32;
            next_leaf += 1.0;
        }
    }
    for (at, node) in nodes.iter().enumerate() {
        let Some(children) = node.children else { continue };
        let [left, right] = children.map(|child| child.0 as usize);
        across[at] = (across[left] + across[right]) * 0.5;
        level[at] = level[left].max(level[right]) + 1;
    }
    let deepest = level[nodes.len() - 1].max(1) as f32;
    let numbered = has_room_for_text(canvas) && clusters <= MOST_NUMBERS;
    let margin = 24.0;
    let room = canvas.height() as f32 - top as f32 - 2.0 * margin;
    let spread = canvas.width() as f32 - 2.0 * margin;
    let position = |at: usize| {
        let y = top as f32 + margin + room * (1.0 - level[at] as f32 / deepest);
        (margin + spread * across[at], y)
    };
    let positions: Vec<_> = (0..nodes.len()).map(position).collect();

    // 2. Lines from each node to its parent.
    for (at, node) in nodes.iter().enumerate() {
        if let Some(parent) = node.parent {
            let ((x, y), (parent_x, parent_y)) = (positions[at], positions[parent.0 as usize]);
            let line = Colour::INK.mixed(Colour::PAPER, 0.4);
            canvas.line((x, y), (x, parent_y), line, |_, _, _| 1.0);
            canvas.line((x, parent_y), (parent_x, parent_y), line, |_, _, _| 1.0);
        }
    }

    // 3. Dots of the clusters, with numbers below where there is room.
    let radius = (spread / clusters as f32 * 0.35).clamp(1.0, 7.0);
    for (at, &(x, y)) in positions.iter().enumerate().take(clusters) {
        canvas.disc((x, y), radius, cluster_colour(at as u32));
        if numbered {
            write_centred(canvas, (x, y + radius + 10.0), &at.to_string());
        }
    }
}
