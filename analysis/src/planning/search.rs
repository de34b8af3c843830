//! Exchange of touches: from a start, the touch whose replacement helps most is replaced, until none helps; then each
//! touch is moved over its surface by ever smaller steps.
//!
//! V. V. Fedorov, Theory of optimal experiments (1972), section 3.2; T. J. Mitchell, An algorithm for the construction
//! of "D-optimal" experimental designs, Technometrics 16 (1974). What an exchange does to the covariance is told by two
//! updates of rank one (Sherman and Morrison), and to its determinant by the matrix determinant lemma.

use nalgebra::{DMatrix, DVector, DVectorView, Matrix3, Matrix3xX, Point3, Vector3};
use rand::{Rng, RngExt};
use touchref_core::{
    Frame, Noise, Probe, Problem, RANK_TOLERANCE, Touch, TouchError, fixture::touches_per_surface,
};

use super::{
    Criterion,
    reach::{Reach, Site},
};
use crate::{
    linear::{Columns, lever},
    simulation::generator,
};

/// Touches of a surface stay apart by this part of how far it reaches: what one of them meets, dirt or a dent, the other
/// does not.
const APART: f64 = 0.05;
/// An exchange that gains less than this part is rounding.
const GAIN: f64 = 1e-12;
/// A touch whose redundancy number is not above this cannot be spared.
const SPARED: f64 = 1e-9;
/// Draws for one start before the counts are taken to be at fault.
const DRAWS: u64 = 50;
/// The first and last step of moving touches, in parts of the extent: from the coarsest grid's to rounding.
const STEPS: [f64; 2] = [1.0 / 32.0, 1e-9];
/// Draws of moving all touches together before a smaller step.
const TOGETHER: usize = 12;
/// Rounds of moving every touch by one step; more are wanted only where the worst case sits on an edge.
const ROUNDS: usize = 20;

/// What touches of a fixture tell, and what is asked of them.
pub(crate) struct Scene<'a> {
    pub(crate) problem: Problem<'a>,
    probe: Probe,
    pub(crate) reach: &'a Reach,
    criterion: Criterion,
    columns: Columns,
    /// How each point of use moves with the unknowns.
    levers: Vec<Matrix3xX<f64>>,
    /// Information that is there already: of stated sizes, and of touches that are made.
    base: DMatrix<f64>,
    /// Contacts that are made.
    made: Vec<(usize, Point3<f64>)>,
    checks: Option<Checks>,
    pub(crate) candidates: Vec<Site>,
    /// What each candidate tells, a column each.
    rows: DMatrix<f64>,
    /// How far apart touches of each surface stay.
    apart: Vec<f64>,
}

/// What redundancy numbers are asked for, and how strongly.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Checks {
    /// The least of each touch.
    pub(crate) least: f64,
    /// By how much the score grows with the square of what a redundancy number lacks.
    pub(crate) weight: f64,
}

/// Touches that may be exchanged, and what they tell together with what is there already.
#[derive(Debug, Clone)]
pub(crate) struct Design {
    pub(crate) sites: Vec<Site>,
    /// Logarithm of the worst case or of the volume, and what is added for redundancy numbers that lack; less is better.
    pub(crate) score: f64,
    rows: DMatrix<f64>,
    covariance: DMatrix<f64>,
    log_det: f64,
}

impl Design {
    /// Logarithm of the determinant of the information.
    pub(crate) fn information(&self) -> f64 {
        self.log_det
    }
}

/// What is to be known of a design to weigh its exchanges.
struct Exchanges {
    /// Rows times covariance times rows.
    told: DMatrix<f64>,
    /// Covariance at each point of use.
    at_points: Vec<Matrix3<f64>>,
    /// How each point moves with covariance times rows.
    points_moved: Vec<Matrix3xX<f64>>,
}

/// Which surfaces may be touched how often.
pub(crate) enum Counts<'a> {
    /// As often as the start has it.
    Kept,
    /// As this allows.
    Where(&'a (dyn Fn(&[usize]) -> bool + Sync)),
}

impl<'a> Scene<'a> {
    /// `frame` is the fixture's own: the touches of `problem` are in fixture coordinates, and count where `made`.
    pub(crate) fn new(
        problem: Problem<'a>,
        reach: &'a Reach,
        points: &[Point3<f64>],
        criterion: Criterion,
        made: bool,
    ) -> Self {
        // What touches state themselves speaks for those to come.
        let probe = Probe { sigma: problem.reference_sigma(), ..*problem.probe() };
        let columns = Columns::of(&problem);
        let sizes = columns.uncertain.len();
        let levers = points.iter().map(|point| {
            let all = lever(&Frame::identity(), point);
            let mut own = Matrix3xX::zeros(columns.len());
            for (column, motion) in columns.motions.iter().enumerate() {
                own.set_column(sizes + column, &all.column(*motion));
            }
            own
        });
        let mut base = DMatrix::zeros(columns.len(), columns.len());
        for (column, (_, u)) in columns.uncertain.iter().enumerate() {
            base[(column, column)] = 1.0 / (u * u);
        }
        let candidates: Vec<Site> =
            (0..reach.surfaces().len()).flat_map(|surface| reach.grid(surface)).collect();
        let span = |surface: usize| {
            let own = candidates.iter().filter(|site| site.surface == surface).map(|site| site.at);
            let box_of = own.fold(None, |span: Option<(Point3<f64>, Point3<f64>)>, at| {
                Some(span.map_or((at, at), |(low, high)| (low.inf(&at), high.sup(&at))))
            });
            box_of.map_or(0.0, |(low, high)| APART * (high - low).norm())
        };
        let apart = (0..reach.surfaces().len()).map(span).collect();
        let mut scene = Self {
            levers: levers.collect(),
            rows: DMatrix::zeros(columns.len(), 0),
            made: Vec::new(),
            checks: None,
            problem,
            probe,
            reach,
            criterion,
            columns,
            base,
            candidates,
            apart,
        };
        if made {
            for index in 0..problem.touches().len() {
                let row = scene.row_of(&problem, index);
                scene.base += &row * row.transpose();
                let contact = problem.contact(&Frame::identity(), index);
                let foot = contact.at - contact.normal * (contact.residual + problem.probe().tip_radius);
                scene.made.push((problem.touches()[index].surface, foot));
            }
        }
        let rows: Vec<DVector<f64>> = scene.candidates.iter().map(|site| scene.row(site)).collect();
        scene.rows = columns_of(&rows, scene.columns.len());
        scene
    }

    /// The same with some knowledge of the frame before any touch, so that a layout that leaves motions free can be weighed:
    /// `translation` and `rotation` are standard deviations.
    pub(crate) fn with_prior(mut self, translation: f64, rotation: f64) -> Self {
        let sizes = self.columns.uncertain.len();
        for (column, motion) in self.columns.motions.iter().enumerate() {
            let u = if *motion < 3 { translation } else { rotation };
            self.base[(sizes + column, sizes + column)] += 1.0 / (u * u);
        }
        self
    }

    /// The same, asking for redundancy numbers.
    pub(crate) fn with_checks(self, checks: Checks) -> Self {
        Self { checks: Some(checks), ..self }
    }

    /// The touch at a contact point, in fixture coordinates.
    pub(crate) fn touch(&self, surface: usize, at: &Point3<f64>) -> Touch {
        let surfaces = self.problem.fixture().surfaces();
        Touch::new(surface, surfaces[surface].tip_center(at, self.probe.tip_radius))
    }

    fn row_of(&self, problem: &Problem<'_>, index: usize) -> DVector<f64> {
        let contact = problem.contact(&Frame::identity(), index);
        let surface = problem.touches()[index].surface;
        let row = self.columns.row(self.problem.fixture(), surface, &contact);
        DVector::from_iterator(self.columns.len(), row)
    }

    fn row(&self, site: &Site) -> DVector<f64> {
        let touches = [Touch { noise: Noise::OfProbe, ..self.touch(site.surface, &site.at) }];
        // A place on a surface is as sound as the surface; one that is not tells nothing.
        let problem: Result<_, TouchError> = Problem::new(self.problem.fixture(), &touches, self.probe);
        problem.map_or_else(|_| DVector::zeros(self.columns.len()), |problem| self.row_of(&problem, 0))
    }

    /// Whether a place keeps away from those made and from the design's, `except` one.
    fn clear(&self, site: &Site, sites: &[Site], except: Option<usize>) -> bool {
        let far = |at: &Point3<f64>| (at - site.at).norm() >= self.apart[site.surface];
        let made = self.made.iter().filter(|(surface, _)| *surface == site.surface);
        let others = sites.iter().enumerate().filter(|(k, _)| Some(*k) != except);
        let mut others = others.filter(|(_, other)| other.surface == site.surface);
        made.map(|(_, at)| at).all(far) && others.all(|(_, other)| far(&other.at))
    }

    /// Which candidates a further touch may take.
    fn free(&self, sites: &[Site], except: Option<usize>) -> Vec<bool> {
        self.candidates.iter().map(|site| self.clear(site, sites, except)).collect()
    }

    /// The design of these places; `None` where it leaves a motion free.
    pub(crate) fn design(&self, sites: Vec<Site>) -> Option<Design> {
        let rows: Vec<DVector<f64>> = sites.iter().map(|site| self.row(site)).collect();
        let rows = columns_of(&rows, self.columns.len());
        let (covariance, log_det) = inverse(&(&self.base + &rows * rows.transpose()))?;
        let mut design = Design { sites, score: f64::INFINITY, rows, covariance, log_det };
        let exchanges = self.exchanges(&design);
        design.score = self.score(&design, &exchanges, None, None, f64::INFINITY)?;
        Some(design)
    }

    fn exchanges(&self, design: &Design) -> Exchanges {
        let moved = &design.covariance * &design.rows;
        Exchanges {
            told: design.rows.tr_mul(&moved),
            at_points: self
                .levers
                .iter()
                .map(|lever| lever * &design.covariance * lever.transpose())
                .collect(),
            points_moved: self.levers.iter().map(|lever| lever * &moved).collect(),
        }
    }

    /// The score of a design with what is added (its row, and covariance times row) and without what is dropped; `None`
    /// where that leaves a motion free, or is surely not below `than`.
    fn score(
        &self,
        design: &Design,
        exchanges: &Exchanges,
        added: Option<(DVectorView<'_, f64>, DVectorView<'_, f64>)>,
        dropped: Option<usize>,
        than: f64,
    ) -> Option<f64> {
        let touches = design.sites.len();
        let told = |k: usize| added.map_or(0.0, |(_, moved)| design.rows.column(k).dot(&moved));
        let own = added.map_or(0.0, |(row, moved)| row.dot(&moved));
        let grown = 1.0 + own;
        let spared = dropped.map(|i| {
            let with = told(i);
            (i, with, 1.0 - exchanges.told[(i, i)] + with * with / grown)
        });
        let left = spared.map_or(1.0, |(.., left)| left);
        if left < SPARED {
            return None;
        }
        let mut penalty = 0.0;
        if let Some(Checks { least, weight }) = self.checks {
            let lacking = |told: f64| weight * (least - 1.0 + told).max(0.0).powi(2);
            for k in (0..touches).filter(|k| Some(*k) != dropped) {
                let with = told(k);
                let across = spared
                    .map_or(0.0, |(i, with_dropped, _)| exchanges.told[(k, i)] - with * with_dropped / grown);
                penalty += lacking(exchanges.told[(k, k)] - with * with / grown + across * across / left);
            }
            if added.is_some() {
                let across = spared.map_or(0.0, |(_, with_dropped, _)| with_dropped / grown);
                penalty += lacking(own / grown + across * across / left);
            }
        }
        let score = match self.criterion {
            Criterion::Volume => -0.5 * (design.log_det + grown.ln() + left.ln()),
            Criterion::Worst => {
                // No eigenvalue is smaller than a diagonal element.
                let bound = (2.0 * (than - penalty)).exp();
                let mut largest = 0.0_f64;
                for (point, lever) in self.levers.iter().enumerate() {
                    let mut at_point = exchanges.at_points[point];
                    let with: Vector3<f64> = added.map_or_else(Vector3::zeros, |(_, moved)| lever * moved);
                    at_point -= with * with.transpose() / grown;
                    if let Some((i, with_dropped, left)) = spared {
                        let without = exchanges.points_moved[point].column(i) - with * (with_dropped / grown);
                        at_point += without * without.transpose() / left;
                    }
                    if at_point.diagonal().max() > bound {
                        return None;
                    }
                    largest = largest.max(largest_eigenvalue(&at_point));
                }
                0.5 * largest.ln()
            }
        };
        Some(score + penalty)
    }

    /// Exchanges touches for candidates until none helps.
    pub(crate) fn exchange(&self, mut design: Design, counts: &Counts<'_>) -> Design {
        loop {
            let exchanges = self.exchanges(&design);
            let moved = &design.covariance * &self.rows;
            let mut best = (design.score, None);
            for dropped in 0..design.sites.len() {
                let free = self.free(&design.sites, Some(dropped));
                let allowed = self.allowed(&design.sites, dropped, counts);
                for (index, site) in self.candidates.iter().enumerate() {
                    if !free[index] || !allowed[site.surface] {
                        continue;
                    }
                    let added = Some((self.rows.column(index), moved.column(index)));
                    if let Some(score) = self.score(&design, &exchanges, added, Some(dropped), best.0)
                        && beats(score, best.0)
                    {
                        best = (score, Some((dropped, *site)));
                    }
                }
            }
            let Some((dropped, site)) = best.1 else { return design };
            let Some(better) = self.replaced(&design, dropped, site) else { return design };
            design = better;
        }
    }

    /// With one touch elsewhere, if that is better.
    fn replaced(&self, design: &Design, index: usize, site: Site) -> Option<Design> {
        let mut sites = design.sites.clone();
        sites[index] = site;
        // Anew, so that rounding of updates does not gather.
        self.design(sites).filter(|other| beats(other.score, design.score))
    }

    /// To which surfaces a touch may go.
    fn allowed(&self, sites: &[Site], dropped: usize, counts: &Counts<'_>) -> Vec<bool> {
        let from = sites[dropped].surface;
        let surfaces = 0..self.apart.len();
        match counts {
            Counts::Kept => surfaces.map(|to| to == from).collect(),
            Counts::Where(enough) => {
                let mut counts = self.counts(sites);
                counts[from] -= 1;
                surfaces
                    .map(|to| {
                        counts[to] += 1;
                        let enough = enough(&counts);
                        counts[to] -= 1;
                        enough
                    })
                    .collect()
            }
        }
    }

    /// Touches on each surface, those made among them.
    pub(crate) fn counts(&self, sites: &[Site]) -> Vec<usize> {
        let made = self.made.iter().map(|(surface, _)| *surface);
        touches_per_surface(self.apart.len(), sites.iter().map(|site| site.surface).chain(made))
    }

    /// Moves each touch over its surface by ever smaller steps as long as that helps.
    pub(crate) fn polish(&self, mut design: Design) -> Design {
        let mut rng = generator(0, 0);
        let mut step = STEPS[0];
        while step > STEPS[1] {
            let mut moved = false;
            for _ in 0..ROUNDS {
                let mut helped = false;
                for index in 0..design.sites.len() {
                    if let Some(better) = self.moved(&design, index, step) {
                        design = better;
                        helped = true;
                    }
                }
                if !helped {
                    // Where the worst case or a redundancy number has an edge, no touch alone leads along it.
                    let Some(better) = self.moved_together(&design, step, &mut rng) else { break };
                    design = better;
                }
                moved = true;
            }
            // A step that still helps is worth taking again before a smaller one.
            step *= if moved { 0.7 } else { 0.4 };
        }
        design
    }

    /// With all touches moved by up to a step, the first of some draws that is better.
    fn moved_together(&self, design: &Design, step: f64, rng: &mut impl Rng) -> Option<Design> {
        (0..TOGETHER).find_map(|_| {
            let moved = |site: &Site| {
                let uv = site.uv.map(|coordinate| coordinate + step * rng.random_range(-1.0..=1.0));
                self.reach.site(site.surface, uv)
            };
            let sites: Vec<Site> = design.sites.iter().map(moved).collect::<Option<_>>()?;
            let clear = (0..sites.len()).all(|index| self.clear(&sites[index], &sites, Some(index)));
            let other = if clear { self.design(sites) } else { None };
            other.filter(|other| beats(other.score, design.score))
        })
    }

    /// With one touch a step away, the best of eight directions, if that is better.
    fn moved(&self, design: &Design, index: usize, step: f64) -> Option<Design> {
        let site = design.sites[index];
        let exchanges = self.exchanges(design);
        let mut best = (design.score, None);
        for [du, dv] in [[1, 0], [-1, 0], [0, 1], [0, -1], [1, 1], [-1, -1], [1, -1], [-1, 1]] {
            let uv = [site.uv[0] + f64::from(du) * step, site.uv[1] + f64::from(dv) * step];
            let Some(to) = self.reach.site(site.surface, uv) else { continue };
            if !self.clear(&to, &design.sites, Some(index)) {
                continue;
            }
            let row = self.row(&to);
            let moved = &design.covariance * &row;
            let added = Some((row.column(0), moved.column(0)));
            if let Some(score) = self.score(design, &exchanges, added, Some(index), best.0)
                && beats(score, best.0)
            {
                best = (score, Some(to));
            }
        }
        best.1.and_then(|to| self.replaced(design, index, to))
    }

    /// The candidate that helps a design most, and the design with it.
    pub(crate) fn extended(&self, design: &Design, allowed: &dyn Fn(usize) -> bool) -> Option<Design> {
        let exchanges = self.exchanges(design);
        let moved = &design.covariance * &self.rows;
        let free = self.free(&design.sites, None);
        let mut best = (f64::INFINITY, None);
        for (index, site) in self.candidates.iter().enumerate() {
            if !free[index] || !allowed(site.surface) {
                continue;
            }
            let added = Some((self.rows.column(index), moved.column(index)));
            if let Some(score) = self.score(design, &exchanges, added, None, best.0)
                && beats(score, best.0)
            {
                best = (score, Some(*site));
            }
        }
        let mut sites = design.sites.clone();
        sites.push(best.1?);
        self.design(sites)
    }

    /// The least redundancy number of a design's touches.
    pub(crate) fn least_redundancy(&self, design: &Design) -> f64 {
        let told = self.exchanges(design).told.diagonal();
        told.iter().map(|told| 1.0 - told).fold(f64::INFINITY, f64::min)
    }

    /// The design nearest a layout: of the candidates that are nearest its points.
    pub(crate) fn near(&self, layout: &[(usize, Point3<f64>)]) -> Option<Design> {
        let nearest = |(surface, at): &(usize, Point3<f64>)| {
            let own = self.candidates.iter().filter(|site| site.surface == *surface);
            own.min_by(|a, b| (a.at - at).norm().total_cmp(&(b.at - at).norm())).copied()
        };
        self.design(layout.iter().map(nearest).collect::<Option<Vec<Site>>>()?)
    }

    /// Worst-case standard uncertainty of a design at the points of use.
    pub(crate) fn worst(&self, design: &Design) -> f64 {
        let at_points = self.exchanges(design).at_points;
        at_points.iter().map(largest_eigenvalue).fold(0.0, f64::max).sqrt()
    }

    /// Standard deviation of the distance that a touch at a contact point would show: of the touch, and of what a design
    /// foretells of it. A length.
    pub(crate) fn unsure(&self, design: &Design, surface: usize, at: &Point3<f64>) -> f64 {
        let row = self.row(&Site { surface, uv: [0.0; 2], at: *at });
        let sigma = self.probe.sigma.unwrap_or(1.0);
        sigma * (1.0 + row.dot(&(&design.covariance * &row))).sqrt()
    }

    /// A start: candidates drawn for these counts; `None` where none is found that leaves no motion free, or no room.
    pub(crate) fn start(&self, counts: &[usize], number: u64) -> Option<Design> {
        let mut rng = generator(number, 0);
        for _ in 0..DRAWS {
            let mut sites: Vec<Site> = Vec::new();
            for (surface, &count) in counts.iter().enumerate() {
                for _ in 0..count {
                    let free = self.free(&sites, None);
                    let own = self
                        .candidates
                        .iter()
                        .zip(&free)
                        .filter(|(site, free)| site.surface == surface && **free);
                    let own: Vec<Site> = own.map(|(site, _)| *site).collect();
                    if own.is_empty() {
                        break;
                    }
                    sites.push(own[rng.random_range(0..own.len())]);
                }
            }
            if sites.len() == counts.iter().sum::<usize>()
                && let Some(design) = self.design(sites)
            {
                return Some(design);
            }
        }
        None
    }
}

/// Whether a score is better than another by more than rounding.
fn beats(score: f64, than: f64) -> bool {
    score < than - GAIN
}

/// Columns beside each other.
fn columns_of(columns: &[DVector<f64>], rows: usize) -> DMatrix<f64> {
    DMatrix::from_fn(rows, columns.len(), |row, column| columns[column][row])
}

/// Inverse of an information matrix, and the logarithm of its determinant; `None` where something is not seen.
fn inverse(information: &DMatrix<f64>) -> Option<(DMatrix<f64>, f64)> {
    // Lengths and angles are of different sizes.
    let scales = information.diagonal().map(f64::sqrt);
    if !scales.iter().all(|scale| scale.is_normal()) {
        return None;
    }
    let scaled =
        DMatrix::from_fn(scales.len(), scales.len(), |i, j| information[(i, j)] / (scales[i] * scales[j]));
    let cholesky = scaled.cholesky()?;
    let diagonal = cholesky.l_dirty().diagonal();
    if diagonal.min() < RANK_TOLERANCE * diagonal.max() {
        return None;
    }
    let log_det = 2.0 * (diagonal.map(f64::ln).sum() + scales.map(f64::ln).sum());
    let mut inverse = cholesky.inverse();
    for i in 0..scales.len() {
        for j in 0..scales.len() {
            inverse[(i, j)] /= scales[i] * scales[j];
        }
    }
    Some((inverse, log_det))
}

/// Of a symmetric matrix: the trigonometric solution of its characteristic equation.
fn largest_eigenvalue(matrix: &Matrix3<f64>) -> f64 {
    let mean = matrix.trace() / 3.0;
    let deviator = matrix - Matrix3::from_diagonal_element(mean);
    let size = (deviator.norm_squared() / 6.0).sqrt();
    if size == 0.0 {
        return mean;
    }
    let cosine = (0.5 * (deviator / size).determinant()).clamp(-1.0, 1.0);
    mean + 2.0 * size * (cosine.acos() / 3.0).cos()
}
