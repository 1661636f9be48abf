use std::time::Instant;
use touchdown::experiments::{ground_effect, landing, thrust};
use touchdown::identify::{Origin, settings::GroundEffectForm};
use touchdown::pilot::Cards;
use touchdown::progress::Silent;
use touchdown::settings::*;
fn main() {
    let mut s = ReproduceSettings::default();
    s.seed = std::env::args()
        .nth(1)
        .and_then(|s| s.parse().ok())
        .unwrap_or(1);
    let t0 = Instant::now();
    let o = Origin::default();
    let th = thrust::run(&s, &o, &Silent).unwrap();
    for p in &th {
        for (m, r) in thrust::MODELS.iter().zip(&p.runs) {
            println!(
                "plate {} {m} {:?}",
                p.plate_present,
                r.iter()
                    .map(|r| (r.errors.mae, r.errors.worst))
                    .collect::<Vec<_>>()
            );
        }
    }
    println!("{:?}", t0.elapsed());
    let card = &th[1].models[0].card;
    let ge = ground_effect::run(&s, card, &o, &Silent).unwrap();
    println!("{:?}", t0.elapsed());
    for (k, set) in ge.sets.iter().enumerate() {
        for (m, f) in GroundEffectForm::ALL.iter().enumerate() {
            println!(
                "{} {} {:?}",
                set.name,
                f.name(),
                touchdown_sim::rig_sets::VALIDATION_KINDS.map(|kind| ge
                    .pooled(k, m, kind)
                    .map(|e| (e.mae * 1e4).round() / 1e4)
                    .unwrap())
            );
        }
    }
    let cards = Cards {
        thrust: card.clone(),
        empirical: ge.card(1, GroundEffectForm::Empirical).unwrap().clone(),
        dynamic: ge.card(1, GroundEffectForm::Lag).unwrap().clone(),
    };
    let l = landing::run(&s, &cards, &Silent).unwrap();
    for (n, ms) in [
        ("ground", &l.ground),
        ("with", &l.with_acceleration),
        ("without", &l.without_acceleration),
    ] {
        for m in ms {
            println!(
                "{n} {} landed {} T {:?} V {:?} S {:?} H {:?}",
                m.method.name(),
                m.figures.landed,
                m.figures.t_l_s.map(|s| (s.mean, s.sd)),
                m.figures.v_l_mps.map(|s| s.mean),
                m.figures.s_l_m.map(|s| s.mean),
                m.figures.hover_height_m.map(|s| s.mean)
            );
        }
    }
    println!("{:?}", t0.elapsed());
}
