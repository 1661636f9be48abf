//! Any text is read as a model or refused cleanly; what is read writes and reads back equal, prints,
//! exports, evaluates and runs without panic.
//!
//! Run with `cargo +nightly fuzz run model` in `crates/sindy`.
#![no_main]

use libfuzzer_sys::fuzz_target;
use sindy::model::{Inputs, Limits, Model, Search, Simulation, Time};

fuzz_target!(|text: &str| {
    let Ok(model) = Model::from_json(text) else {
        return;
    };
    let written = model
        .to_json()
        .expect("a model that was read can be written");
    let back = Model::from_json(&written).expect("what was written reads back");
    assert_eq!(back, model);
    assert_eq!(back.to_json().as_ref(), Ok(&written));

    let _ = (
        format!("{model:#.3}"),
        model.to_string(),
        model.to_latex(Some(3)),
    );
    model.to_c("f").expect("a good name");
    model.to_rust("f").expect("a good name");

    let (n, m) = (model.states().len(), model.inputs().len());
    // Work grows with the cube of the number of states; a few show as much as many.
    if n > 8 || m > 8 || written.len() > 4096 {
        return;
    }
    let columns = vec![[0.75, -0.5]; n + m];
    let columns: Vec<&[f64]> = columns.iter().map(|c| c.as_slice()).collect();
    model.predict(&columns).expect("the columns fit");
    let (state, input) = (vec![0.75; n], vec![-0.5; m]);
    let (a, b) = model
        .jacobian()
        .expect("exists")
        .at(&state, &input)
        .expect("the row fits");
    assert_eq!((a.nrows(), b.ncols()), (n, m));
    Search::new(&vec![(-1.0, 2.0); n])
        .input(&input)
        .starts(3)
        .run(&model)
        .expect("the box fits");
    match model.time() {
        Time::Discrete { .. } => {
            let inputs = vec![[0.5; 10].as_slice(); m];
            model
                .iterate(&state, 10, &inputs, &Limits::default())
                .expect("all fits");
        }
        Time::Continuous => {
            let inputs = Inputs::constant(&input).expect("finite");
            let how = Simulation::adaptive().step_limit(100);
            model
                .simulate(&state, &[0.0, 0.5, 1.0], &inputs, &how)
                .expect("all fits");
        }
    }
});
