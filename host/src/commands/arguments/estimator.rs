//! Options of estimates of irradiance.

use std::path::PathBuf;

use anyhow::{bail, ensure};
use clap::{Args, ValueEnum};

use super::values::{number, whole};
use crate::density::{
    Bounces, Domain, Estimator, Facing, Gather, Kernel, MapEstimator, PhotonSource, TangentPlane,
    automatic_radius, wanted_photons,
};

/// Method and options of estimates.
#[derive(Args, Clone, Debug)]
pub struct EstimatorArguments {
    /// Method
    #[arg(long, value_enum, default_value_t = Method::Detp)]
    estimator: Method,
    /// Radius of the discs, in the scene's units. With `auto`, a disc holds 200 photons on average if a million are
    /// shot, and in proportion to the power 2/3 of the photons otherwise. A photon map then takes all photons within
    /// the radius instead of the nearest
    #[arg(long, value_name = "R|auto", value_parser = radius, conflicts_with = "k")]
    radius: Option<Radius>,
    /// Number of nearest photons in an estimate by a photon map, 3 or more [default: 200 if a million photons are shot,
    /// in proportion to the power 2/3 of the photons otherwise]
    #[arg(long, value_name = "K", value_parser = whole::<usize>(3..=100_000_000))]
    k: Option<usize>,
    /// Largest radius of the nearest photons. If fewer than K lie within it, the estimate is of that radius [default:
    /// four times the automatic radius]
    #[arg(long, value_name = "R", value_parser = positive)]
    max_radius: Option<f32>,
    /// Also count photons that end before the plane, by at most B radii (detp). 0 is the paper's rule; the inside of a
    /// sphere of radius S needs R / (2 S)
    #[arg(long, value_name = "B", default_value_t = 0.0, value_parser = number(0.0..=1e3))]
    beyond: f32,
    /// Part of the disc in which photons count [default: visible for detp, disc for photon maps]
    #[arg(long, value_enum)]
    domain: Option<DomainName>,
    /// Weight of a photon by its distance
    #[arg(long, value_enum)]
    kernel: Option<KernelName>,
    /// Largest angle in degrees, 0 to 90, between the surface of a photon and that of the point (photon map)
    /// [default: 10]
    #[arg(long, value_name = "DEG", value_parser = number(0.0..=90.0))]
    normal_angle: Option<f32>,
    /// Part of the light that counts
    #[arg(long, value_enum, default_value_t = BouncesName::All)]
    bounces: BouncesName,
    /// Read the photons from a file that `--save-map` wrote, instead of shooting them. --photons must be their number
    #[arg(long, value_name = "FILE", conflicts_with_all = ["part", "checkpoint"])]
    pub load_map: Option<PathBuf>,
    /// Write the photon map, to use it again for the same scene
    #[arg(long, value_name = "FILE", conflicts_with = "part")]
    pub save_map: Option<PathBuf>,
}

/// Method of estimating irradiance.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Method {
    /// Density estimation on the tangent plane: photons that cross a disc around the point, in mid-air too
    Detp,
    /// Photon map: photons that fell on surfaces near the point
    PhotonMap,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum DomainName {
    /// The whole disc, the paper's rule: dark at the foot of walls, and light leaks through thin walls
    Disc,
    /// The part that the point sees, found by 32 rays; with a fixed radius
    Visible,
}

/// Name of a kernel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum KernelName {
    /// Every photon counts the same
    Constant,
    /// Photons count less towards the border of the disc: smoother
    Epanechnikov,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum BouncesName {
    /// All light
    All,
    /// Light straight from the lamps
    Direct,
    /// Light that was reflected
    Indirect,
}

#[derive(Clone, Copy, Debug)]
enum Radius {
    Automatic,
    Given(f32),
}

fn radius(text: &str) -> Result<Radius, String> {
    if text == "auto" {
        return Ok(Radius::Automatic);
    }
    positive(text).map(Radius::Given)
}

fn positive(text: &str) -> Result<f32, String> {
    let number: f32 = text.parse().map_err(|_| "not a number".to_owned())?;
    let valid = number > 0.0 && number.is_finite();
    valid.then_some(number).ok_or_else(|| "must be finite and above 0".to_owned())
}

impl EstimatorArguments {
    /// Returns the segments that count.
    pub fn bounces(&self) -> Bounces {
        match self.bounces {
            BouncesName::All => Bounces::All,
            BouncesName::Direct => Bounces::Direct,
            BouncesName::Indirect => Bounces::Indirect,
        }
    }

    fn normal_angle(&self) -> f32 {
        self.normal_angle.unwrap_or(10.0)
    }

    /// Lists what estimates depend on beside their photons, each with a name: an estimator that these arguments gave,
    /// and the light that counts.
    pub fn described(&self, estimator: &Estimator) -> Vec<(String, String)> {
        let mut all: Vec<(&str, String)> = Vec::new();
        let (kernel, domain) = match estimator {
            Estimator::TangentPlane(plane) => {
                all.push(("the estimator", "detp".to_owned()));
                all.push(("radius", plane.radius.to_string()));
                all.push(("--beyond", plane.beyond.to_string()));
                (plane.kernel, plane.domain)
            }
            Estimator::PhotonMap(MapEstimator { gather, kernel, .. }, domain) => {
                all.push(("the estimator", "photon-map".to_owned()));
                match gather {
                    Gather::Within { radius } => all.push(("radius", radius.to_string())),
                    Gather::Nearest { k, max_radius } => {
                        all.push(("--k", k.to_string()));
                        all.push(("largest radius", max_radius.to_string()));
                    }
                }
                all.push(("--normal-angle", self.normal_angle().to_string()));
                (*kernel, *domain)
            }
        };
        all.push(("the kernel", format!("{kernel:?}").to_lowercase()));
        all.push(("the domain", format!("{domain:?}").to_lowercase()));
        all.push(("--bounces", format!("{:?}", self.bounces()).to_lowercase()));
        all.into_iter().map(|(name, value)| (name.to_owned(), value)).collect()
    }

    /// Makes the estimator for the photons of a source. Values that were not given are computed from a few of its
    /// photons. `kernel` is the default kernel.
    ///
    /// # Errors
    /// If options contradict each other.
    pub fn resolve(
        &self,
        source: &PhotonSource<'_>,
        kernel: KernelName,
    ) -> anyhow::Result<Estimator> {
        let method = self.estimator;
        let kernel = match self.kernel.unwrap_or(kernel) {
            KernelName::Constant => Kernel::Constant,
            KernelName::Epanechnikov => Kernel::Epanechnikov,
        };
        let domain = match (self.domain, method) {
            (Some(DomainName::Disc), _) | (None, Method::PhotonMap) => Domain::Disc,
            (Some(DomainName::Visible), _) | (None, Method::Detp) => Domain::Visible,
        };
        let wanted = wanted_photons(source.photons.end - source.photons.start);
        let automatic = || automatic_radius(source, wanted as f64);
        let fixed = || match self.radius {
            Some(Radius::Given(radius)) => radius,
            Some(Radius::Automatic) | None => automatic(),
        };
        let estimator = match method {
            Method::Detp => {
                ensure!(self.k.is_none(), "--k is for photon maps; give --radius to detp");
                ensure!(
                    self.max_radius.is_none(),
                    "--max-radius is for the k nearest of a photon map"
                );
                ensure!(self.normal_angle.is_none(), "--normal-angle is for photon maps");
                self.refuse_map_files()?;
                let beyond = self.beyond;
                Estimator::TangentPlane(TangentPlane { radius: fixed(), beyond, kernel, domain })
            }
            Method::PhotonMap => {
                ensure!(self.beyond == 0.0, "--beyond is for --estimator detp");
                let fixed_radius = self.radius.is_some() || domain == Domain::Visible;
                if fixed_radius && self.k.is_some() {
                    bail!("--domain visible needs a fixed radius: give --radius instead of --k");
                }
                let gather = if fixed_radius {
                    ensure!(
                        self.max_radius.is_none(),
                        "--max-radius is for the k nearest, without --radius"
                    );
                    Gather::Within { radius: fixed() }
                } else {
                    let k = self.k.unwrap_or(wanted);
                    let usual = || (4.0 * automatic_radius(source, k as f64)).min(f32::MAX);
                    Gather::Nearest { k, max_radius: self.max_radius.unwrap_or_else(usual) }
                };
                let facing = Facing::within_degrees(self.normal_angle());
                Estimator::PhotonMap(MapEstimator { gather, facing, kernel }, domain)
            }
        };
        estimator.check()?;
        warn_of_crowds(source, &estimator);
        Ok(estimator)
    }

    fn refuse_map_files(&self) -> anyhow::Result<()> {
        let none = self.load_map.is_none() && self.save_map.is_none();
        ensure!(none, "detp stores no photons: --load-map and --save-map are for photon maps");
        Ok(())
    }
}

/// Warns of a radius that holds very many photons, because the cost of an estimate is in proportion to them.
fn warn_of_crowds(source: &PhotonSource<'_>, estimator: &Estimator) {
    /// Photons in an estimate, on average, from which on it takes a millisecond or more.
    const CROWD: f64 = 50_000.0;
    let nearest = matches!(
        estimator,
        Estimator::PhotonMap(MapEstimator { gather: Gather::Nearest { .. }, .. }, _)
    );
    let times = f64::from(estimator.radius()) / f64::from(automatic_radius(source, 1.0));
    let count = (times * times).min((source.photons.end - source.photons.start) as f64);
    if !nearest && count > CROWD {
        log::warn!(
            "the radius {} holds some {count:.0} photons, which takes long; --radius auto holds far fewer",
            estimator.radius()
        );
    }
}
