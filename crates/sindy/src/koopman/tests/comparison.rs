//! Test of DMDc and EDMDc against a sparse model.

use super::super::*;
use super::samples;
use crate::model::{Inputs, Model, Simulation, Time};
use crate::solve::fit::Solver;
use crate::solve::sr3::Scaling;
use crate::{Gram, SavitzkyGolay, Stlsq, problems};

#[test]
fn prop_a_sparse_model_predicts_better_than_both_and_edmdc_better_than_dmdc() {
    for problem in [problems::van_der_pol(), problems::lotka_volterra()] {
        let record = &problem.noisy(1.0, 7).unwrap()[0];
        let filter = SavitzkyGolay::new(25, 4).unwrap();
        let smooth: Vec<_> = record
            .states
            .iter()
            .map(|x| filter.apply(&record.time, x).unwrap())
            .collect();
        let columns = smooth.iter().map(|s| s.value.clone());
        let slopes = smooth.iter().map(|s| s.derivative.clone());
        let data = samples(
            &["x", "y", "x_dot", "y_dot"],
            vec![columns.chain(slopes).collect()],
        );
        let library = problem.library().unwrap();
        // In the coefficients' own units: on one closed orbit monomials are nearly collinear, and a
        // threshold on scaled coefficients keeps too many.
        let method = Stlsq::new(0.1, 0.0).unwrap().scaling(Scaling::None);
        let xi: Vec<Vec<f64>> = ["x_dot", "y_dot"]
            .iter()
            .map(|target| {
                let gram = Gram::total(&Gram::accumulate(&library, target, &data).unwrap());
                let fit = method.fit(&gram).unwrap();
                fit.coefficients.as_slice().to_vec()
            })
            .collect();
        let sparse =
            Model::from_library(Time::Continuous, &["x", "y"], &[], &library, &xi).unwrap();
        let states = ["x", "y"];
        let linear = Dmdc::new(Rank::Full, 0.0).unwrap();
        let linear = linear.fit(&data, &states, &[], problem.step).unwrap();
        let lifted = Edmdc::new(library, Rank::Full, 0.0).unwrap();
        let lifted = lifted.fit(&data, &states, &[], problem.step).unwrap();

        // From 20 true states of the second half, 2 units of time ahead.
        let truth = &problem.clean().unwrap()[0].states;
        let mut errors = [0.0; 3];
        for from in (2500..4500).step_by(100) {
            let start = [truth[0][from], truth[1][from]];
            let time = &record.time[..=200];
            let how = Simulation::fixed(problem.step);
            let runs = [
                linear.simulate(&start, 200, &[]).unwrap(),
                lifted
                    .simulate(&start, 200, &[], Lifting::EveryStep)
                    .unwrap(),
                sparse
                    .simulate(&start, time, &Inputs::none(), &how)
                    .unwrap(),
            ];
            for (error, run) in errors.iter_mut().zip(runs) {
                assert_eq!(run.outcome, RunOutcome::Finished);
                for (found, truth) in run.states.iter().zip(truth) {
                    let pairs = found.iter().zip(&truth[from..]);
                    *error += pairs.map(|(f, t)| (f - t).powi(2)).sum::<f64>();
                }
            }
        }
        let [linear, lifted, sparse] = errors.map(f64::sqrt);
        assert!(
            sparse < lifted && lifted < linear,
            "{}: {sparse} {lifted} {linear}",
            problem.name
        );
    }
}
