use std::time::Instant;
use touchdown::identify::{self, IdentificationSettings, ground_effect, settings::*, thrust, Origin};
use touchdown::score::Errors;
use touchdown_sim::{rig, rig_sets::{self, Extent}, rig::RigSettings};
fn main() {
    let seed: u64 = std::env::args().nth(1).and_then(|s| s.parse().ok()).unwrap_or(1);
    let rs = RigSettings::default();
    let mut s = IdentificationSettings::default();
    let origin = Origin::default();
    let run = |v: Vec<rig::RigTrial>| -> Vec<_> { v.iter().map(|t| rig::run(&rs, t, seed).unwrap()).collect::<Vec<_>>() };
    let t0 = Instant::now();
    let mut best = None;
    for plate in [true, false] {
        let train = run(rig_sets::thrust_training(plate, Extent::Full));
        let val = run(rig_sets::thrust_validation(plate));
        for refine in [false, true] {
            for win in [11, 21, 41] {
            for full in [false, true] {
 s.sr3.thresholds = if full { vec![0.0] } else {Sr3Settings::default().thresholds};
            s.smoothing.thrust_window = win;
            s.thrust.refine = refine;
            let made = thrust::library(&train, &s, &origin).unwrap();
            let e: Vec<_> = val.iter().map(|t| {
                let p = thrust::predict(&made.card, t).unwrap();
                let truth = t.require("truth_free_air_n").unwrap();
                let e = Errors::of(&p, truth).unwrap();
                (e.mae, e.worst)
            }).collect();
            println!("full {full} plate {plate} refine {refine} win {win} eq8 {e:.4?} terms {} rmse {:.4} {:?}", made.card.terms.len(), made.rmse, t0.elapsed());
            if refine && win == 21 && full {
 let m=touchdown_sim::plant::Plant::new(&rs.plant).unwrap(); let th=made.card.thrust_model().unwrap(); for k in 0..13 { let sg=0.2+0.05*k as f64; print!("{sg:.2} {:.4} ", th.rest(sg).powi(2)-m.motor().rest(sg).powi(2)); } println!(); best = Some(made.card.clone()); }
            }}
        }
        s.smoothing.thrust_window = 21;
        let made = thrust::first_order(&train, &s, &origin).unwrap();
        let e: Vec<_> = val.iter().map(|t| {
            let p = thrust::predict(&made.card, t).unwrap();
            let e = Errors::of(&p, t.require("truth_free_air_n").unwrap()).unwrap();
            (e.mae, e.worst)
        }).collect();
        println!("plate {plate} eq7 {e:.4?} {:?} {:?}", made.lag_s, t0.elapsed());
    }
    let card = best.unwrap();
    println!("{}", card.to_toml().unwrap().lines().filter(|l| l.starts_with("value") || l.starts_with("expr")||l.starts_with("std")).collect::<Vec<_>>().join(" "));
    let motor = touchdown_sim::plant::Plant::new(&rs.plant).unwrap().motor().clone();
    let val: Vec<_> = run(rig_sets::ground_effect_validation(&motor, Extent::Full)).iter().map(|t| ground_effect::prepare(t, &card).unwrap()).collect();
    for rich in [false, true] {
        let mut set = rig_sets::ground_effect_paper(Extent::Full);
        if rich { set = rig_sets::ground_effect_rich(Extent::Full); }
        let train: Vec<_> = run(set).iter().map(|t| ground_effect::prepare(t, &card).unwrap()).collect();
        println!("trials {} {:?}", train.len(), t0.elapsed());
        let b = ground_effect::before::examine_trials(&train, &s).unwrap();
        println!("before cond {:.1} infl {:.1} delay {:?} advice {:#?}", b.library.condition, b.lag_inflation, b.force_delay_s, b.advice);
        for form in GroundEffectForm::ALL {
            let made = ground_effect::fit(form, &train, &s, &origin).unwrap();
            print!("rich {rich} {form:?} rmse {:.4} lag {:?} ", made.rmse, made.lag_s);
            for kind in rig_sets::VALIDATION_KINDS {
                let e: Vec<_> = val.iter().filter(|t| t.name.starts_with(&format!("{kind}-"))).map(|t| Errors::of(&ground_effect::predict(&made.card, t).unwrap(), t.truth_n.as_ref().unwrap()).unwrap()).collect();
                let p = Errors::pool(&e).unwrap();
                print!("{kind} {:.4}/{:.3} ", p.mae, p.worst);
            }
            println!("{:?}", t0.elapsed());
            println!("   {:?}", made.card.terms.iter().map(|t| format!("{} {} {:.4}±{:.4}", t.of, t.expression, t.value, t.std_error.unwrap_or(f64::NAN))).collect::<Vec<_>>());
            println!("   {:?} {:?}", made.warnings, made.card.provenance.method);
        }
    }
    let _ = identify::Made::clone;
}
