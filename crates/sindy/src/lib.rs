//! Sparse identification of nonlinear dynamics: equations from measurements.
//!
//! Given samples of a system, find a differential equation `dx/dt = Θ(x, u) ξ` with few terms. This page is a guided
//! tour; the details stand in the [modules](#modules). Coming from PySINDy? See [`from_pysindy`] for what is
//! called how.
//!
//! # Lorenz in fifteen lines
//!
//! ```
//! use sindy::{Dataset, Identify, Library, problems};
//!
//! let mut data = Dataset::new(&["x", "y", "z"], &[])?;
//! for run in problems::lorenz().noisy(1.0, 42)? { // 5000 samples, 1 % noise, seed 42
//!     data.push("a run", run.time, run.states, None)?;
//! }
//! let library = Library::polynomial(&["x", "y", "z"], 3)?; // 20 candidate terms
//! let found = Identify::new(library).run(&data, &mut |_| ())?;
//!
//! println!("{:.3}\n{}", found.model, found.choice.reason);
//! assert_eq!(found.model.terms(), 7);
//! assert_eq!(format!("{:.3}", found.model).lines().next(), Some("x' = -10.0*x + 10.0*y"));
//! # Ok::<(), sindy::SindyError>(())
//! ```
//!
//! Nothing was set: noise, smoothing, threshold and terms come from the data ([`identify`] says how). A [`Dataset`] takes
//! trajectories of any length and any increasing times; rows with NaN and holes in time split it, and
//! [`Dataset::report`] counts them.
//!
//! # Controls
//!
//! Inputs are columns after the states, and names that terms may use:
//!
//! ```
//! use sindy::{Dataset, Identify, Library, problems};
//!
//! let mut data = Dataset::new(&["x", "v"], &["u"])?;
//! for run in problems::duffing().noisy(2.0, 1)? { // v' = x - 0.3 v - x^3 + u
//!     data.push("forced", run.time, [run.states, run.inputs].concat(), None)?;
//! }
//! // Written as one text: cubic in the states, the force, and the force times each state.
//! let library = Library::specification("poly(3, x, v) + u + u*x + u*v", &["x", "v", "u"])?;
//! let found = Identify::new(library).run(&data, &mut |_| ())?;
//! assert_eq!(format!("{:.1}", found.model), "x' = 1*v\nv' = 1*x - 0.3*v - 1*x^3 + 1*u\n");
//! # Ok::<(), sindy::SindyError>(())
//! ```
//!
//! Equations may have libraries of their own: [`Identify::per_equation`].
//!
//! # Noise
//!
//! How slopes are made matters as much as the solver. [`noise_level`](derivative::noise_level) estimates the noise,
//! [`choose_savgol`](derivative::choose_savgol) the window and degree with the least error of the *slope*:
//!
//! ```
//! use sindy::derivative::{SavgolSearch, choose_savgol};
//! use sindy::problems;
//!
//! let run = &problems::lorenz().noisy(5.0, 1)?[0];
//! let (time, x) = (&run.time[..], &run.states[0][..]);
//! let choice = choose_savgol(&[(time, x)], &SavgolSearch::default())?;
//! println!("{choice}");
//!
//! // It knows how wrong its slopes are without knowing the truth.
//! let slope = choice.filter.apply(time, x)?.derivative;
//! let inside = choice.edge..x.len() - choice.edge;
//! let n = inside.len() as f64;
//! let error = (inside.map(|i| (slope[i] - run.derivatives[0][i]).powi(2)).sum::<f64>() / n).sqrt();
//! assert!((choice.slope_error / error - 1.0).abs() < 0.3);
//! # Ok::<(), sindy::SindyError>(())
//! ```
//!
//! [`derivative`] also has finite differences, smoothing splines (any times), a Kalman smoother and spectral
//! derivatives.
//!
//! # Choosing
//!
//! One call takes slopes of two smoothing strengths and the weak form, and for each of them the whole grid of λ and ν
//! (SR3, folds by blocks) and the best subset of every size; it ranks what comes out by short free runs, and says why
//! it took what it took:
//!
//! ```
//! use sindy::identify::{Method, Settings};
//! use sindy::{Dataset, Identify, problems};
//!
//! let problem = problems::lotka_volterra();
//! let mut data = Dataset::new(&problem.states, &problem.inputs)?;
//! for run in problem.noisy(5.0, 3)? {
//!     data.push("a run", run.time, run.states, None)?;
//! }
//! let settings = Settings { method: Method::Regression, folds: 8, ..Settings::default() };
//! let found = Identify::new(problem.library()?).settings(settings)?.run(&data, &mut |_| ())?;
//! println!("{}", found.choice.reason);
//! for candidate in &found.candidates {
//!     println!("{:<40} {:>3} terms, {:.2} of the noise", candidate.name, candidate.terms, candidate.free_run);
//! }
//! for point in &found.equations[0].front { // x': the best terms of every number
//!     println!("{} {:.4} {:?}", if point.chosen { "->" } else { "  " }, point.error, point.terms);
//! }
//! assert!(found.candidates.len() > 2 && found.equations[0].front.iter().any(|p| p.chosen));
//! # Ok::<(), sindy::SindyError>(())
//! ```
//!
//! The parts by themselves: [`choose::cross_validate`] (λ and ν at the cost of p × p solves), [`criteria`],
//! [`stepwise`], [`ensemble`].
//!
//! # Weak form
//!
//! Integrated against test functions, the equation needs no derivative of the data. Any solver takes the result:
//!
//! ```
//! use sindy::sr3::Scaling;
//! use sindy::{Samples, Solver, Stlsq, WeakForm, problems};
//!
//! let problem = problems::lorenz();
//! let run = problem.noisy(5.0, 1)?.remove(0);
//! let mut samples = Samples::new(&["t", "x", "y", "z"]);
//! samples.push_group([vec![run.time], run.states].concat())?;
//! let weak = WeakForm::default().system(&problem.library()?, "t", &["x", "y", "z"], &samples)?;
//!
//! let solver = Stlsq::new(0.2, 0.0)?.scaling(Scaling::None); // threshold in the coefficients' unit
//! let fit = solver.fit(&weak.total(0))?; // of x'
//! assert_eq!(fit.terms(), 2);
//! assert!((fit.coefficients[1] + 10.0).abs() < 0.2 && (fit.coefficients[2] - 10.0).abs() < 0.2);
//! # Ok::<(), sindy::SindyError>(())
//! ```
//!
//! # Certificates
//!
//! [`BestSubset`] finds the best terms of every number, and proves that there are none better, or states the gap that is
//! left when a limit ended the search:
//!
//! ```
//! use sindy::derivative::FiniteDifference;
//! use sindy::{BestSubset, Criterion, Gram, Outcome, Samples, derivative::Rates, problems};
//!
//! let problem = problems::lorenz();
//! let run = problem.clean()?.remove(0);
//! let mut samples = Samples::new(&["x", "y", "z"]);
//! samples.push_group(run.states)?;
//! let rates = Rates::uniform(&samples, &["z"], FiniteDifference::new(4)?, problem.step)?;
//! let gram = Gram::total(&Gram::accumulate(&problem.library()?, "z_dot", &rates)?);
//!
//! let best = BestSubset::new().max_size(6).solve(&gram)?; // 20 terms: 60 460 subsets of up to 6
//! assert_eq!(best.outcome, Outcome::Optimal);
//! println!("proven by {} nodes", best.nodes);
//! assert_eq!(best.sizes[2].fit.terms(), 2); // x*y and z
//! # assert!(best.nodes < 60_460);
//! # let names = problem.library()?; let s = &best.sizes[2].fit.support;
//! # assert!(names.names().iter().zip(s).all(|(n, k)| *k == (n == "z" || n == "x*y")));
//! # let _ = best.choose(&gram, Criterion::Bic, None)?;
//! # Ok::<(), sindy::SindyError>(())
//! ```
//!
//! # Past states and discrete time
//!
//! A model may give the next sample instead of the slope, and use what was: `x_ago1` is x one sample ago.
//!
//! ```
//! use sindy::shift::{Delay, next, past};
//! use sindy::{Gram, Library, Samples, Solver, Stlsq};
//!
//! let mut x = vec![0.3, 0.3]; // the delayed logistic map, x[k+1] = 2.1 x[k] (1 - x[k-1])
//! for k in 1..300 {
//!     x.push(2.1 * x[k] * (1.0 - x[k - 1]));
//! }
//! let mut samples = Samples::new(&["x"]);
//! samples.push_group(vec![x])?;
//! let with_past = past(&samples, &Delay::parse("x@1")?, None)?.samples;
//! let pairs = next(&with_past, &["x"], None, None)?.samples;
//!
//! let library = Library::polynomial(&["x", "x_ago1"], 2)?;
//! let gram = Gram::total(&Gram::accumulate(&library, "x_next", &pairs)?);
//! let fit = Stlsq::new(0.05, 0.0)?.fit(&gram)?;
//! let kept = library.names().iter().zip(&fit.support).filter(|(_, kept)| **kept);
//! assert!(kept.map(|(name, _)| name.as_str()).eq(["x", "x*x_ago1"]));
//! # Ok::<(), sindy::SindyError>(())
//! ```
//!
//! [`shift::chain`] turns the delays into states, so that such a [`Model`] runs by itself. In the automatic call
//! discrete time is a setting, [`identify::Settings::discrete`]. Models with delays in continuous time run by
//! [`Model::simulate_past`].
//!
//! # Larger than memory
//!
//! `Θ` is never stored. What a fit needs are sums ([`Gram`]) that blocks of rows are added to, one block held at a time:
//!
//! ```
//! use sindy::{Gram, Grid, Library, OwnedBlock, Stream, choose};
//!
//! let blocks = (0..100).map(|k| { // the row groups of a file, as they are read
//!     let x: Vec<f64> = (0..1000).map(|i| (0.01 * f64::from(1000 * k + i)).sin()).collect();
//!     let u: Vec<f64> = (0..1000).map(|i| (0.037 * f64::from(1000 * k + i)).cos()).collect();
//!     let y = x.iter().zip(&u).map(|(x, u)| 3.0 * x * u - 0.5 * x).collect();
//!     Ok(OwnedBlock { group: (k / 20) as usize, columns: vec![x, u, y] })
//! });
//! let source = Stream::new(&["x", "u", "y"], 5, blocks);
//! let folds = Gram::accumulate(&Library::polynomial(&["x", "u"], 3)?, "y", &source)?; // the one pass
//!
//! let chosen = choose::cross_validate(&folds, &Grid::default())?; // 39 points, 5 folds, no further pass
//! assert_eq!((Gram::total(&folds).rows, chosen.point.terms), (100_000, 2));
//! # Ok::<(), sindy::SindyError>(())
//! ```
//!
//! Sums merge ([`Gram::merge`]) and are taken away again ([`Gram::downdate`]). Where a library is too ill-conditioned for them, a
//! mergeable triangular factor ([`tsqr`]) stands beside.
//!
//! # Uncertainty
//!
//! Residuals are correlated from row to row, and intervals that take the rows one by one are too narrow. A bootstrap over
//! blocks gives honest ones, and bands of what the models predict:
//!
//! ```
//! use sindy::gram::Accumulate;
//! use sindy::model::{Inputs, Simulation, Time};
//! use sindy::uncertainty::{Band, Bootstrap, models, on_support};
//! use sindy::{Library, Samples, SavitzkyGolay, Solver, problems};
//!
//! let run = problems::damped_oscillator().noisy(5.0, 1)?.remove(0);
//! let filter = SavitzkyGolay::new(51, 4)?;
//! let mut columns = Vec::new();
//! for x in &run.states {
//!     let smooth = filter.apply(&run.time, x)?;
//!     columns.extend([smooth.value, smooth.derivative]);
//! }
//! let mut samples = Samples::new(&["x", "x_dot", "y", "y_dot"]);
//! samples.push_group(columns)?;
//! let library = Library::parse(&["x", "y"])?;
//! let solver = on_support(vec![true, true]); // or one that chooses the terms anew in every replicate
//! let equations = ["x_dot", "y_dot"].map(|slope| (Accumulate::new(&library, slope), &solver as &dyn Solver));
//! let found = Bootstrap::new(200, 1)?.run(&equations, &samples)?;
//! println!("y' = ({:.3} ± {:.3}) x + …", found[1].fit.coefficients[0], found[1].std_error[0]);
//!
//! let all = models(Time::Continuous, &["x", "y"], &[], &[(&library, &found[0]), (&library, &found[1])])?;
//! let start = [run.states[0][0], run.states[1][0]];
//! let band = Band::of_runs(&all, 0.95, |model| {
//!     model.simulate(&start, &run.time[..500], &Inputs::none(), &Simulation::adaptive())
//! })?;
//! assert!((0..500).all(|k| band.lower[0][k] <= band.upper[0][k]));
//! # Ok::<(), sindy::SindyError>(())
//! ```
//!
//! The automatic call has standard errors and inclusion probabilities for every term ([`model::Term`]).
//!
//! # Models
//!
//! A [`Model`] predicts, simulates, has an exact Jacobian and equilibria, prints itself, and reads its JSON back exactly:
//!
//! ```
//! use sindy::model::{Inputs, RunOutcome, Search, Simulation, Stability};
//! use sindy::{Model, problems};
//!
//! let model = problems::duffing().model()?; // a found one is no different
//! let time: Vec<f64> = (0..=3000).map(|k| 0.01 * f64::from(k)).collect();
//! let force = Inputs::formulas(&["0.5*cos(1.2*t)"])?; // or `Inputs::sampled`
//! let run = model.simulate(&[1.0, 0.0], &time, &force, &Simulation::adaptive())?;
//! assert_eq!(run.outcome, RunOutcome::Finished); // or where it blew up
//!
//! let rest = Search::new(&[(-2.0, 2.0), (-2.0, 2.0)]).input(&[0.0]).run(&model)?.equilibria;
//! assert_eq!(rest.len(), 3); // x = -1, 0, 1
//! println!("{model:.3}\n{}\n{}", model.to_latex(Some(3)), model.to_rust("duffing")?);
//! assert!(model.to_c("duffing")?.contains("void duffing(const double *state, const double *input, double *out)"));
//! assert_eq!(Model::from_json(&model.to_json()?)?, model);
//! # assert!(rest.iter().any(|e| e.stability == Stability::Saddle));
//! # Ok::<(), sindy::SindyError>(())
//! ```
//!
//! # Comparators
//!
//! What should a sparse model be compared with? With linear ones: [`Dmdc`], and [`Edmdc`] on the same library.
//!
//! ```
//! use sindy::koopman::{Dmdc, Edmdc, Lifting, Rank};
//! use sindy::{Samples, problems};
//!
//! let problem = problems::van_der_pol();
//! let run = problem.clean()?.remove(0);
//! let start = [run.states[0][0], run.states[1][0]];
//! let mut samples = Samples::new(&["x", "y"]);
//! samples.push_group(run.states.clone())?;
//! let linear = Dmdc::new(Rank::Full, 0.0)?.fit(&samples, &["x", "y"], &[], problem.step)?;
//! let lifted = Edmdc::new(problem.library()?, Rank::Full, 0.0)?.fit(&samples, &["x", "y"], &[], problem.step)?;
//!
//! let ahead = 300;
//! let error = |x: &[f64]| (x[ahead] - run.states[0][ahead]).abs();
//! let [a, b] = [linear.simulate(&start, ahead, &[])?, lifted.simulate(&start, ahead, &[], Lifting::EveryStep)?];
//! assert!(error(&b.states[0]) < 0.1 * error(&a.states[0]));
//! # Ok::<(), sindy::SindyError>(())
//! ```
//!
//! The numbered programs in `examples/` go further, each with a figure.
//!
//! # Modules
//!
//! | module | what it is |
//! | --- | --- |
//! | [`dataset`] | trajectories of states and inputs, split at gaps, counted |
//! | [`samples`] | named columns in groups, handed on in blocks |
//! | [`stream`] | samples from an iterator of blocks, in one pass |
//! | [`identify`] | the automatic call: a model with its reason, fronts and certificates |
//! | [`library`] | candidate terms: polynomials, Fourier, products, sums, texts |
//! | [`shift`] | past states as columns, and the next sample for discrete time |
//! | [`savgol`] | Savitzky–Golay smoothing and derivative |
//! | [`gram`] | sufficient statistics: accumulate, merge, downdate |
//! | [`tsqr`] | a mergeable triangular factor for libraries that the Gram matrix loses |
//! | [`regression`] | least squares and its standard errors |
//! | [`residual`] | residuals of a fit, row by row |
//! | [`sr3`] | SR3 with ℓ0, solved at its fixed point |
//! | [`outcome`] | why a solver stopped, one type for all |
//! | [`fit`] | what every sparse solver takes and returns |
//! | [`criteria`] | AIC, AICc, BIC and Bayesian evidence |
//! | [`stlsq`] | sequentially thresholded least squares |
//! | [`stepwise`] | one term more or less at a time, by a criterion |
//! | [`exact`] | the best subset of every size, proven |
//! | [`ensemble`] | bagging of data and library, inclusion and intervals |
//! | [`uncertainty`] | block-bootstrap intervals, bands of predictions and simulations |
//! | [`relaxed`] | SR3 with ℓ1, weights, linear constraints; trimming |
//! | [`choose`] | λ and ν by cross-validation over groups |
//! | [`select`] | one fit of a family, by left-out error or a criterion; folds |
//! | [`identifiability`] | what the data can and cannot tell apart |
//! | [`derivative`] | derivatives: differences, splines, Kalman, spectral; noise level, spikes, gaps, the smoothing chosen |
//! | [`weak`] | the weak form: regression without derivatives, generalised least squares |
//! | [`delay`] | the delay between two channels |
//! | [`shooting`] | refinement by multiple shooting |
//! | [`output_error`] | terms judged by trajectories instead of slopes |
//! | [`koopman`] | linear comparators: DMDc and EDMDc |
//! | [`model`] | models: predict, simulate, Jacobian, equilibria, print, JSON |
//! | [`problems`] | problems with known answers |
//! | [`from_pysindy`] | what PySINDy's names are called here |

pub mod choose;
pub mod criteria;
pub mod dataset;
pub mod delay;
pub mod derivative;
pub mod ensemble;
mod error;
pub mod exact;
pub mod fit;
pub mod from_pysindy;
pub mod gram;
pub mod identifiability;
pub mod identify;
pub mod koopman;
pub mod library;
pub mod model;
mod normal;
pub mod outcome;
pub mod output_error;
pub mod problems;
pub mod regression;
pub mod relaxed;
pub mod residual;
pub mod samples;
pub mod savgol;
pub mod select;
pub mod shift;
pub mod shooting;
pub mod sr3;
pub mod stepwise;
pub mod stlsq;
pub mod stream;
pub mod tsqr;
pub mod uncertainty;
pub mod weak;

pub use choose::{Choice, Grid};
pub use criteria::Criterion;
pub use dataset::Dataset;
pub use derivative::Differentiator;
pub use ensemble::Ensemble;
pub use error::SindyError;
pub use exact::BestSubset;
pub use fit::{Fit, Solver};
pub use gram::Gram;
pub use identify::{Identification, Identify};
pub use koopman::{Dmdc, Edmdc};
pub use library::{Libraries, Library};
pub use model::Model;
pub use outcome::Outcome;
pub use samples::{Block, BlockSource, Samples};
pub use savgol::SavitzkyGolay;
pub use shooting::OdeModel;
pub use sr3::Sr3;
pub use stepwise::Stepwise;
pub use stlsq::Stlsq;
pub use stream::{OwnedBlock, Stream};
pub use weak::WeakForm;
