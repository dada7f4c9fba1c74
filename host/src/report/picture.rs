//! Pictures of scenes: clusters with their boxes and tree, and the light that photons brought.

use arboleda::clusters::{ClusterNode, NodeId};
use arboleda::custom::Sections;
use arboleda::{Aabb, RayIndex, Triangle, Vec3};
use rayon::prelude::*;

use super::camera::corners;
use super::canvas::TEXT_HEIGHT;
use super::plot::number as plot_number;
use super::{Camera, Canvas, Colour};

/// Pixels between the border and text.
const MARGIN: i64 = 10;
/// Clusters that are numbered: more would hide what they stand on.
const MOST_NUMBERS: usize = 48;
/// The ground of pictures of light.
const NIGHT: Colour = Colour(0.10, 0.10, 0.12);
/// Rays across and down a pixel.
const SAMPLES: u32 = 2;

/// A colour for each cluster, neighbours in number far apart in hue.
pub fn cluster_colour(cluster: u32) -> Colour {
    // Steps of the golden ratio fill the circle of hues evenly.
    let hue = (f64::from(cluster) * 0.618_033_988_749_895 + 0.07).fract() as f32 * 6.0;
    let ramp = |offset: f32| {
        let x = (hue + offset).rem_euclid(6.0);
        (if x < 3.0 { x - 1.0 } else { 5.0 - x }).clamp(0.0, 1.0)
    };
    let pure = Colour(ramp(2.0), ramp(0.0), ramp(4.0));
    pure.mixed(Colour(0.62, 0.62, 0.62), 0.38)
}

/// A colour for a value of 0 to 1, from dark violet over red to light yellow.
pub fn heat(value: f32) -> Colour {
    const STOPS: [Colour; 5] = [
        Colour(0.03, 0.02, 0.10),
        Colour(0.34, 0.06, 0.43),
        Colour(0.74, 0.22, 0.33),
        Colour(0.98, 0.56, 0.04),
        Colour(0.99, 0.99, 0.75),
    ];
    let place = value.clamp(0.0, 1.0) * (STOPS.len() - 1) as f32;
    let stop = (place as usize).min(STOPS.len() - 2);
    STOPS[stop].mixed(STOPS[stop + 1], place - stop as f32)
}

/// Paints what a camera sees; `colour_of` gives the colour of a triangle and of the shade it is in.
///
/// Returns the distance along the line of sight at each pixel, infinite where nothing is.
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
                        // The direction has length 1 along the line of sight, so t is the distance.
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

/// Light from the camera and a little from above, so that edges show.
fn shade(triangle: &Triangle, direction: Vec3) -> f32 {
    let normal = triangle.normal().normalize_or_zero();
    let facing = normal.dot(direction.normalize_or_zero()).abs();
    let key = normal.dot(Vec3::new(0.35, 0.50, 0.79)).abs();
    0.35 + 0.35 * facing + 0.35 * key
}

/// Paints the clusters in colours with their numbers, the boxes of the cluster tree around them, below it the tree,
/// and above it a title and the size of the scene.
pub fn paint_clusters(
    canvas: &mut Canvas,
    index: &(dyn RayIndex + Sync),
    triangles: &[Triangle],
    tree: &Sections<'_>,
    cluster_of: &[u32],
    up: Vec3,
    title: &str,
) {
    let Some(root) = tree.nodes().last() else {
        return;
    };
    let strip = if tree.cluster_count() > 1 { canvas.height() / 5 } else { 0 };
    let mut view = Canvas::new(canvas.width(), canvas.height() - strip);
    let camera = Camera::looking_at(&root.bounds, up, view.width(), view.height());
    let depths = paint(&mut view, &camera, index, triangles, |triangle, corners, direction| {
        cluster_colour(cluster_of[triangle as usize]).times(shade(corners, direction))
    });
    // Boxes of many clusters would hide what they surround.
    let clusters = tree.cluster_count() as usize;
    let boxes: &[ClusterNode] = match clusters {
        0..=64 => tree.nodes(),
        65..=400 => &tree.nodes()[..clusters],
        _ => &[],
    };
    for (at, node) in boxes.iter().enumerate() {
        let leaf = at < clusters;
        let colour = if leaf { cluster_colour(at as u32).times(0.55) } else { Colour::INK };
        outline(&mut view, &camera, &depths, &node.bounds, colour, if leaf { 0.9 } else { 0.35 });
    }
    let spelled = has_room_for_text(canvas);
    if spelled && (2..=MOST_NUMBERS).contains(&clusters) {
        for (number, node) in tree.nodes()[..clusters].iter().enumerate() {
            let Some((x, y, _)) = camera.project(node.bounds.centre()) else {
                continue;
            };
            write_centred(&mut view, (x, y), &number.to_string());
        }
    }
    let [x, y, z] = root.bounds.extent().map(short);
    if spelled {
        for (line, text) in (0..).zip([title, &format!("size: {x} x {y} x {z}")]) {
            let place = (MARGIN, MARGIN + line * (TEXT_HEIGHT + 2));
            view.text(place, text, Colour::INK, Colour::PAPER);
        }
    }
    canvas.paste(&view, 0, 0);
    if strip > 0 {
        draw_tree(canvas, tree, canvas.height() - strip);
    }
}

/// Paints each triangle by the light it received: `irradiance` in W/m2 by triangle id, brightest at the
/// 98th percentile of the lit ones; with a title and the scale of the colours.
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
        // The eye judges brightness about by its square root.
        heat(share.sqrt()).times(0.6 + 0.4 * shade(corners, direction))
    });
    if has_room_for_text(canvas) {
        canvas.text((MARGIN, MARGIN), title, Colour::PAPER, NIGHT);
        draw_scale(canvas, brightest);
    }
}

/// Draws the colours of irradiances from 0 to the brightest, with five of them as numbers.
fn draw_scale(canvas: &mut Canvas, brightest: f64) {
    const STEPS: i64 = 4;
    let width = (i64::from(canvas.width()) - 2 * MARGIN).min(480);
    let bottom = i64::from(canvas.height()) - MARGIN;
    let top = bottom - 2 * TEXT_HEIGHT;
    for x in 0..width {
        let colour = heat(x as f32 / width as f32);
        for y in top..top + TEXT_HEIGHT - 4 {
            canvas.blend(MARGIN + x, y, colour, 1.0);
        }
    }
    for step in 0..=STEPS {
        // Colours go by the square root.
        let share = step as f64 / STEPS as f64;
        let unit = if step == STEPS { " W/m2" } else { "" };
        let text = format!("{}{unit}", short(brightest * share * share));
        let x = MARGIN + (width - 1) * step / STEPS;
        canvas.text((x, bottom - TEXT_HEIGHT), &text, Colour::PAPER, NIGHT);
    }
}

/// Tells whether a picture is large enough for text beside the scene.
fn has_room_for_text(canvas: &Canvas) -> bool {
    canvas.width() >= 480 && canvas.height() >= 360
}

/// Writes a value in few characters; small values with an exponent.
fn short(value: f64) -> String {
    if value != 0.0 && value.abs() < 0.01 { format!("{value:.1e}") } else { plot_number(value) }
}

/// Writes a number on what is already there.
fn write_centred(canvas: &mut Canvas, (x, y): (f32, f32), text: &str) {
    let left = x.round() as i64 - Canvas::text_width(text) / 2;
    canvas.text((left, y.round() as i64 - TEXT_HEIGHT / 2), text, Colour::INK, Colour::PAPER);
}

/// Draws the twelve edges of a box, faint where something is in front.
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
                // 1 / distance is what goes evenly along the line on the page.
                let distance = 1.0 / ((1.0 - share) / d0 + share / d1);
                let place = usize::try_from(y * width + x).unwrap_or(usize::MAX);
                let hidden = depths.get(place).is_some_and(|&depth| depth < distance * 0.998);
                if hidden { strength * 0.25 } else { strength }
            });
        }
    }
}

/// Draws the cluster tree below the scene: the root on top, a dot for each cluster.
fn draw_tree(canvas: &mut Canvas, tree: &Sections<'_>, top: u32) {
    let nodes = tree.nodes();
    let clusters = tree.cluster_count() as usize;
    // Leaves from left to right as the tree has them; inner nodes in the middle above their children.
    let mut across = vec![0.0_f32; nodes.len()];
    let mut level = vec![0_u32; nodes.len()];
    let mut next_leaf = 0.0;
    let mut stack = vec![nodes.len() - 1];
    while let Some(at) = stack.pop() {
        if at < clusters {
            across[at] = (next_leaf + 0.5) / clusters as f32;
            next_leaf += 1.0;
        } else {
            stack.extend(nodes[at].links.iter().rev().map(|&child| child as usize));
        }
    }
    for at in clusters..nodes.len() {
        let [left, right] = nodes[at].links.map(|child| child as usize);
        across[at] = (across[left] + across[right]) * 0.5;
        level[at] = level[left].max(level[right]) + 1;
    }
    let deepest = level[nodes.len() - 1].max(1) as f32;
    // Numbers stand below the dots where there is room for them.
    let numbered = has_room_for_text(canvas) && clusters <= MOST_NUMBERS;
    let margin = 24.0;
    let room = canvas.height() as f32 - top as f32 - 2.0 * margin;
    let spread = canvas.width() as f32 - 2.0 * margin;
    let place = |at: usize| {
        let y = top as f32 + margin + room * (1.0 - level[at] as f32 / deepest);
        (margin + spread * across[at], y)
    };
    let places: Vec<_> = (0..nodes.len()).map(place).collect();
    for (at, node) in nodes.iter().enumerate() {
        if node.parent != NodeId::NONE {
            let ((x, y), (parent_x, parent_y)) = (places[at], places[node.parent.0 as usize]);
            let line = Colour::INK.mixed(Colour::PAPER, 0.4);
            canvas.line((x, y), (x, parent_y), line, |_, _, _| 1.0);
            canvas.line((x, parent_y), (parent_x, parent_y), line, |_, _, _| 1.0);
        }
    }
    let radius = (spread / clusters as f32 * 0.35).clamp(1.0, 7.0);
    for (at, &place) in places.iter().enumerate().take(clusters) {
        canvas.disc(place, radius, cluster_colour(at as u32));
        if numbered {
            write_centred(canvas, (place.0, place.1 + radius + 10.0), &at.to_string());
        }
    }
}
