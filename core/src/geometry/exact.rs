//! The volumes of the kernel as expansions: what decides where `f64` cannot.

use glam::Vec3;

use super::expansion::Expansion;
use super::{Ray, Triangle};

/// A difference of two `f32`: at most two terms.
type Difference = Expansion<2>;
/// A difference plus a difference times a midpoint of two `f32` (two terms each): 2 + 4 terms.
type Point = Expansion<6>;
/// A triple product. Either 1-term times (2-term times 6-term, twice): 1 * 2 * (2 * 24) = 96 terms an
/// axis; or 3-term times (2-term times 2-term, twice): 3 * 2 * (2 * 8) = 96. Three axes.
pub(super) type Volume = Expansion<288>;

/// The volumes of one ray and one triangle, exactly.
pub(super) struct Exact {
    origin: Vec3,
    direction: Vec3,
    triangle: Triangle,
}

impl Exact {
    pub fn new(ray: &Ray, triangle: Triangle) -> Self {
        Self { origin: ray.origin(), direction: ray.direction(), triangle }
    }

    /// `det = d . (e1 x e2)`
    pub fn det(&self) -> Volume {
        triple(&self.d(), &self.e1(), &self.e2().each_ref().map(widened))
    }

    /// `det t - m det = (a - m d) . (e1 x e2)`
    pub fn t_minus(&self, m: f64) -> Volume {
        // m has at most 25 bits and d has 24, so their product is one f64.
        let step = self.direction.to_array().map(|d| -m * f64::from(d));
        let p = zip(&self.a(), &step, |a, step| a.plus(&Expansion::<1>::of(*step)));
        triple(&p, &self.e1(), &self.e2().each_ref().map(widened))
    }

    /// `det u - m det = d . (e2 x (a + m e1))`
    pub fn u_minus(&self, m: f64) -> Volume {
        triple(&self.d(), &self.e2(), &self.a_plus(m, &self.e1()))
    }

    /// `det v - m det = -d . (e1 x (a + m e2))`
    pub fn v_minus(&self, m: f64) -> Volume {
        triple(&self.d(), &self.e1(), &self.a_plus(m, &self.e2())).negated()
    }

    /// `det w = d . ((B - o) x (C - o))`
    pub fn w(&self) -> Volume {
        let b = differences(self.triangle.b, self.origin);
        let c = differences(self.triangle.c, self.origin);
        triple(&self.d(), &b, &c.each_ref().map(widened))
    }

    fn d(&self) -> [Point; 3] {
        self.direction.to_array().map(|d| Point::of(f64::from(d)))
    }

    fn a(&self) -> [Difference; 3] {
        differences(self.triangle.a, self.origin)
    }

    fn e1(&self) -> [Difference; 3] {
        differences(self.triangle.b, self.triangle.a)
    }

    fn e2(&self) -> [Difference; 3] {
        differences(self.triangle.c, self.triangle.a)
    }

    fn a_plus(&self, m: f64, e: &[Difference; 3]) -> [Point; 3] {
        zip(&self.a(), e, |a, e| a.plus(&e.scaled::<4>(m)))
    }
}

fn differences(p: Vec3, q: Vec3) -> [Difference; 3] {
    zip(&p.to_array(), &q.to_array(), |&p, &q| Difference::difference(p, q))
}

fn widened(difference: &Difference) -> Point {
    difference.plus(&Expansion::<0>::default())
}

fn zip<A, B, C>(a: &[A; 3], b: &[B; 3], f: impl Fn(&A, &B) -> C) -> [C; 3] {
    let ([a0, a1, a2], [b0, b1, b2]) = (a, b);
    [f(a0, b0), f(a1, b1), f(a2, b2)]
}

/// `p . (q x r)`, exactly.
fn triple(p: &[Point; 3], q: &[Difference; 3], r: &[Point; 3]) -> Volume {
    let minor = |q0: &Difference, r1: &Point, q1: &Difference, r0: &Point| -> Expansion<48> {
        let (left, right): (Expansion<24>, Expansion<24>) = (q0.times(r1), q1.times(r0));
        left.plus(&right.negated())
    };
    let ([px, py, pz], [qx, qy, qz], [rx, ry, rz]) = (p, q, r);
    let x: Expansion<96> = minor(qy, rz, qz, ry).times(px);
    let y: Expansion<96> = minor(qz, rx, qx, rz).times(py);
    let z: Expansion<96> = minor(qx, ry, qy, rx).times(pz);
    x.plus::<96, 192>(&y).plus(&z)
}
